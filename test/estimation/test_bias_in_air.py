"""A bias that a peg in the air tells: equal to the reference, as sure as it may be, and of use."""

from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.kernel.bias_in_air import LONGEST, READINGS, SPEED
from peg_on_hole_ros.estimation.kernel.memory import part
from scipy.stats import chi2

from bias_in_air import cycle
from peg_on_hole_ros.estimation.measurement import WrenchReduction, angle_covariance
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.simulation.measure import START_NS, measure
from side_by_side import Step, filters, state_difference, unguarded
from simulated import truth

SENSOR = replace(
    Configuration().wrench,
    acts_on="robot",
    sensor_xyz=(0.01, -0.02, 0.09),
    sensor_rpy=(3.0, 0.2, 0.7),
    payload_mass=0.8,
    payload_com=(0.0, 0.01, -0.03),
    bias_force_stddev=2.0,
    bias_torque_stddev=0.02,
)
DT = 1e-3


def configured(wrench=SENSOR, tilt=0.0, **options):
    joints = replace(Configuration().joints, hole_tilt_stddev=tilt)
    options = replace(Configuration().filter, **options)
    return replace(Configuration(), wrench=wrench, joints=joints, filter=options)


def filter_of(configuration):
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    offsets = reduction.offsets(configuration)
    kalman = make_filter(configuration.scene, configuration.filter, reduction.covariance, offsets)
    return kalman, reduction


class Flight:
    """Readings of a peg in the air, by Newton's law for what is below the sensor."""

    def __init__(self, wrench, seed, turn=(0.0, 0.3, 0.4), speed=SPEED, knots=0.3):
        self.scene, self.options = Configuration().scene, wrench
        self.random = np.random.default_rng(seed)
        self.reduction = WrenchReduction(wrench, self.scene)
        size = [wrench.bias_force_stddev] * 3 + [wrench.bias_torque_stddev] * 3
        self.bias = self.random.normal(size=6) * size
        self.turn, self.speed, self.knots = np.array(turn), speed, knots
        self.q0 = np.array([0.3, 0.4, -1.0])

    def steps(self, duration):
        """Yield one step each DT: velocities are drawn anew every so often, hole axes."""
        every = round(self.knots / DT)
        begin = end = self.speed * self.random.normal(size=3)
        for k in range(round(duration / DT)):
            if k % every == 0:
                begin, end = end, self.speed * self.random.normal(size=3)
            yield self.step(self.q0 + DT * k * self.turn, (end - begin) / self.knots)

    def step(self, q, acceleration):
        """Return one step at an orientation and an acceleration [m/s^2]."""
        # on_peg takes the payload's weight off, and its inertia stays.
        reduction, o = self.reduction, self.options
        felt = peg_axes(q).T @ (acceleration - np.array(self.scene.gravity))
        pushed = peg_axes(q).T @ acceleration
        arm = reduction._payload_arm
        true = np.concatenate([self.scene.peg_mass * felt, np.zeros(3)])
        true += o.payload_mass * np.concatenate([pushed, arm @ pushed])
        read = reduction.sign * np.linalg.solve(reduction.matrix, true)
        read += self.bias + self.random.normal(size=6) * np.sqrt(reduction.noise)
        u = reduction.on_peg(read[:3], read[3:], q)
        # Without a payload's weight, which on_peg has added.
        weight = o.payload_mass * (peg_axes(q).T @ np.array(self.scene.gravity))
        u -= np.concatenate([weight, arm @ weight])
        return Step(DT, u, q, angle_covariance(q[0], 1e-4))


def pressed(steps, by):
    """Yield steps under a force along the peg that grows by so much a second [N/s]."""
    for n, step in enumerate(steps):
        yield step._replace(u=step.u + [0.0, 0.0, by * n * DT, 0.0, 0.0, 0.0])


def fly(kalman, steps):
    for n, step in enumerate(steps):
        if n == 0:
            kalman.start(step.q, step.R)
        kalman.hold(step.u)
        kalman.predict(step.dt, in_contact=False)
        kalman.in_the_air(True)
        kalman.correct(step.q, step.R)


def error(kalman, bias):
    return kalman.offset[:6] - bias, kalman.offset_spread[:6, 2:8]


