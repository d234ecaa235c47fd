"""What a tare takes, and what it refuses, in the pipeline and through a record of arrivals."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from inputs import hanging, joints
from late_samples import MS, ordered, pipeline, play
from peg_on_hole_ros.bags.arrival_record import ArrivalRecord
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE, joint_sample, wrench_sample
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.run import replay_bag
from recorded_faults import samples, spoilt
from simulated import ROOT
from tiers import nightly

AIR = "; call again once it hangs free and still (wrench.tare_in_contact: true accepts it now)"
UNSHOWN = "no measurement shows a free and still peg: contact mode unknown, and the sensor reads"
REFUSED = (False, "nothing taken: no wrench and orientation have arrived yet")


def test_a_tare_without_an_estimate_takes_nothing_and_says_so():
    line, samples = pipeline(), ordered(50)
    tare = line.processor.reduction.tare.tolist()
    assert line.tare() == REFUSED
    play(line, samples)
    line.reset()
    assert line.tare() == REFUSED
    assert line.counts["tare_refused"] == 2 and line.counts["tare"] == 0
    assert line.processor.reduction.tare.tolist() == tare


def test_a_tare_in_contact_takes_nothing_and_names_the_mode():
    line, samples = pipeline(), ordered(400)
    told = play(line, samples)
    assert told[-1].contact_mode == "three_point"
    tare = line.processor.reduction.tare.tolist()
    assert line.tare() == (
        False,
        f"nothing taken: the peg touches, contact mode three_point{AIR}",
    )
    assert (line.counts["tare_refused"], line.counts["tare"]) == (1, 0)
    assert line.processor.reduction.tare.tolist() == tare
    # Who says so has it all the same.
    line = allowing(pipeline())
    play(line, samples)
    assert line.tare().success and line.counts["tare"] == 1


@pytest.mark.parametrize(("force", "torque"), [(1e-3, 1.0), (0.2248, 0.2248)])
def test_a_tare_takes_nothing_where_the_unit_hides_a_contact(force, torque):
    """Wrenches of a pressed peg in kN, and in pounds of force."""
    line = pipeline()
    for sample in ordered(400):
        if isinstance(sample, WrenchSample):
            sample = sample._replace(
                force=tuple(force * x for x in sample.force),
                torque=tuple(torque * x for x in sample.torque),
            )
        line.on_sample(sample)
    assert not line.tare().success and line.counts["tare"] == 0


@pytest.mark.parametrize(
    ("spreads", "taken"), [((0.0, 0.0), False), ((0.5, 0.02), False), ((1.5, 0.05), True)]
)
def test_a_zero_is_taken_as_far_off_as_is_stated_and_else_the_answer_says_what_to_state(
    spreads, taken
):
    """What is no more than a zero of 5 N may be a load of 5 N as well, but for what is stated."""
    base = without_modes(Configuration())
    names = "bias_force_stddev", "bias_torque_stddev"
    line = Pipeline(replace(base, wrench=replace(base.wrench, **dict(zip(names, spreads)))))
    hung = samples(ROOT / "bags" / "working_cycle.mcap", HANGS, HANGS + 0.2)
    off = spoilt(hung, lambda force, torque, q: (force + [5.0, 1.5, -2.5], torque + 0.1))
    assert play(line, off)[-1].contact_mode == "unknown"
    answer = line.tare()
    assert answer.success == taken, answer.message
    if taken:
        assert answer.message.endswith(
            "; contact mode unknown, but the sensor reads no more than the weight and a plausible "
            "bias"
        )
        assert line.processor.reduction.taken_off[:3] == pytest.approx([5.0, 1.5, -2.5], abs=0.1)
    else:
        assert answer.message.startswith(f"nothing taken: {UNSHOWN}")
        assert "(wrench.bias_force_stddev, wrench.bias_torque_stddev)" in answer.message


def reset_after(seconds, then, configuration, name, joints_until=99.0):
    """A pipeline that is reset so long after a bag's begin, after so many wrenches more."""
    line = Pipeline(configuration, orientation_of(configuration))
    recorded = samples(ROOT / "bags" / f"{name}.mcap", seconds - 0.3, seconds + 2.0)
    begin_ns = recorded[0].t_ns + 300 * MS
    left, waits = then, True
    for sample in recorded:
        if waits and sample.t_ns >= begin_ns:
            line.reset()
            waits = False
        at = (sample.t_ns - begin_ns) * 1e-9
        if isinstance(sample, WrenchSample):
            line.on_wrench(sample)
            left -= not waits
            if not left:
                break
        elif at < joints_until:
            line.on_joints(sample)
    return line


def cell(**groups):
    """The configuration of the cell of cell_ur_like, some of it changed."""
    values = read_parameters(ROOT / "config" / "cell_ur_like.yaml")
    values["joints.urdf"] = str(ROOT / "config" / "cell_ur_like.urdf")
    return from_parameters(values | {name.replace("__", "."): x for name, x in groups.items()})


