"""What a live page is told of a node, whatever arrives together."""

from types import SimpleNamespace

import numpy as np
import pytest

from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE
from peg_on_hole_ros.messages.plain import header
from peg_on_hole_ros.records import ANGLES, CONTACTS
from peg_on_hole_ros.watch.page_updates import DIAGNOSTICS_TOPIC, WHOLE, PageUpdates

MS = 1_000_000
SCENE = Scene()
OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"


def state(k):
    return _message(k, ANGLES, [0.2 - 1e-3 * k, 0.0, 0.0], [])


def contacts(k, load):
    return _message(k, CONTACTS, [1.0] * 3, [load, 20.0, 20.0])


def _message(k, names, position, effort):
    fields = {"name": list(names), "position": position, "velocity": [], "effort": effort}
    return Encoder(JOINTS_TYPE)({"header": header(k * MS), **fields})


def told(frames, **arrived):
    none = dict.fromkeys((*WHOLE, "contact_mode", "alarms"), [])
    return frames.frame(none | arrived, {}, SCENE)


@pytest.mark.parametrize("together", [True, False])
def test_no_load_is_lost_where_it_arrives_after_its_state(together):
    """A slow sensor's wrench, or the last one: no other state comes beside its contacts."""
    frames = PageUpdates()
    for k in range(1, 6):
        load = 30.0 + k
        if together:
            told(frames, state=[state(k)], contacts=[contacts(k, load)])
            continue
        told(frames, state=[state(k)])
        last = told(frames, contacts=[contacts(k, load)])
        assert last["lines"]["K"] == [[pytest.approx((k - 1) * 1e-3), load]]
    loads = [v for frame in frames.kept for _, v in frame["lines"].get("K", [])]
    assert loads == [31.0, 32.0, 33.0, 34.0, 35.0]
    # And what is drawn is of both, in every frame from the first load on.
    drawn = [frame["moment"] for frame in list(frames.kept)[1:]]
    assert all(moment["K"] is not None and moment["gamma"] is not None for moment in drawn)


def test_nothing_is_told_before_the_first_state():
    frames = PageUpdates()
    assert "t" not in told(frames, contacts=[contacts(1, 30.0)])
    assert told(frames, state=[state(2)])["anew"]


def test_stamps_that_fall_begin_anew_without_the_loads_of_before():
    frames = PageUpdates()
    told(frames, state=[state(100)], contacts=[contacts(100, 30.0)])
    begun = told(frames, state=[state(1)])
    assert begun["anew"] and len(frames.kept) == 1
    assert begun["moment"]["K"] is None
    assert np.isclose(begun["moment"]["gamma"], 0.199)


def diagnostics(*entries):
    """Return a /diagnostics of level, name and message."""
    names = "level", "name", "message"
    made = [SimpleNamespace(**dict(zip(names, entry))) for entry in entries]
    return SimpleNamespace(status=made)


def test_what_the_diagnostics_suspect_comes_in_its_parts_and_errors_first():
    frames = PageUpdates("/cell/peg_on_hole")
    sign = (
        "wrench: the sign of the wrench is reversed: set wrench.acts_on: robot; with it the "
        "forces balance to 0.28 N instead of 7.3 N"
    )
    report = diagnostics(
        (WARN, "cell/peg_on_hole: input", "no messages of joints: check topic names"),
        (OK, "cell/peg_on_hole: timing", "keeping up"),
        (ERROR, "cell/peg_on_hole: filter", sign),
        # Of another node.
        (ERROR, "other/peg_on_hole: filter", "no estimate"),
    )
    filter_, input_ = told(frames, **{DIAGNOSTICS_TOPIC: [report]})["causes"]
    assert filter_ == {
        "about": "filter",
        "level": "ERROR",
        "headline": "the sign of the wrench is reversed",
        "lines": [
            "Set wrench.acts_on: robot",
            "With it the forces balance to 0.28 N instead of 7.3 N",
        ],
    }
    assert (input_["about"], input_["level"]) == ("input", "WARN")
    # Gone, it is withdrawn; of other nodes alone nothing is said.
    alone = diagnostics((ERROR, "other/peg_on_hole: filter", "no estimate"))
    assert "causes" not in told(frames, **{DIAGNOSTICS_TOPIC: [alone]})
    well = diagnostics((OK, "cell/peg_on_hole: filter", "running"))
    assert told(frames, **{DIAGNOSTICS_TOPIC: [well]})["causes"] == []