@pytest.mark.xdist_group("filterpy")
@pytest.mark.parametrize(("tilt", "press"), [(0.0, 0.0), (0.003, 0.0), (0.0, 40.0)])
def test_equals_the_reference_filter(tilt, press):
    configuration = unguarded(configured(tilt=tilt))
    flight = Flight(SENSOR, 1)
    first, *steps = pressed(flight.steps(0.65), press)
    kalman, reference = filters(configuration, first)
    # As contact has left them: what is learnt in the air is shared with all that it goes with.
    rng = np.random.default_rng(2)
    mixed = np.eye(22) + 0.2 * rng.normal(size=(22, 22))
    scale = np.sqrt(np.maximum(np.diagonal(reference.P), 0.0))
    reference.P = scale[:, None] * (mixed @ mixed.T) * scale
    kalman.Z[:] = reference.P[:12, :12]
    part(kalman.memory, "CROSS", (2, 12))[:] = reference.P[12:14, :12]
    part(kalman.memory, "SPREAD", (2, 2))[:] = reference.P[12:14, 12:14]
    part(kalman.memory, "OFFSET_CROSS", (8, 12))[:] = reference.P[14:, :12]
    kalman.offset_spread[:] = reference.P[14:, 12:]
    before = kalman.offset.copy()
    for n, step in enumerate(steps):
        for each in (kalman, reference):
            each.hold(step.u)
        kalman.predict(step.dt, in_contact=False)
        reference.predict_free(step.dt, configuration.filter.free_rate_noise)
        kalman.in_the_air(True)
        reference.hang(step.dt)
        if n % 20 == 0:
            kalman.correct(step.q, step.R)
            reference.correct(step.q, step.R)
        # In standard deviations; of a covariance whose units differ by 1e10 rounding leaves more.
        mean, covariance = state_difference(kalman, reference)
        assert mean < 1e-9 and covariance < 1e-7
    assert (kalman.offset[:6] != before[:6]).all()
    spread = kalman.offset_spread[:, 2:]
    np.testing.assert_array_equal(spread, spread.T)


def test_all_of_the_time_tells_as_one_mean():
    """Piece by piece it is what the mean over all blocks but the last two makes of the prior."""
    kalman, _ = filter_of(configured())
    # Slow enough for its readings not to lean.
    flight = Flight(SENSOR, 3, turn=(0.0, 0.0, 0.0), speed=0.05)
    steps = list(flight.steps(1.25))
    fly(kalman, steps)
    hanging = np.concatenate(
        [-flight.scene.peg_mass * peg_axes(flight.q0).T @ flight.scene.gravity, np.zeros(3)]
    )
    load = kalman.offsets.load
    # 1.25 s are twelve blocks and a half; the twelfth still waits.
    read = np.array([np.linalg.solve(load, hanging - step.u) for step in steps[:1100]])
    own = np.diagonal(kalman.offset_spread[:6, 2:8])
    prior = np.array([4.0] * 3 + [4e-4] * 3)
    mass = flight.scene.peg_mass + 0.8
    moved = SPEED * mass * np.sqrt(2) / 1.1
    information = 1 / own[:3] - 1 / prior[:3]
    # A rate that is measured is not zero, and its turning counts: to a part in a thousand.
    np.testing.assert_allclose(1 / information, 0.2**2 / 1100 + moved**2, rtol=1e-3)
    mean = read.mean(axis=0)
    expected = mean * (1 / own - 1 / prior) * own
    # What is read depends on the orientation, estimated to 1e-5 rad of 5 N.
    np.testing.assert_allclose(kalman.offset[:3], expected[:3], atol=2e-4)


def test_it_is_known_as_well_as_it_is_said_to_be():
    """Flights at speeds that differ by as much as is allowed for, turning all the time."""
    squares, stddev = [], []
    for seed in range(40):
        kalman, _ = filter_of(configured())
        flight = Flight(SENSOR, seed)
        fly(kalman, flight.steps(1.2))
        off, P = error(kalman, flight.bias)
        stddev.append(np.sqrt(np.diagonal(P)[:3]).max())
        squares.append(
            (
                off[:3] @ np.linalg.solve(P[:3, :3], off[:3]),
                (off[3:] ** 2 / np.diagonal(P)[3:]).mean(),
            )
        )
    # In some the readings lean by chance, and tell less.
    assert np.median(stddev) < 0.55
    forces, torques = np.array(squares).T
    # In a flight speeds are means of two that are drawn, and a turn seldom adds to what they make.
    low, high = 0.3 * 120, chi2(120).isf(0.001)
    assert low < forces.sum() < high, forces.sum()
    # A torque comes from the same accelerations, across the lever arm only.
    assert torques.mean() < 1.3, torques


@pytest.mark.parametrize("press", [0.3, 1.0])
@pytest.mark.parametrize("free", [1.0, 4.0])
def test_a_peg_that_is_pressed_on_slowly_tells_less(free, press):
    """Taken for bias as it came, a load was held for known 5 and 14 deviations off."""
    kalman, _ = filter_of(configured())
    flight = Flight(SENSOR, 11, turn=(0.0, 0.0, 0.0), speed=0.0)
    q, R = flight.q0, angle_covariance(flight.q0[0], 1e-4)
    kalman.start(q, R)
    found = []
    for n in range(round((free + 4.0) / DT)):
        load = press * max(n * DT - free, 0.0)
        kalman.hold(flight.step(q, np.zeros(3)).u + [0.0, 0.0, load, 0.0, 0.0, 0.0])
        kalman.predict(DT, in_contact=False)
        kalman.in_the_air(True)
        off, P = error(kalman, flight.bias)
        # A lean shows late.
        assert off[:3] @ np.linalg.solve(P[:3, :3], off[:3]) < 3.5**2
        found.append(kalman.offset[2])
    # Nothing in the last second, in which a mean would have moved by as much again.
    assert found[-1] == found[-1000]
    assert found[-1] != found[round(free / DT)]


