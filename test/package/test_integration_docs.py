"""The integration guide keeps up with the code: every count, topic and number of the monitor."""

import re
from collections import Counter

import pytest

from inputs import closing
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameter_table import PARAMETERS
from peg_on_hole_ros.engine import engine, pipeline, processor
from peg_on_hole_ros.engine.arrival_order import COUNTED
from peg_on_hole_ros.engine.state import COUNTS
from peg_on_hole_ros.measurements import orientation, wrench_reduction
from peg_on_hole_ros.messages import decode, stream
from peg_on_hole_ros.messages.beside_estimates import LATCHED, TOPICS
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.monitor.output_row import MONITOR_NAMES
from peg_on_hole_ros.replay import run as replay
from scripts import loaded
from simulated import ROOT

PAGES = "integration", "topics", "alarms", "counts"
TEXT = "\n".join((ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8") for page in PAGES)
QUOTED = set(re.findall(r"`([^`\n]+)`", TEXT))


def literals(module, pattern):
    with open(module.__file__, encoding="utf-8") as source:
        return re.findall(pattern, source.read())


def counts():
    """Names of counts as the sources have them."""
    for module in (pipeline, processor, engine):
        yield from literals(module, r'(?:counts|found)\["(\w+)"\]')
    yield from COUNTS
    yield from COUNTED.values()
    for module in (wrench_reduction, orientation):
        for reason in literals(module, r'(?:return|else) "(\w+)"'):
            yield f"joints_dropped_{reason}"
    # What never reached the pipeline, of either source or, where an error may be, of a service.
    for name in literals(stream, r'\["(wrench_dropped_[a-z]+_[a-z]+)"\]'):
        yield name
    for module in (stream, replay):
        for name in literals(module, r'f"\{(?:source|what)\}(_dropped_\w+)"'):
            for source in ("wrench", "joints"):
                yield f"{source}{name}"
    for service in literals(stream, r'"(\w+)": self\.pipeline\.'):
        yield f"{service}_dropped_internal_error"


def explained(name):
    """Return whether the guide has a name, or its end where that is the same of both sources."""
    source, _, end = name.partition("_")
    short = f"..._{end}" if "malformed" in end else f"{source}_..."
    return name in QUOTED or short in QUOTED


def test_every_count_is_explained():
    found = Counter(counts())
    assert len(found) > 30 and "motion_lost" in found
    ends = "overload", "not_received", "internal_error", "after_last_wrench"
    assert {f"{source}_dropped_{end}" for source in ("wrench", "joints") for end in ends} < set(
        found
    )
    assert "tare_dropped_internal_error" in found
    assert [name for name in found if not explained(name)] == []
    for reason in literals(decode, r'Malformed\("(\w+)"\)'):
        names = {f"..._dropped_malformed_{reason}", f"joints_dropped_malformed_{reason}"}
        assert names & QUOTED, reason


def test_every_topic_is_explained():
    contacts = {"contact/b1": "b1", "contact/b2": "b2"}
    for suffix in TOPICS:
        assert contacts.get(suffix, f"~/{suffix}") in QUOTED, suffix
    assert LATCHED == ("transition", "contact_mode", "alarm_level")


def test_the_tables_that_follow_from_the_sources_do():
    tables = loaded(ROOT / "tools" / "doc_tables.py")
    assert {page.stem for page in tables.PAGES} == {"topics", "integration"}
    for page in tables.PAGES:
        text = page.read_text(encoding="utf-8")
        assert tables.written(page) == text, "python tools/doc_tables.py"
    assert not set(MONITOR_NAMES) - QUOTED


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({}, {"friction", "jamming_risk", "time_to_transition"}),
        (
            {
                "wrench.bias_force_stddev": 0.5,
                "wrench.bias_torque_stddev": 0.005,
                "joints.hole_tilt_stddev": 0.002,
            },
            {"bias_force_x", "bias_torque_z_stddev", "hole_tilt_y"},
        ),
    ],
    ids=["default", "bias_and_tilt"],
)
def test_every_number_of_the_monitor_is_explained(settings, told):
    line, names = message_stream(from_parameters(settings)), set()
    for source, message in closing(300):
        if source == "joints":
            line.on_joints(message)
            continue
        for suffix, _, fields in line.on_wrench(message):
            if suffix == "monitor":
                names |= set(fields["name"])
    assert told <= names
    assert names <= QUOTED


def test_parameters_that_are_named_exist():
    groups = {row.name.split(".")[0] for row in PARAMETERS if "." in row.name}
    names = {row.name for row in PARAMETERS}
    named = {word for word in QUOTED if re.fullmatch(rf"({'|'.join(groups)})\.\w+", word)}
    assert len(named) > 10
    assert named <= names


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("frames", "z of sensor"),
        ("chamfers", "peg_chamfer"),
        ("contacts", "B1, B2"),
        ("mixture", "at rest or steady"),
    ],
)
def test_pictures_are_those_of_the_scripts(tmp_path, name, text):
    pytest.importorskip("matplotlib")
    path = ROOT / "docs" / "figures" / f"{name}.py"
    drawn = loaded(path).draw(tmp_path).read_text(encoding="utf-8")
    committed = path.with_suffix(".svg").read_text(encoding="utf-8")
    texts = re.compile(r"<text[^>]*>([^<]+)</text>")
    assert texts.findall(drawn) == texts.findall(committed)
    assert text in texts.findall(drawn)
