"""What the robot's program announces, and what is tared and found while a peg hangs free."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from estimates import estimate
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.options import Configuration, WrenchInput
from peg_on_hole_ros.engine.announced_motion import AnnouncedMotion
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.stream import is_event, message_stream
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.run import check_bag, hand_over, sources_of
from simulated import ROOT

MS = 1_000_000
BEGIN = 4.5  # of what is played [s]: the peg slides


def played(events):
    """Seconds, level and text of contact_loss over the end of working_cycle's first try."""
    bag, configuration = Bag(ROOT / "bags" / "working_cycle.mcap"), Configuration()
    stream, sources = message_stream(configuration, 0.0), sources_of(configuration)
    begun, waiting, told = None, list(events), []
    for item in bag.items(check_bag(bag, configuration)):
        begun = item.log_ns if begun is None else begun
        t = (item.log_ns - begun) * 1e-9
        if t > 7.6:
            return told
        if t < BEGIN:
            continue
        while waiting and t >= waiting[0][0]:
            assert stream.on_event(waiting.pop(0)[1]).success
        columns = hand_over(stream, item, sources)
        for suffix, _, fields in columns.messages(0) if columns else ():
            if suffix == "alarms":
                (loss,) = (s for s in fields["status"] if s["name"].endswith("contact_loss"))
                told.append((t, loss["level"], loss["message"]))
    raise AssertionError("the bag is too short")


def test_an_announced_lift_off_is_no_lost_contact():
    """The bag lifts off at 6.856 s."""
    announced = played([(6.8, "expect lift_off")])
    assert max(level for _, level, _ in announced) == 0
    assert any(text.startswith("expected (lift_off): the peg") for _, _, text in announced)
    taken_back = played([(6.0, "expect lift_off"), (6.5, "expect nothing")])
    assert max(level for t, level, _ in taken_back if t > 6.8) == 2


@pytest.mark.parametrize(("what", "mode"), [("insertion", "two_point"), ("lift_off", "open")])
def test_what_is_announced_is_over_half_a_second_behind_it(what, mode):
    lost, jams = {"contact_loss": 2}, {"jamming": 2}
    expected = AnnouncedMotion()
    expected.announce(what)

    def levels(t_ms, mode, alarms):
        outputs = estimate(t_ns=t_ms * MS, contact_mode=mode, alarms=alarms)
        return {
            alarm.name: alarm.level
            for alarm in expected.without_announced_alarms(outputs).alarms
            if alarm.level
        }

    # Before it has come, and as long as the alarm is held behind it.
    assert levels(0, "unknown", lost) == {} and levels(100, mode, lost) == {}
    assert levels(700, mode, lost) == {}
    # No other alarm is quiet for it.
    assert levels(701, mode, lost | jams) == jams
    assert levels(702, mode, {}) == {}
    assert levels(703, "unknown", lost) == lost


def test_only_known_motions_are_events():
    assert is_event("expect lift_off") and is_event("expect insertion")
    assert is_event("expect nothing") and not is_event("expect miracles")


def hang(line, angles, seconds, begin_ns, zero=(0.0,) * 6, payload=None, rng=None, in_base=False):
    """
    Hand over a peg that hangs still; its payload is a mass and its centre in sensor axes.

    Numbers are in the sensor's axes, which are the peg's, or in those of the angles.
    """
    rng = rng or np.random.default_rng(3)
    gamma, psi, phi = angles
    turn = Rotation.from_euler("ZYZ", [psi, -gamma, phi])
    up = turn.inv().apply([0.0, 0.0, 9.80665])
    force, torque = 0.5 * up, np.cross([0.0, 0.0, -0.035], 0.5 * up)
    if payload:
        mass, com = payload
        force, torque = force + mass * up, torque + np.cross(com, mass * up)
    told = None
    for k in range(round(seconds * 1e3)):
        t_ns = begin_ns + k * MS
        noisy = np.array(angles) + rng.normal(0, 1e-4, 3)
        line.on_joints(JointSample(t_ns, ("gamma", "psi", "phi"), tuple(noisy)))
        read = np.r_[force, torque] + zero + rng.normal(0, [0.2] * 3 + [0.005] * 3)
        sides = read[:3], read[3:]
        if in_base:
            sides = map(turn.apply, sides)
        told = line.on_wrench(WrenchSample(t_ns, *map(tuple, sides))) or told
    return begin_ns + round(seconds * 1e9), told


def configured(**wrench):
    return Configuration(wrench=replace(WrenchInput(), **wrench))


def test_a_free_peg_is_tared_once_each_time_it_hangs_still():
    zero = np.array([0.4, -0.3, 0.2, 0.004, 0.0, 0.0])
    line = Pipeline(configured(tare_automatically=True, bias_force_stddev=1.0))
    at, told = hang(line, (0.3, 0.0, 0.0), 0.9, 10**9, zero)
    assert line.counts["tare_automatic"] == 0
    at, told = hang(line, (0.3, 0.0, 0.0), 1.5, at, zero)
    assert told.contact_mode == "open"
    assert (line.counts["tare_automatic"], line.counts["tare"]) == (1, 1)
    # A hundred wrenches of 0.2 N: 0.02 N, by four deviations.
    assert line.processor.reduction.taken_off[:3] == pytest.approx(zero[:3], abs=0.08)
    silent = Pipeline(configured(bias_force_stddev=1.0))
    hang(silent, (0.3, 0.0, 0.0), 2.4, 10**9, zero)
    assert silent.counts["tare_automatic"] == 0


@pytest.mark.parametrize("axes", ["sensor", "base"])
def test_poses_taken_one_by_one_tell_payload_and_zero(axes):
    line = Pipeline(configured(bias_force_stddev=2.0, axes=axes))
    rng = np.random.default_rng(5)
    assert line.take_pose() == (
        False,
        "no pose taken: no wrench and orientation have arrived yet",
    )
    zero, payload = np.array([1.5, -2.0, 3.0, 0.04, -0.03, 0.02]), (0.8, [0.01, -0.02, 0.03])
    at, answers = 10**9, []
    poses = [(0.05, 0.0, 0.0), (0.5, 0.0, 0.3), (0.5, 1.6, 0.3), (0.6, -1.5, 1.0)]
    for pose in poses:
        # Moved there without a word: a pause, and the filter begins anew.
        at, _ = hang(line, pose, 0.8, at + 10**10, zero, payload, rng, axes == "base")
        answers.append(line.take_pose())
    assert all(answer.success for answer in answers)
    assert "with one direction of gravity" in answers[0].message
    assert "by 20 degrees: gravity turned about one axis only" in answers[1].message
    last = answers[-1].message
    assert last.startswith("pose 4 taken: wrench.payload_mass: 0.8") or "0.79" in last
    assert "missing" not in last
    numbers = [float(x) for x in last.split("bias_force: [")[1].split("]")[0].split(",")]
    assert numbers == pytest.approx(zero[:3], abs=0.3)


def test_poses_of_a_wrench_freed_of_weight_tell_nothing():
    line = Pipeline(configured(gravity="compensated"))
    hang(line, (0.3, 0.0, 0.0), 0.3, 10**9)
    answer = line.take_pose()
    assert not answer.success
    assert "payload and bias need wrench.gravity: measured" in answer.message
