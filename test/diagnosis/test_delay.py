"""Stamps of wrenches and joint states that lie apart: named where the motion tells them."""

import random
import re
from functools import cache
from itertools import takewhile

import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.sim.measure import measure
from recorded_faults import BAGS, Filtered, in_base, samples, spoilt, without_weight
from simulated import truth
from tiers import nightly

# Slides, slips, turns back, comes to rest, lets go, and closes once more [s].
ALL = 10.3


@cache
def measured(seed):
    """Return what sensors of that noise read of the working cycle, as far as into the hole."""
    read = measure(truth("working_cycle"), seed)
    first = next(read)
    return [first, *takewhile(lambda each: each.t_ns - first.t_ns < ALL * 1e9, read)]


def late(recorded, milliseconds):
    """Return samples in the order of their stamps, wrenches stamped later by that."""

    def stamped(sample):
        if isinstance(sample, WrenchSample):
            return sample._replace(t_ns=sample.t_ns + round(milliseconds * 1e6))
        return sample

    return sorted(map(stamped, recorded), key=lambda each: each.t_ns)


def causes_of(recorded, **parameters):
    line = Pipeline(from_parameters(parameters), offline=True)
    for _ in line.play(recorded):
        if line.causes:
            break
    return line.causes


def delay_of(cause):
    """Return the delay that a cause names [ms]."""
    found = re.match(r"wrench: .* of the same moment.*: set joints\.delay: ([-\d.]+);", cause)
    assert found, cause
    return float(found[1]) * 1e3


@pytest.mark.parametrize("count", [1, pytest.param(10, marks=pytest.mark.nightly)])
def test_a_delay_that_was_drawn_is_the_first_hint(count):
    """Right in nine of ten, and never of the other sign."""
    rng, right = random.Random(47), 0
    for seed in range(count):
        drawn = rng.choice((-1, 1)) * rng.choice((10, 20, 50))
        causes = causes_of(late(measured(seed), drawn))
        if causes:
            found = -delay_of(causes[0])
            assert found * drawn > 0.0
            right += abs(found - drawn) < 0.3 * abs(drawn) + 2.0
    assert right >= 0.9 * count


@pytest.mark.nightly
def test_it_says_what_comes_behind_what():
    (cause,) = causes_of(late(samples(BAGS[2]), 20.0))
    assert "wrenches come some" in cause and "or behind a low-pass of" in cause
    (cause,) = causes_of(late(samples(BAGS[2]), -20.0))
    assert "joint states come some" in cause and "low-pass" not in cause


@pytest.mark.nightly
def test_a_delay_that_is_stated_is_none():
    stated = {"joints.delay": -0.02}
    # Longer than any takes to be named.
    assert causes_of(late(samples(BAGS[2], end=6.0), 20.0), **stated) == []
    (cause,) = causes_of(samples(BAGS[2]), **stated)
    # None would fit.
    assert abs(delay_of(cause)) < 5.0


@pytest.mark.parametrize(
    ("change", "stated"),
    [
        pytest.param(in_base, {"wrench.axes": "base"}, marks=pytest.mark.nightly),
        pytest.param(without_weight, {"wrench.gravity": "compensated"}, marks=pytest.mark.nightly),
    ],
)
def test_a_delay_is_told_of_wrenches_in_other_axes_and_without_weight(change, stated):
    recorded = list(spoilt(samples(BAGS[2]), change))
    assert causes_of(recorded, **stated) == []
    (cause,) = causes_of(late(recorded, -20.0), **stated)
    assert delay_of(cause) == pytest.approx(20.0, abs=5.0)


@pytest.mark.parametrize("milliseconds", [-10, *nightly(-30, -5, 5, 10, 30)])
def test_a_delay_is_named_to_2_ms_or_not_at_all(milliseconds):
    """Joint states of a shipped bag, so late; a delay of 5 ms is within what a second shows."""
    for cause in causes_of(late(samples(BAGS[2]), -milliseconds)):
        # Told in whole milliseconds.
        assert delay_of(cause) == pytest.approx(milliseconds, abs=2.5)


def test_one_second_of_slip_names_no_delay():
    """What it shows has to explain another one."""
    assert causes_of(late(samples(BAGS[2], end=4.0), -30.0)) == []


@pytest.mark.nightly
def test_a_delay_that_the_next_second_contradicts_is_not_named():
    found = samples(BAGS[2], end=6.0)
    # Where the first second of slip ends.
    begins = found[0].t_ns + 4_500_000_000
    halves = [[s for s in found if (s.t_ns < begins) == first] for first in (True, False)]
    assert causes_of([*late(halves[0], -30.0), *late(halves[1], 10.0)]) == []


@pytest.mark.parametrize("milliseconds", [-50, 20, *nightly(-20, 50)])
def test_a_steady_motion_does_not_tell_it(milliseconds):
    for path in BAGS[:2]:
        assert causes_of(late(samples(path), milliseconds)) == []


def test_a_low_pass_is_named_before_the_delay_that_it_makes():
    causes = causes_of(list(spoilt(samples(BAGS[2]), Filtered(20.0))))
    assert causes[0].startswith("wrench: low-pass: ")


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(100, 140))
def test_nothing_is_said_of_what_is_right(seed):
    assert causes_of(measured(seed)) == []
