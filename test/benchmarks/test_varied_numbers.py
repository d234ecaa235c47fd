"""Tuned numbers that are varied: read from memory by compiled code, and what each changes."""

from typing import NamedTuple

import pytest
from numba import njit

from benchmarks.tuned_numbers import memory
from benchmarks.tuned_numbers.player import AT_IMPORT, CHANGED, NOT_READ, SAME, Asked, Beside
from benchmarks.tuned_numbers.scenes import came_of
from benchmarks.tuned_numbers.tuned_numbers import SHIPPED, Varied, report, rows, values

SNAP = "identification.hand_press.snap"
NOISY = "measurements.wrench_noise_test.noisy"
MIXING = "estimator.mixture_weights.longest_mixing"
SETTING = "settings.mode_stddev[1]"


class Sums(NamedTuple):
    count: int = 3
    part: float = 0.5
    other: float = 9.0
    several: tuple[float, ...] = (1.0, 2.0, 4.0)


RECORDS = {"SUMS": Sums(), "NAME": "no record"}
memory.stand_in("made_up", RECORDS)
SUMS = RECORDS["SUMS"]


@njit
def total(x):
    found, chosen = 0.0, SUMS
    for _ in range(chosen.count):
        found += SUMS.part * x
    return found if x < 10.0 else SUMS.other


def test_compiled_code_reads_numbers_from_memory_and_marks_them():
    memory.read_since()
    assert total(2.0) == 3.0
    assert memory.read_since() == {"made_up.sums.count", "made_up.sums.part"}
    SUMS.count, SUMS.part = 5, 2.0
    assert total(2.0) == 20.0 and len(total.signatures) == 1
    SUMS.count, SUMS.part = 3, 0.5
    assert total(2.0) == 3.0 and SUMS.part == 0.5
    assert memory.read_since() == {"made_up.sums.count", "made_up.sums.part"}


def test_half_and_twice_a_number_are_of_its_type():
    assert values(0.5) == [0.25, 1.0] and values(0.0) == []
    assert [(x, type(x)) for x in values(5)] == [(2, int), (10, int)]


@njit
def weighed(x):
    return x * SUMS.several[0] + SUMS.several[2]


def test_several_numbers_are_one_field():
    memory.read_since()
    assert weighed(3.0) == 7.0 and SUMS.several == (1.0, 2.0, 4.0)
    SUMS.several = 2.0, 3.0, 5.0
    assert weighed(3.0) == 11.0 and memory.read_since() == {"made_up.sums.several"}
    SUMS.several = 1.0, 2.0, 4.0


@pytest.fixture
def beside(tmp_path):
    beside = Beside(tmp_path)
    yield beside
    beside.close()


def test_a_scene_in_the_copy_is_that_of_the_package_until_a_number_changes(beside, tmp_path):
    ours = came_of("presses", tmp_path)
    assert beside.ask(Asked("presses"))["digest"] == ours.digest
    changed = beside.ask(Asked("presses", SNAP, 1.0))
    assert changed["outcome"] == CHANGED
    assert changed["figures"]["turned [degrees]"] == 0.0 != ours.figures["turned [degrees]"]
    assert beside.ask(Asked("presses", SNAP, 21.0))["outcome"] == SAME
    assert beside.ask(Asked("presses", NOISY, 9.0))["outcome"] == NOT_READ
    most = "identification.hand_press.most_miss"
    assert "degrees off three right angles" in beside.ask(Asked("presses", most, 0.1))["what"]
    assert beside.ask(Asked("presses"))["digest"] == ours.digest


@pytest.mark.nightly  # It compiles the copy.
def test_an_estimate_in_the_copy_is_that_of_the_package_bit_for_bit(beside, tmp_path):
    ours = came_of("closing", tmp_path)
    assert beside.ask(Asked("closing"))["digest"] == ours.digest
    for number, value in ((MIXING, 1e-4), (SETTING, 300.0)):
        assert beside.ask(Asked("closing", number, value))["outcome"] == CHANGED, number
    assert beside.ask(Asked("closing", NOISY, 2.5))["outcome"] == SAME
    assert beside.ask(Asked("closing", SNAP, 1.0))["outcome"] == NOT_READ
    window = "measurements.innovation_window.mode_count"
    assert beside.ask(Asked("closing", window, 10))["outcome"] == AT_IMPORT
    assert beside.ask(Asked("closing"))["digest"] == ours.digest


def test_each_value_is_told_by_the_largest_change():
    same, unread = {"outcome": SAME}, {"outcome": NOT_READ}

    def changed(**figures):
        return {"outcome": CHANGED, "figures": {"wrong flags": 0, "determined": 0.9} | figures}

    found = [
        (SHIPPED, {"a": changed(), "b": changed()}),
        (Varied(SNAP, 10.0), {"a": changed(determined=0.8), "b": changed(determined=0.97)}),
        (Varied(SNAP, 40.0), {"a": same, "b": unread}),
        (Varied(NOISY, 1.125), {"a": changed(determined=0.901), "b": same}),
        (Varied(NOISY, 4.5), {"a": unread, "b": unread}),
        (Varied(MIXING, 0.001), {"a": {"outcome": "ended", "what": "it ended"}, "b": same}),
        (Varied(MIXING, 0.004), {"a": same, "b": changed(**{"wrong flags": 1})}),
    ]
    told = {(row.number, row.value): row for row in rows(found)}
    assert [row.effect for row in told.values()] == [
        "figures", "nothing", "little", "never read", "fails", "figures",
    ]  # fmt: skip
    first = told[SNAP, 10.0]
    assert first.most == {"determined": (pytest.approx(-0.1), "a")} and first.changed == 2
    assert told[MIXING, 0.001].texts == ["a: it ended"]
    made = report(found, None)
    assert (
        f"| figures (1) | `{SNAP}` |" in made.text and f"| fails (1) | `{MIXING}` |" in made.text
    )
    shown = [line for line in made.text.splitlines() if line.startswith("| not run")]
    assert len(shown) == 1 and "`settings.*`" in shown[0] and SNAP not in shown[0]
    one = report(found[:2], None).text
    assert f"| figures (1) | `{SNAP}` (one value) |" in one
    assert f"| little (1) | `{NOISY}` |" in made.text and len(made.csv["numbers"]) == 7
