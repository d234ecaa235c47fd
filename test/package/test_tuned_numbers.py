"""Tuned numbers: each is listed once, with its unit and its reason, as the page has it."""

import ast
import importlib
import inspect
from math import isfinite

import pytest

from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.numba_cache import PACKAGE_FOLDER
from peg_on_hole_ros.tuned_numbers import TunedNumbers, listed, tuned_numbers
from scripts import loaded
from simulated import ROOT

ROOMS = TunedNumbers._fields[1:]
NUMBERS = tuned_numbers()


def subjects_of(module):
    """Return the classes of a room that have numbers, and no other subjects."""
    own = [
        each
        for _, each in inspect.getmembers(module, inspect.isclass)
        if each.__module__ == module.__name__
    ]
    return {each for each in own if not each.__name__.endswith("Numbers")}


@pytest.mark.parametrize("room", ROOMS)
def test_every_subject_of_a_room_is_in_its_record(room):
    module = importlib.import_module(f"peg_on_hole_ros.{room}.tuned")
    found = getattr(NUMBERS, room)
    assert set(map(type, found)) == subjects_of(module)
    for field, values in zip(found._fields, found):
        # What compiled code reads is what is listed.
        assert getattr(module, field.upper()) is values


def test_every_number_has_a_unit_and_a_reason():
    lines = listed(NUMBERS)
    assert len({line.name for line in lines}) == len(lines)
    for line in lines:
        values = line.value if isinstance(line.value, tuple) else (line.value,)
        assert all(map(isfinite, values)), line.name
        assert len(line.unit) > 0 and len(line.reason.split()) > 1, line.name


def test_settings_are_listed_as_they_are_shipped():
    values = {line.name: line.value for line in listed(NUMBERS)}
    assert values["settings.mode_stddev"] == (3.0, 30.0, 500.0)
    assert values["settings.passes"] == 4
    changed = listed(NUMBERS._replace(settings=default_settings(passes=2)))
    assert {line.name: line.value for line in changed}["settings.passes"] == 2
    # What a reduced estimator leaves out is no number that was tuned.
    assert not {"settings.inertia", "settings.modes"} & set(values)


def test_a_number_without_a_unit_is_refused():
    class Unexplained(type(NUMBERS.engine.tare)):
        """
        Nothing much.

        Attributes
        ----------
        least_ns : int
            How long.

        """

    engine = NUMBERS.engine._replace(tare=Unexplained())
    with pytest.raises(ValueError, match=r"engine\.tare\.least_ns: .* no \[unit\]"):
        listed(NUMBERS._replace(engine=engine))


def test_the_page_of_tuned_numbers_is_that_of_the_sources():
    tables = loaded(ROOT / "tools" / "tuned_table.py")
    page = tables.PAGE.read_text(encoding="utf-8")
    assert tables.written(page) == page, "python tools/tuned_table.py"


# Numbers of modules that nobody chose by trying, and what they are.
NOT_TUNED = {
    "engine/ring": {"_NONE": "no place"},
    "engine/snapshots": {"_NO_SNAPSHOT": "no snapshot"},
    "engine/state": {"ORIENTATION_WIDTH": "columns"},
    "engine/still_poses": {"_INTERVAL": "of a normal distribution"},
    "measurements/innovations": {"EXPECTED MEDIAN": "of a chi-squared variable"},
    "measurements/orientation": {"ROW": "columns"},
    "estimator/accuracy_record": {
        "GAINS CROSSTALKS PLACES AXES PAYLOADS TILTS DIAMETERS LAG": "places",
        "SOURCES ROWS OF_FRICTION": "places",
    },
    "estimator/contact_sets/free": {"SOLVED_REACTIONS": "contacts"},
    "estimator/contact_sets/three_on_rim": {"SOLVED_REACTIONS": "contacts"},
    "estimator/contact_sets/two_in_hole": {"SOLVED_REACTIONS": "contacts"},
    "estimator/contact_sets/unknown": {"SOLVED_REACTIONS": "contacts"},
    "estimator/orientation_noise": {"FIRST_DIFFERENCE THIRD_DIFFERENCE": "of white noise"},
    "estimator/settings": {"MOST_MODES": "room in a record"},
    "estimator/sigma_points": {"_MEANS_WEIGHT": "of a normal distribution"},
    "estimator/snapshot": {"WORD": "bytes"},
    "estimator/state": {
        "ANGLE RATE ACCELERATION FRICTION OPEN_BEGIN": "places in the state",
        "MOST_HYPOTHESES": "room in a record",
    },
    "estimator/wrench_update": {"_GRAVITY": "a constant of nature", "_EQUATIONS": "equations"},
    "identification/outliers": {"_LINES": "pairs of neighbours"},
    "identification/quantities": {
        "TYPICAL_FORCE TYPICAL_DIAMETER": "what the table of quantities is stated for",
        "DELAY_AT CLEARANCE_AT FRICTION_AT": "places among them",
    },
    "identification/selection": {"NORMAL_95": "of a normal distribution"},
    "monitor/alarm_text": {"ANY ALL PLAIN HOLE": "places in tables"},
    "monitor/contact_probabilities": {"COUNT": "hypotheses"},
    "monitor/one_point": {"COUNT": "hypotheses"},
    "monitor/output_row": {"NOT_JUDGED": "a name"},
    "monitor/trend": {"LARGEST": "bound of what squares are finite of"},
    "diagnosis/guarded_looks": {"_MOST": "characters of a text"},
    "diagnosis/hypotheses": {"_KN _N_MM _KN_M": "units"},
    "diagnosis/setting_fit": {"COORDINATES": "how many", "_TINY": "against division by zero"},
    "diagnosis/suspected/rim_motion": {"_VALUES": "how many"},
    "diagnosis/suspected/unobservable": {"_FRICTION _CLEARANCE _GAMMA _LEVER": "places"},
}


def numbers_of(path):
    """Yield the names that a module gives to numbers as they are written."""
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        for target in targets:
            pairs = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs = list(zip(target.elts, node.value.elts, strict=True))
            yield from (name.id for name, value in pairs if is_number(value))


def is_number(value):
    """Return whether an expression is numbers alone, and what is calculated or made of them."""
    parts = list(ast.walk(value))
    written = [part.value for part in parts if isinstance(part, ast.Constant)]
    plain = ast.Constant, ast.UnaryOp, ast.unaryop, ast.BinOp, ast.operator, ast.Tuple, ast.Load
    return all(isinstance(part, plain) for part in parts) and any(
        isinstance(each, int | float) and not isinstance(each, bool) for each in written
    )


@pytest.mark.parametrize("room", ROOMS)
def test_numbers_of_a_room_are_tuned_or_listed_here_with_what_they_are(room):
    found = {}
    for path in sorted((PACKAGE_FOLDER / room).rglob("*.py")):
        if names := set(numbers_of(path)):
            found[path.relative_to(PACKAGE_FOLDER).with_suffix("").as_posix()] = names
    listed_here = {
        module: {name for names in of for name in names.split()}
        for module, of in NOT_TUNED.items()
        if module.partition("/")[0] == room
    }
    assert found == listed_here


def test_a_number_of_a_module_is_found_however_it_is_written(tmp_path):
    module = tmp_path / "module.py"
    lines = "A, B = 1.0, D", "E: float = -2 * 3.0", "F = (0.1, 0.2)", "g = f(0.5)", "H = 'a'"
    module.write_text("\n".join(lines))
    assert list(numbers_of(module)) == ["A", "E", "F"]
