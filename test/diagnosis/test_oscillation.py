"""A wrench that oscillates: named with frequency and amplitude, and nothing else of it."""

import re

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.truth import read_truth
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.monitor.states import AlarmLevel
from peg_on_hole_ros.records import WrenchSample
from recorded_faults import BAGS, samples
from tiers import nightly


def oscillating(hertz, force, torque, end=2.0, begin=0.0):
    """Return samples of the working cycle under a force and a torque that turn, from a time on."""
    found = samples(BAGS[2], end=end)
    first, changed = found[0].t_ns, []
    for sample in found:
        t = (sample.t_ns - first) * 1e-9
        if isinstance(sample, WrenchSample) and t >= begin:
            s, c = np.sin(2 * np.pi * hertz * t), np.cos(2 * np.pi * hertz * t)
            sample = sample._replace(
                force=tuple(np.array(sample.force) + force * np.array([s, c, 0.5 * s])),
                torque=tuple(np.array(sample.torque) + torque * np.array([c, s, 0.2 * s])),
            )
        changed.append(sample)
    return changed


def played(found, **parameters):
    line = Pipeline(from_parameters(parameters))
    return line, list(line.play(found))


def figures(cause):
    """Return frequency [Hz] and amplitudes [N], [N m] that a cause names."""
    said = re.match(r"wrench: the wrench oscillates at (\S+) Hz by (\S+) N and (\S+) N m", cause)
    assert said, cause
    return tuple(map(float, said.groups()))


@pytest.mark.parametrize(
    ("hertz", "force", "torque"),
    [(30.0, 3.0, 0.15), *nightly((25.0, 6.0, 0.4), (83.7, 2.0, 0.1), (161.0, 1.0, 0.1))],
)
def test_an_arm_that_swings_is_named_and_no_contact_is_sure(hertz, force, torque):
    found = oscillating(hertz, force, torque)
    line, outputs = played(found, **{"wrench.adopt_found": False})
    (cause,) = [each for each in line.causes if "noise" not in each]
    found = figures(cause)
    # A bin is 4 Hz; between two of them a Hann window tells a twentieth of one.
    assert found[0] == pytest.approx(hertz, abs=0.3)
    # Noise of one sample in twenty to fifty of the amplitudes, over 250 of them.
    assert found[1:] == pytest.approx((force, torque), rel=0.1)
    assert "hum" not in cause
    later = [o for o in outputs if o.t_ns - outputs[0].t_ns > 800_000_000]
    assert {o.contact_mode for o in later} <= {"open", "unknown"}
    assert not any(o.monitor["reactions_determined"] for o in later)


def test_a_loud_oscillation_counts_as_noise_and_contacts_are_told():
    line, outputs = played(oscillating(25.0, 3.0, 0.15, end=3.0))
    (cause,) = line.causes
    assert "used in place of what is stated" in cause
    wrench = line.configuration.wrench
    # The root of its mean square; the stated noise is a tenth of that.
    assert wrench.force_stddev == pytest.approx(3.0 / np.sqrt(2.0), rel=0.1)
    assert wrench.torque_stddev == pytest.approx(0.15 / np.sqrt(2.0), rel=0.1)
    # It touches down at 1.2 s; what then carries the load takes a second to be told from a swing.
    in_contact = [o for o in outputs if o.t_ns - outputs[0].t_ns > 2_200_000_000]
    assert np.mean([o.contact_mode == "three_point" for o in in_contact]) > 0.95
    assert np.mean([bool(o.monitor["reactions_determined"]) for o in in_contact]) > 0.8


def test_a_loud_oscillation_is_no_contact_in_the_air():
    """A slight load and none are as likely in noise of its size; the mean over periods tells."""
    _, outputs = played(oscillating(30.0, 3.0, 0.15, end=1.19))
    # A stretch of 0.25 s, and the look that follows it.
    later = [o for o in outputs if o.t_ns - outputs[0].t_ns > 270_000_000]
    assert {o.contact_mode for o in later} <= {"open", "unknown"}
    levels = {alarm.level for o in later for alarm in o.alarms if alarm.name == "contact_loss"}
    assert levels == {AlarmLevel.OK}


def test_hum_of_the_mains_is_named_and_no_zero():
    line, outputs = played(oscillating(50.0, 0.4, 0.0, end=3.0))
    (cause,) = line.causes
    assert figures(cause)[:2] == pytest.approx((50.0, 0.4), rel=0.15)
    assert "hum of the mains" in cause
    # Twice the noise: contacts are told.
    assert outputs[-1].contact_mode == "three_point"
    # It counts as noise: the root of its mean square beside that of the sensor.
    assert line.configuration.wrench.force_stddev == pytest.approx(np.hypot(0.2, 0.28), rel=0.1)


def test_bounds_of_the_tilt_hold_under_hum():
    """A hum is no white noise: taken for the sensor's alone, the tilt's bounds do not cover it."""
    bag = Bag(BAGS[2])
    truth, (_, outputs) = read_truth(bag), played(oscillating(50.0, 0.4, 0.0, end=4.0))
    late = [o for o in outputs if o.t_ns - outputs[0].t_ns > 2_000_000_000]
    off = [abs(o.state[0] - truth.at(o.t_ns)[0]) / o.state_stddev[0] for o in late]
    # 95 % are stated; of 2 s of a tilt that changes slowly some tens of errors are their own.
    assert np.mean(np.array(off) < 1.96) > 0.9


def test_an_oscillation_that_ends_withholds_nothing_more():
    found = oscillating(30.0, 3.0, 0.15, end=1.0) + samples(BAGS[2], begin=1.0, end=4.0)
    line, outputs = played(found)
    assert len(line.causes) == 1
    assert outputs[-1].contact_mode == "three_point"


def test_no_low_pass_is_named_that_no_filter_could_be():
    for hertz in (15.0, 30.0):
        line, _ = played(oscillating(hertz, 3.0, 0.15, end=2.5))
        assert not any("low-pass" in cause for cause in line.causes)
