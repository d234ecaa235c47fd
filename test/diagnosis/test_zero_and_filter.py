"""A zero or a lever that is off, a filter in the driver: named, on bags that have them."""

from itertools import islice

import numpy as np
import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import ANGLES, AngleMeasurement, JointSample, WrenchSample
from recorded_faults import BAGS, Filtered, samples, spoilt, without_weight
from tiers import nightly

CYCLE = BAGS[2]


def played(change, begin=0.0, end=1.15, path=CYCLE, **parameters):
    """Return a pipeline that has taken a part of a bag whose wrenches are changed."""
    line = Pipeline(from_parameters(parameters))
    for sample in spoilt(samples(path, begin, end), change):
        line.on_sample(sample)
    return line


def off_by(force=(0.0,) * 3, torque=(0.0,) * 3):
    return lambda f, t, q: (np.add(f, force), np.add(t, torque))


@pytest.mark.parametrize("force", [(1.5, 0.0, 0.0), (0.0, -3.0, 0.0), (2.0, 1.0, 1.0)])
def test_a_zero_that_is_off_is_named_while_a_free_peg_turns(force):
    """The peg of working_cycle comes down through the air to 1.2 s, turning by 1 rad/s."""
    line = played(off_by(force))
    assert line.causes[0].startswith("wrench: wrench.bias_force: a free peg reads [")
    read = [float(x) for x in line.causes[0].split("[")[1].split("]")[0].split(",")]
    assert read == pytest.approx(force, abs=0.25)
    assert "tare it" in line.causes[0]
    assert line.counts["setting_adopted"] == 0


@pytest.mark.parametrize("mass", [0.2, 0.6, 1.0])
def test_a_payload_that_is_not_stated_is_named_while_the_peg_turns(mass):
    """No contact pulls the peg down, so nobody has to say that it is free."""

    def change(force, torque, q):
        up = peg_axes(q).T @ [0.0, 0.0, 9.80665 * mass]
        return force + up, torque + np.cross([0.0, 0.0, -0.03], up)

    line = played(change)
    assert line.causes[0].startswith("wrench: wrench.payload_mass: a ")
    found = float(line.causes[0].partition(" weighs ")[2].split()[0])
    assert found == pytest.approx(mass, abs=0.03)


def test_a_force_that_a_contact_could_have_is_no_payload():
    """The same force upwards, as a rim that carries the peg has it: nothing is told."""

    def change(force, torque, q):
        down = peg_axes(q).T @ [0.0, 0.0, -4.0]
        return force + down, torque + np.cross([0.0, 0.0, -0.03], down)

    assert not [cause for cause in played(change).causes if "payload_mass" in cause]


@pytest.mark.nightly
def test_without_gravity_nothing_weighs_and_a_zero_is_named():
    """Where a controller takes all weight off, a cell may state no gravity."""
    stated = {"scene.gravity": [0.0, 0.0, 0.0]}
    assert played(without_weight, end=11.7, **stated).causes == []

    def change(force, torque, q):
        force, torque = without_weight(force, torque, q)
        return np.add(force, [1.5, 0.0, 0.0]), torque

    line = played(change, **stated)
    assert line.causes[0].startswith("wrench: wrench.bias_force: a free peg reads [")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_lever_that_is_off_is_named_by_its_torque(sign):
    """The sensor is 15 mm off its place: the weight has another lever."""

    def change(force, torque, q):
        return force, np.add(torque, np.cross([0.0, sign * 0.015, 0.0], force))

    line = played(change)
    assert line.causes[0].startswith("wrench: wrench.bias_torque: a free peg reads [")
    assert "check sensor_xyz" in line.causes[0]