def test_a_peg_at_rest_tells_no_more_than_a_tare():
    kalman, reduction = filter_of(configured(replace(SENSOR, force_stddev=2.0)))
    flight = Flight(replace(SENSOR, force_stddev=2.0), 5, turn=(0.0, 0.0, 0.0), speed=0.0)
    steps = list(flight.steps(2.0))
    fly(kalman, steps)
    between = np.diagonal(kalman.offset_spread[:3, 2:5]).copy()
    for _ in range(3):
        kalman.in_the_air(False)
        fly(kalman, steps)
    after = np.diagonal(kalman.offset_spread[:3, 2:5])
    # One more time in the air may start above the limit and end below it.
    assert (after < between).all() and (after > 0.5 * reduction.noise[:3] / READINGS).all()


def test_the_same_air_tells_no_more_after_a_while():
    kalman, _ = filter_of(configured())
    flight = Flight(SENSOR, 6, turn=(0.0, 0.0, 0.0), speed=0.0)
    q, R = flight.q0, angle_covariance(flight.q0[0], 1e-4)
    kalman.start(q, R)
    found = []
    for _ in range(2):
        # Two blocks wait.
        for _ in range(round((LONGEST + 0.3) / DT)):
            kalman.hold(flight.step(q, np.zeros(3)).u)
            kalman.predict(DT, in_contact=False)
            kalman.in_the_air(True)
        kalman.correct(q, R)
        found.append((kalman.offset.copy(), kalman.offset_spread.copy()))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    np.testing.assert_array_equal(found[0][1], found[1][1])


@pytest.mark.parametrize(
    "told",
    [
        configured(wrench_bias="considered"),
        configured(replace(SENSOR, bias_force_stddev=0.0, bias_torque_stddev=0.0), tilt=0.003),
    ],
    ids=["considered", "known"],
)
def test_what_is_known_or_only_considered_stays(told):
    kalman, _ = filter_of(told)
    before = np.diagonal(kalman.offset_spread[:6, 2:8]).copy()
    fly(kalman, Flight(SENSOR, 7).steps(0.5))
    assert not kalman.offset[:6].any()
    np.testing.assert_array_equal(np.diagonal(kalman.offset_spread[:6, 2:8]), before)


def test_nothing_is_learnt_in_the_blocks_before_contact():
    """A wrench that has begun to carry something is not taken for a bias."""
    found = []
    for load in (0.0, 0.1):
        kalman, _ = filter_of(configured())
        steps = list(Flight(SENSOR, 8, speed=0.0).steps(0.49))
        for n in range(140):
            # One that grows from within a block on, until contact is declared.
            u = steps[350 + n].u - [0.0, 0.0, load * n, 0.0, 0.0, 0.0]
            steps[350 + n] = steps[350 + n]._replace(u=u)
        fly(kalman, steps)
        kalman.in_the_air(False)
        assert not part(kalman.memory, "AIR").any()
        found.append(kalman.offset.copy())
    np.testing.assert_array_equal(*found)
    assert found[0].any()


def test_a_cycle_that_begins_in_the_air_is_estimated_as_with_a_known_bias():
    """Told nothing in the air, contact was found 48 ms later and reactions were 2.7 N off."""
    bias = np.array([0.7, -1.6, 0.6, 0.01, 0.004, -0.02])
    scene = truth("working_cycle")
    known = cycle(scene, (0.0, 0.0), np.zeros(6), 3, seconds=1.5)
    learnt = cycle(scene, (2.0, 0.02), bias, 3, seconds=1.5)
    for axis, value in zip("xyz", bias[:3], strict=True):
        assert abs(learnt.told[f"bias_force_{axis}"] - value) < 0.1
        assert 0.1 < learnt.told[f"bias_force_{axis}_stddev"] < 0.25
    assert learnt.late < known.late + 8
    assert learnt.root < 1.3 * known.root
    assert learnt.share > 0.93
    assert learnt.slow <= known.slow + 20


def test_a_gap_begins_the_time_in_the_air_anew():
    scene = truth("working_cycle")
    plain = scene.plan.configuration
    pipeline = Pipeline(replace(plain, wrench=replace(plain.wrench, bias_force_stddev=2.0)))
    told = []
    for outputs in pipeline.play(
        sample
        for sample in measure(scene, 3)
        if not 600_000_000 < sample.t_ns - START_NS < 800_000_000
    ):
        told.append(part(pipeline.filter.memory, "AIR_TOLD")[0])
        if outputs.t_ns - START_NS > 1_000_000_000:
            break
    (fell,) = np.flatnonzero(np.diff(told) < 0)
    assert told[fell + 1] == 0.0 < told[-1]
