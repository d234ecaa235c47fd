"""What values of joint states show: two publishers that take turns, and encoders with steps."""

from math import sqrt

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.diagnosis.encoder_step import encoder_steps
from peg_on_hole_ros.diagnosis.suspected.twin_joints import motions_apart
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.records import JointSample
from peg_on_hole_ros.replay.run import replay_bag, stored_configuration
from recorded_faults import BAGS, samples
from tiers import nightly

MS = 1_000_000
STDDEV = JointInput().position_stddev
# In the air until 1.2 s, on three contacts from then on.
UNTIL = 2.4


def recorded(end=UNTIL):
    return samples(BAGS[2], end=end)


def is_joints(sample):
    return isinstance(sample, JointSample)


def played(found, **parameters):
    line = Pipeline(from_parameters(parameters))
    return line, list(line.play(found))


def with_second(found, second, every=1):
    """Return samples with a second publisher's behind every so many joint states."""
    out, count = [], 0
    for sample in found:
        out.append(sample)
        if is_joints(sample):
            count += 1
            if count % every == 0:
                out.append(second(sample))
    return out


def apart(by):
    """Return a publisher of other positions, 0.5 ms later."""

    def second(sample):
        position = tuple(value + off for value, off in zip(sample.position, by))
        return sample._replace(t_ns=sample.t_ns + MS // 2, position=position)

    return second


@pytest.mark.parametrize(
    ("by", "every"), [((2e-3, 2e-3, 2e-3), 1), ((2e-3, 0.0, 0.0), 5), *nightly(((0, 0, 0.02), 2))]
)
def test_two_publishers_are_told_and_nothing_is_determined(by, every):
    line, outputs = played(with_second(recorded(), apart(by), every))
    # No noise, and no other setting.
    (cause,) = line.causes
    assert cause.startswith("joints: two publish on /joint_states: joint states take turns betwe")
    told = float(cause.partition("two motions, ")[2].split()[0])
    # psi and phi have each a noise of 1e-3 rad at this tilt, over 10 and more messages.
    assert told == pytest.approx(max(by), rel=0.4)
    late = [each for each in outputs if each.t_ns > outputs[0].t_ns + 500 * MS]
    assert not any(each.monitor["reactions_determined"] for each in late)
    assert {each.contact_mode for each in late} <= {"unknown", "open"}


def test_two_motions_are_apart_and_one_is_not():
    """Of six joints with a noise of 3e-4 rad each, at 500 Hz."""
    rng, t_ns = np.random.default_rng(1), np.arange(64) * 2 * MS
    seconds, rates = t_ns * 1e-9, np.array([1.0, 0.5, -0.3, 0.2, 0.8, 0.0])
    one = np.outer(seconds, 0.3 * rates) + rng.normal(0.0, 3e-4, (64, 6))
    assert motions_apart(t_ns, one) == 0.0
    # One that publishes what another has sent 20 ms ago, in a motion of 0.3 rad/s.
    late = one.copy()
    late[1::2] = (np.outer(seconds - 0.02, 0.3 * rates) + rng.normal(0.0, 3e-4, (64, 6)))[1::2]
    assert motions_apart(t_ns, late) == pytest.approx(6e-3, rel=0.1)
    # A step is no other publisher, and neither is a vibration of 100 Hz.
    step = one + np.where(seconds > 0.06, 0.01, 0.0)[:, None]
    assert motions_apart(t_ns, step) == 0.0
    shaken = one + 0.01 * np.sin(2.0 * np.pi * 100.0 * seconds)[:, None]
    assert motions_apart(t_ns, shaken) == 0.0


def rounded(found, step):
    """Return samples whose joint states are rounded to whole steps."""
    return [
        s._replace(position=tuple(step * round(x / step) for x in s.position))
        if is_joints(s)
        else s
        for s in found
    ]


@pytest.mark.parametrize("step", [1e-3, *nightly(6e-4, 2e-3)])
def test_steps_wider_than_the_noise_are_told_and_widen_the_tilt(step):
    exact = {each.t_ns: each for each in played(recorded())[1]}
    line, outputs = played(rounded(recorded(), step))
    (cause,) = line.causes
    assert cause.startswith(f"joints: joint states come in steps of {step:.3g} rad")
    fits = sqrt(STDDEV**2 + step**2 / 12.0)
    assert f"or state joints.position_stddev: {fits:.2g}. Until then" in cause
    begun = outputs[0].t_ns + 500 * MS
    late = [each for each in outputs if each.t_ns > begun and each.t_ns in exact]
    assert not any(each.monitor["reactions_determined"] for each in late)
    off = np.array([each.state[0] - exact[each.t_ns].state[0] for each in late])
    stddev = np.array([each.state_stddev[0] for each in late])
    # The exact run is off by less than a tenth of that.
    assert np.mean(np.abs(off) < 1.96 * stddev) > 0.9
    assert line.counts["reactions_withheld"] > 0.5 * len(outputs)
    # Stated, it is no fault, and the same steps are told no more.
    stated, outputs = played(rounded(recorded(), step), **{"joints.position_stddev": 1.1 * fits})
    assert not [each for each in stated.causes if "steps" in each]


def test_steps_narrower_than_the_noise_are_none():
    assert played(rounded(recorded(), STDDEV))[0].causes == []


@pytest.mark.parametrize("bag", [BAGS[0], *nightly(*BAGS[1:])])
def test_nothing_is_told_of_a_shipped_bag(bag):
    found = replay_bag(Bag(bag), stored_configuration(Bag(bag)), 0.0, [])
    assert not [each for each in found.causes if each.startswith("joints")]


def test_a_grid_is_known_by_several_of_its_steps_alone():
    rng = np.random.default_rng(4)
    moving = np.cumsum(rng.normal(0.0, 3e-4, (200, 2)), axis=0)
    assert (encoder_steps(moving) == 0.0).all()
    grid = 1e-3 * np.round(moving / 1e-3)
    assert encoder_steps(grid) == pytest.approx([1e-3, 1e-3])
    # One speed without noise: each value comes once.
    assert (encoder_steps(np.arange(200.0)[:, None] * 2e-3) == 0.0).all()
    # Values of a slower sensor that are held are no grid.
    held = np.repeat(moving[::10], 10, axis=0)
    assert (encoder_steps(held) == 0.0).all()
    # An encoder that stands still shows none.
    assert (encoder_steps(np.full((200, 2), 0.3)) == 0.0).all()
