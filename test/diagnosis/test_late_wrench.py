"""Wrenches that come once more under fresh stamps: told as late, and nothing rests on them."""

import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from recorded_faults import BAGS, from_zero, is_wrench
from tiers import nightly

MS = 1_000_000
UNTIL = 3.6


def recorded(end=UNTIL):
    """Return samples of the working cycle, which touches down at 1.2 s, from stamp 0 on."""
    return from_zero(BAGS[2], end)


def late(found, by, begin, end):
    """Return samples whose wrenches of a time are those of before, all in milliseconds."""
    then = {s.t_ns: s for s in found if is_wrench(s)}

    def of(sample):
        if not (is_wrench(sample) and begin * MS <= sample.t_ns < end * MS):
            return sample
        return then[sample.t_ns - by * MS]._replace(t_ns=sample.t_ns)

    return [of(sample) for sample in found]


def played(found):
    line = Pipeline(from_parameters({}))
    return line, list(line.play(found))


def determined(outputs, begin, end):
    """Return whether reactions are determined in each output of a time [ms]."""
    some = [o for o in outputs if begin * MS <= o.t_ns < end * MS]
    return [bool(o.monitor["reactions_determined"]) for o in some]


@pytest.mark.parametrize(
    ("by", "begin", "end"), [(300, 1000, 3000), *nightly((80, 1000, 3000), (300, 2000, 2700))]
)
def test_wrenches_that_come_again_are_told_as_late(by, begin, end):
    line, outputs = played(late(recorded(), by, begin, end))
    (cause,) = line.causes
    assert cause.startswith(
        f"wrench: wrenches come late, by {by / 1e3:g} s: from {begin / 1e3:.3f} s on"
    )
    # 20 wrenches at 1 kHz, and a look every 20 ms.
    assert not any(determined(outputs, begin + 40, end))
    # Innovations of a tenth of a second, and three looks of a motion that fits.
    assert all(determined(outputs, end + 250, UNTIL * 1e3))


def test_nothing_of_a_contact_is_told_while_wrenches_are_late():
    _, outputs = played(late(recorded(), 300, 1000, 3000))
    modes = {o.contact_mode for o in outputs if 1040 * MS <= o.t_ns < 3000 * MS}
    assert modes <= {"open", "unknown"}


def test_a_motion_that_fits_for_long_shows_that_wrenches_are_in_time_again():
    """Nothing refutes them, as they were late in free air alone."""
    _, outputs = played(late(recorded(), 100, 900, 1100))
    # The peg turns by less than 0.5 mrad in a look until 1.8 s. The sample has a gap at 3.01 s.
    assert not any(determined(outputs, 1200, 2500)) and all(determined(outputs, 3020, 3600))


def test_a_recording_that_is_played_once_more_has_no_late_wrenches():
    found = recorded(0.7)
    length = found[-1].t_ns + MS
    again = [s._replace(t_ns=s.t_ns + k * length) for k in range(3) for s in found]
    assert played(again)[0].causes == []


def test_values_that_toggle_do_not_come_again():
    """As of a sensor whose steps are coarser than its noise: one component, up and down."""

    def coarse(sample):
        if not is_wrench(sample):
            return sample
        up = sample.t_ns // MS % 2
        return sample._replace(force=(0.0, 0.1 * up, 5.0), torque=(0.0, 0.0, 0.0))

    assert not any("late" in cause for cause in played(map(coarse, recorded(0.5)))[0].causes)


def test_a_value_that_is_held_does_not_come_again():
    found, kept = [], None
    for sample in recorded(1.2):
        if is_wrench(sample):
            kept = sample if kept is None or sample.t_ns % (10 * MS) == 0 else kept
            sample = kept._replace(t_ns=sample.t_ns)
        found.append(sample)
    assert not any("late" in cause for cause in played(found)[0].causes)
