"""The registry of dangers: each of them has its advice, its output and its place in the alarm."""

from importlib import import_module
from math import nan
from typing import get_type_hints

import numpy as np
import pytest

from peg_on_hole_ros.monitor.alarm_text import alarms_of
from peg_on_hole_ros.monitor.alarms import Alarms, clear_alarms
from peg_on_hole_ros.monitor.dangers.registry import (
    ADVICE,
    IN_HOLE_OUTPUTS,
    ON_RIM_OUTPUTS,
    OUTPUTS,
    PARTS,
    Danger,
    Dangers,
    fill_dangers,
    likeliest,
    parts,
    put_numbers,
)
from peg_on_hole_ros.monitor.output_row import MONITOR_NAMES, NOTHING
from peg_on_hole_ros.outputs import AlarmRow, Row
from peg_on_hole_ros.typed_record import at, dtype_of, new


def test_each_danger_has_its_advice_and_each_part_its_output():
    assert len(ADVICE) == len(Danger) and all(len(each) == 2 for each in ADVICE)
    texts = [text for each in ADVICE for text in each]
    assert len(set(texts)) == len(texts) == sum(map(bool, texts))
    outputs = [name for name in MONITOR_NAMES if name.startswith("jamming_")]
    assert sorted((*PARTS, "jamming_risk")) == sorted(outputs)
    assert set(OUTPUTS) <= set(MONITOR_NAMES)
    assert len(parts(new(Dangers))) == len(PARTS)
    (room,) = dtype_of(AlarmRow)["numbers"].shape
    # `put_numbers` fills in one more than ON_RIM_OUTPUTS has.
    assert max(len(ON_RIM_OUTPUTS) + 1, len(IN_HOLE_OUTPUTS)) <= room


@pytest.mark.parametrize("danger", Danger)
def test_the_likeliest_danger_is_the_one_the_alarm_speaks_of(danger):
    dangers = new(Dangers)
    name = danger.name.lower()
    assert name in get_type_hints(Dangers)
    getattr(dangers, name).probability = 0.9
    assert likeliest(dangers) == danger
    own = import_module(f"peg_on_hole_ros.monitor.dangers.{name}").ADVICE
    alarms = new(Alarms)
    clear_alarms(alarms)
    for level in (1, 2):
        row = alarms.published[0]
        row.level, row.which, row.kind = level, danger, 1
        assert alarms_of(alarms.published, nan, nan)[0].message == own[level - 1]


@pytest.mark.parametrize(("insertion", "names"), [(0.0, ON_RIM_OUTPUTS), (0.2, IN_HOLE_OUTPUTS)])
def test_the_alarm_has_the_numbers_that_are_published(insertion, names):
    dangers, numbers, rows = new(Dangers), np.zeros(7), NOTHING.copy()
    dangers.stuck.insertion, dangers.stuck.margin = insertion, 3.0
    dangers.wedging.determinant, dangers.risk = 0.7, 0.6
    dangers.load.probability = 0.3
    if insertion:
        dangers.stuck.wedged, dangers.stuck.rests = 0.1, 0.2
    else:
        dangers.wedging.probability, dangers.stall.probability = 0.1, 0.2
    put_numbers(dangers, numbers)
    fill_dangers(dangers, at(Row, rows))
    expected = {
        "jamming_wedging": 0.1, "jamming_stall": 0.2, "jamming_load": 0.3, "jamming_risk": 0.6,
        "determinant": 0.7, "insertion_ratio": 0.2, "whitney_margin": 3.0,
    }  # fmt: skip
    for name, number in zip(names, numbers):
        assert rows[name][0] == number == expected.get(name, 0.0), name
    for name in set(OUTPUTS) - set(names):
        assert np.isnan(rows[name][0]), name