# Seconds, and wrenches at 500 Hz after a reset: it touches from 1.7 to 5.8 s.
LOADED = [(3.4, 5), (3.4, 1), *nightly((3.4, 30), (3.4, 49), (3.4, 200), (2.0, 5), (5.0, 60))]


@pytest.mark.parametrize(("seconds", "wrenches"), LOADED)
@pytest.mark.parametrize("modes", [True, False])
@pytest.mark.parametrize("ask", ["tare", "take_pose"])
def test_after_a_reset_a_loaded_peg_is_not_taken_for_a_free_one(seconds, wrenches, modes, ask):
    stated = cell(monitor__modes=modes, wrench__gravity="measured")
    line = reset_after(seconds, wrenches, stated, "cell_ur_like")
    taken_off = line.processor.reduction.taken_off.tolist()
    answer = getattr(line, ask)()
    assert not answer.success, answer.message
    assert line.processor.reduction.taken_off.tolist() == taken_off
    if wrenches < 50:
        lacking = f"{wrenches} wrenches over {(wrenches - 1) * 2e-3:.3g} s have come since a start"
        assert f"call again after 0.1 s: {lacking}" in answer.message


# working_cycle: pressed and at rest from 5.7 to 6.85 s, free and still from 7.6 s on.
RESTS, HANGS = 5.9, 7.6


@pytest.mark.parametrize("ask", ["tare", "take_pose"])
def test_modes_that_are_off_let_a_free_peg_be_taken_and_no_loaded_one(ask):
    stated = without_modes(Configuration())
    answer = getattr(reset_after(RESTS, 200, stated, "working_cycle"), ask)()
    assert not answer.success
    assert (
        "no measurement shows a free and still peg: contact mode unknown, and the sensor reads"
        in answer.message
    )
    answer = getattr(reset_after(HANGS, 200, stated, "working_cycle"), ask)()
    assert answer.success, answer.message


@pytest.mark.parametrize("ask", ["tare", "take_pose"])
@pytest.mark.parametrize("seconds", [RESTS, HANGS])
def test_a_gap_of_joint_states_shows_no_peg_that_is_still(ask, seconds):
    """What was free before it may touch since."""
    base = Configuration()
    stated = replace(base, filter=replace(base.filter, max_joint_gap=0.2))
    line = reset_after(seconds, 500, stated, "working_cycle", joints_until=0.2)
    answer = getattr(line, ask)()
    assert not answer.success
    assert "joint states do not show how it hangs: they have a gap" in answer.message


@pytest.mark.parametrize("ask", ["tare", "take_pose"])
def test_one_joint_state_shows_no_peg_that_is_still(ask):
    line = Pipeline(Configuration())
    line.on_joints(joint_sample(joints(10**9, gamma=1.0)))
    for k in range(1, 150):
        line.on_wrench(wrench_sample(hanging(10**9 + k * MS, gamma=1.0)))
    answer = getattr(line, ask)()
    assert not answer.success
    assert "too few joint states show that it is still" in answer.message


def without_modes(configuration):
    return replace(configuration, monitor=replace(configuration.monitor, modes=False))


def test_a_peg_that_has_just_lifted_off_is_not_tared_by_what_it_carried_before():
    """Whatever the mode is by then: over working_cycle's first lift-off, every 20 ms."""
    recorded = samples(ROOT / "bags" / "working_cycle.mcap", 6.5, 7.4)
    taken = {}
    for count in range(16, len(recorded), 16):
        line = Pipeline(Configuration())
        if not list(line.play(recorded[:count])):
            continue
        if line.tare().success:
            seconds = (recorded[count - 1].t_ns - recorded[0].t_ns) * 1e-9
            taken[seconds] = line.processor.reduction.taken_off.copy()
    assert taken
    assert min(taken) > 0.356 + 0.1
    for zero in taken.values():
        assert zero[:3] == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize(("rate", "taken"), [(0.0, True), (0.005, True), (0.3, False)])
