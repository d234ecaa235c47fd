"""What a tare takes, and what it refuses, in the pipeline and through a record of arrivals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from inputs import hanging, joints
from late_samples import MS, ordered, pipeline, play
from peg_on_hole_ros.bags.arrival_record import ArrivalRecord
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.records import JointSample, WrenchSample
from peg_on_hole_ros.replay.run import replay_bag
from recorded_faults import samples, spoilt
from simulated import ROOT
from tiers import nightly

AIR = "; call again once it hangs free and still (wrench.tare_in_contact takes it all the same)"
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


def test_a_zero_that_is_off_by_more_than_is_stated_is_taken_and_the_answer_says_what_for():
    """Nobody can tell it from a load without a model."""
    line = Pipeline(Configuration())
    hung = samples(ROOT / "bags" / "working_cycle.mcap", end=0.2)
    off = spoilt(hung, lambda force, torque, q: (force + [5.0, 1.5, -2.5], torque + 0.1))
    told = play(line, off)[-1]
    assert told.contact_mode == "unknown"
    taken = line.tare()
    assert taken.success
    assert taken.message.endswith(
        "; the contact mode was unknown: right only of a peg that hung free"
    )


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
    for k in range(1, 50):
        record.joints(Encoder(JOINTS_TYPE)(joints(k * MS)), 2 * k)
        record.wrench(Encoder(WRENCH_TYPE)(hanging(k * MS)), 2 * k + 1)
    record.event("tare", 100)
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
    # The mean of a hundred; nothing of it is learnt within one wrench.
    left = [sensor.force_stddev / 10] * 3 + [sensor.torque_stddev / 10] * 3
    taken = line.tare().message
    told = bias_after(line.reset)
    assert [stddev for _, stddev in told] == pytest.approx(left)
    numbers = ", ".join(f"{value:.6g}" for value, _ in told)
    assert taken.startswith("tare over 100 samples") and taken.endswith(numbers)


@pytest.mark.parametrize(("pause_ms", "taken"), [(300, 100), (501, 50)])
def test_a_tare_takes_no_wrench_from_before_a_long_pause(pause_ms, taken):
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
    assert line.tare().message.startswith(f"tare over {taken} samples")


def test_what_a_tare_took_is_published_from_then_on():
    """As the answer says it; of a known bias there is no deviation to tell."""
    line, samples = allowing(pipeline()), ordered(100)
    middle = len(samples) // 2
    before = play(line, samples[:middle])
    assert not any(name.startswith("bias") for row in before for name in row.monitor)
    answer = line.tare().message
    for row in play(line, samples[middle:]):
        told = [
            row.monitor[f"bias_{kind}_{axis}"] for kind in ("force", "torque") for axis in "xyz"
        ]
        assert answer.endswith(", ".join(f"{value:.6g}" for value in told))
        assert "bias_force_x_stddev" not in row.monitor