def hanging(force, seconds=1.5):
    """Return a pipeline that has taken a peg which is known to be 0.3 m above the hole."""
    rng, q = np.random.default_rng(7), np.array([0.01, 0.4, 0.1])
    up = peg_axes(q).T @ [0.0, 0.0, 9.80665]

    def place(sample):
        covariance = np.diag([1e-4, 1e-2, 1e-4]) ** 2
        noisy = q + rng.normal(0, [1e-4, 1e-2, 1e-4])
        where = np.array([0.0, 0.0, 0.3])
        return AngleMeasurement(sample.t_ns, noisy, covariance, where, 1e-6 * np.eye(3))

    line = Pipeline(from_parameters({}), place)
    for k in range(round(seconds * 1e3)):
        line.on_joints(JointSample(k * 10**6, ANGLES, (0.0, 0.0, 0.0)))
        held = 0.5 * up
        read = held + force(up) + rng.normal(0, 0.2, 3)
        torque = np.cross([0.0, 0.0, -0.035], held) + rng.normal(0, 0.005, 3)
        line.on_wrench(WrenchSample(k * 10**6, tuple(read), tuple(torque)))
    return line


def test_a_payload_that_is_not_stated_is_named_where_the_peg_is_known_to_be_free():
    line = hanging(lambda up: 0.3 * up)
    assert line.causes[0].startswith("wrench: wrench.payload_mass: a free peg weighs 0.3 kg more")
    across = hanging(lambda up: np.cross(up, [0.0, 0.0, 0.2]) + [0.0, 1.0, 0.0])
    assert across.causes[0].startswith("wrench: wrench.bias_force: a free peg reads [")
    assert hanging(np.zeros_like).causes == []


def test_a_zero_within_what_is_stated_of_it_is_no_cause():
    line = played(off_by((1.0, 0.0, 0.0)), **{"wrench.bias_force_stddev": 1.0})
    assert line.causes == []


@pytest.mark.parametrize("cutoff", [50.0, *nightly(20.0, 100.0)])
@pytest.mark.parametrize(("path", "begin"), [(CYCLE, 0.0), (CYCLE, 1.3), (BAGS[1], 0.0)])
def test_a_low_pass_in_the_driver_is_named_with_its_cutoff(path, begin, cutoff):
    line = played(Filtered(cutoff), begin, begin + 2.2, path)
    told = [text for text in line.causes if text.startswith("wrench: low-pass: ")]
    if path == BAGS[1]:
        # Of 0.67 s there are not stretches enough to be sure.
        assert told == []
        return
    (text,) = told
    found = float(text.split("about ")[1].split(" Hz")[0])
    # By the quietest stretch it comes out high, at most by two.
    assert 0.7 * cutoff < found < 2.0 * cutoff
    assert "turn the driver's filter off" in text


@pytest.mark.parametrize(("stated", "named"), [(50.0, False), (200.0, True)])
def test_a_low_pass_that_is_stated_is_named_only_where_it_is_another(stated, named):
    line = played(Filtered(50.0), 0.0, 2.2, CYCLE, **{"wrench.low_pass": stated})
    assert any(text.startswith("wrench: low-pass: ") for text in line.causes) == named


@pytest.mark.parametrize("path", BAGS, ids=lambda path: path.stem)
@pytest.mark.parametrize("every", [5, *nightly(1, 2)])
def test_slower_sensors_without_a_filter_are_silent(path, every):
    """Every so manyth wrench of a sound bag: noise that is white stays so."""
    line = Pipeline(from_parameters({}))
    wrenches = 0
    for sample in islice(samples(path, 0.0, 4.0), 6000):
        if hasattr(sample, "force"):
            wrenches += 1
            if wrenches % every:
                continue
        line.on_sample(sample)
    assert line.causes == []


def test_joint_states_that_come_behind_their_wrenches_make_no_setting_wrong():
    """A transport that holds joint states back by 1.5 ms: what is looked at is the newest."""
    line, late = Pipeline(from_parameters({})), []
    for sample in samples(CYCLE, 6.0, 8.5):
        if isinstance(sample, JointSample):
            late.append(sample)
            continue
        while late and late[0].t_ns + 1_500_000 <= sample.t_ns:
            line.on_joints(late.pop(0))
        line.on_wrench(sample)
    assert line.counts["joints_late"] > 1000
    assert line.causes == []