@pytest.mark.parametrize("axis", [1, *nightly(0, 2)])
def test_a_tare_of_a_peg_that_turns_in_the_air_takes_nothing(rate, taken, axis):
    """Reads what hangs on it alone: of a peg that is moved the sensor reads more than its zero."""
    line = Pipeline(Configuration())
    rng = np.random.default_rng(2)
    for k in range(600):
        t_ns = 10**9 + k * MS
        q = np.array([0.3, 0.0, 0.0]) + np.eye(3)[axis] * rate * k * 1e-3
        position = tuple(q + rng.normal(0, 1e-4, 3))
        line.on_joints(JointSample(t_ns, ("gamma", "psi", "phi"), position))
        # The sensor has the peg's axes, and carries the weight of 0.5 kg, 35 mm below it.
        gamma, psi, phi = q
        turn = Rotation.from_euler("ZYZ", [psi, -gamma, phi])
        up = turn.inv().apply([0.0, 0.0, 0.5 * 9.80665])
        torque = np.cross([0.0, 0.0, -0.035], up)
        force, torque = up + rng.normal(0, 0.2, 3), torque + rng.normal(0, 0.005, 3)
        told = line.on_wrench(WrenchSample(t_ns, tuple(force), tuple(torque))) if k else None
    assert told.contact_mode in ("open", "unknown")
    answer = line.tare()
    assert answer.success == taken, answer.message
    if not taken:
        assert answer.message.startswith("nothing taken: the peg turns at 0.")
        assert answer.message.endswith(f", contact mode {told.contact_mode}{AIR}")


def allowing(line):
    """A pipeline that takes a tare of any peg."""
    sensor = replace(line.configuration.wrench, tare_in_contact=True)
    return Pipeline(replace(line.configuration, wrench=sensor))


def test_a_refused_tare_is_refused_in_the_replay_too(tmp_path):
    record = ArrivalRecord(tmp_path / "arrivals.mcap", Configuration(), 10.0)
    record.event("tare", 1)
    for k in range(1, 200):
        record.joints(Encoder(JOINTS_TYPE)(joints(k * MS)), 2 * k)
        record.wrench(Encoder(WRENCH_TYPE)(hanging(k * MS)), 2 * k + 1)
    record.event("tare", 500)
    record.close()
    replayed = replay_bag(Bag(record.path), Configuration(), 10.0, [])
    assert {name: replayed.events.get(name) for name in ("tare", "tare_refused")} == {
        "tare": 1,
        "tare_refused": 1,
    }


def test_a_reset_keeps_a_tare_and_how_well_it_is_known():
    configuration, samples = pipeline().configuration, ordered(200)
    sensor = configuration.wrench
    stated = replace(sensor, bias_force_stddev=2.0, bias_torque_stddev=0.02, tare_in_contact=True)
    line = Pipeline(replace(configuration, wrench=stated))

    def bias_after(moment):
        moment()
        names = [f"bias_{kind}_{axis}" for kind in ("force", "torque") for axis in "xyz"]
        monitor = play(line, samples)[0].monitor
        return [(monitor[name], monitor[f"{name}_stddev"]) for name in names]

    told = bias_after(lambda: None)
    assert [stddev for _, stddev in told] == pytest.approx([2.0] * 3 + [0.02] * 3)
    # The mean of 0.1 s; nothing of it is learnt within one wrench.
    left = [sensor.force_stddev / sqrt(101)] * 3 + [sensor.torque_stddev / sqrt(101)] * 3
    taken = line.tare().message
    told = bias_after(line.reset)
    assert [stddev for _, stddev in told] == pytest.approx(left)
    numbers = ", ".join(f"{value:.6g}" for value, _ in told)
    assert taken.startswith("tare over 101 samples") and f": {numbers};" in taken


@pytest.mark.parametrize(("pause_ms", "taken"), [(99, 100), (102, 0), (501, 0)])
def test_a_tare_takes_no_wrench_from_before_a_long_pause(pause_ms, taken):
    """Nor fewer than those of 0.1 s, though a tare in contact is allowed."""
    line, samples = allowing(pipeline()), ordered(60)
    start = samples[-1].t_ns
    seen = next(s for s in samples[::-1] if isinstance(s, JointSample))
    play(line, samples)
    for first_ns, force, count in (
        (start + MS, 7.0, 100),
        (start + (100 + pause_ms) * MS, 9.0, 50),
    ):
        stamps = range(first_ns, first_ns + count * MS, MS)
        for t_ns in stamps:
            # A peg that hangs free is seen all the while.
            line.on_joints(seen._replace(t_ns=t_ns))
            line.on_wrench(WrenchSample(t_ns, (0.0, 0.0, force), (0.0, 0.0, 0.0)))
    said = line.tare().message
    short = (
        "nothing taken: call again after 0.1 s: 50 wrenches over 0.049 s have come since a start"
    )
    assert said.startswith(f"tare over {taken} samples" if taken else short)


def test_what_a_tare_took_is_published_from_then_on():
    """As the answer says it; of a known bias there is no deviation to tell."""
    line, samples = allowing(pipeline()), ordered(300)
    middle = len(samples) // 2
    before = play(line, samples[:middle])
    assert not any(name.startswith("bias") for row in before for name in row.monitor)
    answer = line.tare().message
    for row in play(line, samples[middle:]):
        told = [
            row.monitor[f"bias_{kind}_{axis}"] for kind in ("force", "torque") for axis in "xyz"
        ]
        assert f": {', '.join(f'{value:.6g}' for value in told)};" in answer
        assert "bias_force_x_stddev" not in row.monitor
