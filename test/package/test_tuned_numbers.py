"""Tuned numbers: each is listed once, with its unit and its reason, as the page has it."""

import importlib
import inspect
from math import isfinite

import pytest

from peg_on_hole_ros.estimator.settings import default_settings
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
