"""What a motion tells of the parameters, against differences of the filter's own innovations."""

import json
from dataclasses import replace

import numpy as np
import pytest
from peg_on_hole_ros.estimation.filters.contact import ContactFilter
from side_by_side import bag_samples

from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges import observability_text
from peg_on_hole_ros.edges.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.edges.bags.reader import Bag
from peg_on_hole_ros.edges.bags.writer import BagWriter
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.edges.messages.output import STRING
from peg_on_hole_ros.edges.replay import stored_configuration
from peg_on_hole_ros.estimation.identification.observability import (
    NAMES,
    ObservingFilter,
    observability,
)
from peg_on_hole_ros.pipeline import Pipeline
from simulated import ROOT
from small_bags import JOINTS, MS, WRENCH, header, joints, wrench

BAG = ROOT / "bags" / "closing_with_slip.mcap"


@pytest.fixture(scope="module")
def configuration():
    found = from_parameters(read_parameters(ROOT / "config" / "closing_with_slip.yaml"))
    scene = replace(found.scene, friction_stddev=0.0, clearance_stddev=0.0)
    options = replace(found.filter, slow_slip=0.0)
    return replace(found, scene=scene, filter=options)


class Whitened(ContactFilter):
    """Keeps the innovations over the root of their covariance, where all contacts slide."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.kept = []

    def correct(self, q, R):
        result = super().correct(q, R)
        residual, root = self.last_innovation()
        white = np.linalg.solve(np.reshape(root, (3, 3)), residual)
        self.kept.append(white if self._sliding[0] else np.full(3, np.nan))
        return result


def run(configuration, make, count=900):
    pipeline = Pipeline(configuration, make=make)
    for sample, _ in zip(bag_samples(BAG, configuration), range(count)):
        pipeline.on_sample(sample)
    return pipeline.filter


def changed(configuration, name, by):
    scene, wrench = configuration.scene, configuration.wrench
    if name == "friction":
        return replace(configuration, scene=replace(scene, friction=scene.friction + by))
    if name == "clearance":
        smaller = replace(scene, peg_diameter=scene.peg_diameter - by)
        # A smaller peg of the same material would be another mass centre and inertia too.
        kept = replace(
            smaller,
            transverse_inertia=scene.transverse_inertia,
            axial_inertia=scene.axial_inertia,
        )
        return replace(configuration, scene=kept)
    _, kind, axis = name.split("_")
    values = list(getattr(wrench, f"bias_{kind}"))
    values["xyz".index(axis)] += by
    return replace(configuration, wrench=replace(wrench, **{f"bias_{kind}": tuple(values)}))


@pytest.mark.parametrize(
    ("name", "step"),
    [("friction", 1e-4), ("clearance", 1e-8), ("bias_force_y", 1e-2), ("bias_torque_z", 1e-4)],
)
def test_information_is_that_of_differences(configuration, name, step):
    found = run(configuration, ObservingFilter).information
    ahead, behind = (
        np.array(run(changed(configuration, name, by), Whitened).kept) for by in (step, -step)
    )
    told = np.nansum(((ahead - behind) / (2 * step)) ** 2)
    i = NAMES.index(name)
    # The filters also differ in where they take their tangents.
    assert found[i, i] == pytest.approx(told, rel=0.1)


@pytest.mark.parametrize("of", [{"model": "auto"}, {"method": "square_root"}])
def test_a_motion_tells_the_same_whatever_filter_is_configured(of):
    bag = Bag(BAG)
    stored = stored_configuration(bag)
    other = replace(stored, filter=replace(stored.filter, **of))
    full, found = (observability_text.observe(bag, one) for one in (stored, other))
    assert found.seconds == full.seconds > 0.5
    np.testing.assert_array_equal(found.together, full.together)


def test_the_estimate_is_that_of_the_filter(configuration):
    observing, plain = (run(configuration, make, 300) for make in (ObservingFilter, Whitened))
    np.testing.assert_array_equal(observing.x, plain.x)
    np.testing.assert_array_equal(observing.Z, plain.Z)


def test_rates_that_walk_carry_their_walk_into_the_angles(configuration):
    kalman = Pipeline(configuration, make=ObservingFilter).filter
    kalman.start(np.array([0.2, 0.1, -0.3]), 1e-8 * np.eye(3))
    before, dt = kalman._K.copy(), 0.004
    kalman.predict(dt, False)
    density = configuration.filter.free_rate_noise**2
    # Many short walks, each of which moves the rate, which moves the angle.
    steps = 4000
    left = dt * (steps - np.arange(steps) - 0.5) / steps
    walk = density * dt / steps * np.array([[left @ left, left.sum()], [left.sum(), steps]])
    A = np.eye(12)
    A[range(3), range(3, 6)] = dt
    added = kalman._K - A @ before @ A.T
    assert added[:6, :6] == pytest.approx(np.kron(walk, np.eye(3)), rel=1e-6, abs=1e-18)


def test_what_looks_alike_is_named_and_what_moves_nothing_too():
    # Useful: 1 N, 0.05 N m. Told only as a sum; torque about x moves nothing.
    information = np.diag([1e6, 1e14, 0, 1e6, 1e6, 0, 0, 1e8, 1e8, 1e8])
    x, y = NAMES.index("bias_force_x"), NAMES.index("bias_torque_y")
    along = np.zeros(10)
    along[[x, y]] = 100.0, 2000.0
    found = observability(information + np.outer(along, along), 1e-4, 1.0, 0.5, 0.1)
    seen = dict(zip(NAMES, found.seen))
    assert not seen["bias_force_x"] and not seen["bias_torque_y"] and not seen["bias_torque_x"]
    assert sum(seen.values()) == 7 and found.rank == 8 and found.condition == np.inf
    assert found.partner[x] == "bias_torque_y" and found.partner[y] == "bias_force_x"
    assert np.isinf(found.alone[NAMES.index("bias_torque_x")])
    text = "\n".join(observability_text.lines(found))
    assert "8 of 10 combinations" in text and "turned by 29 degrees" in text
    assert "force bias along x: not told apart" in text
    assert "looks like torque bias about y; turn the peg about its axis by 90 degrees" in text
    assert "torque bias about x: not seen" in text and "moves nothing that is measured" in text
    assert "friction: seen, to 0.001; it can be estimated" in text


def test_nothing_is_told_where_nothing_slides():
    found = observability(np.zeros((10, 10)), 1e-4)
    assert not found.seen.any() and found.rank == 0
    assert "never surely slide" in observability_text.lines(found)[0]


def test_inspect_says_it(capsys):
    config = str(ROOT / "config" / "closing_with_slip.yaml")
    assert main(["inspect", str(BAG), "--config", config, "--observability"]) == 0
    text = capsys.readouterr().out
    assert "force bias along x: not told apart" in text and "friction: seen" in text
    assert main(["inspect", str(BAG), "--config", config, "--observability", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["observability"]
    assert told["of"] == 10 and 6 <= told["rank"] < 10
    assert told["parameters"]["bias_force_x"]["looks_like"] == "bias_torque_y"


def test_a_peg_that_hangs_free_tells_a_bias():
    """As well as the filter has it that learns it, and of nothing else."""
    bag = ROOT / "bags" / "working_cycle.mcap"
    plain = from_parameters(read_parameters(ROOT / "config" / "working_cycle.yaml"))
    wrench = replace(plain.wrench, bias_force_stddev=100.0, bias_torque_stddev=10.0)
    told = Pipeline(plain, make=ObservingFilter)
    learnt = Pipeline(replace(plain, wrench=replace(wrench, bias_force_stddev=100.0)))
    for sample, _ in zip(bag_samples(bag, plain), range(1700)):
        told.on_sample(sample)
        learnt.on_sample(sample)
    found = told.filter.observability()
    assert 1.0 < found.free < 1.2 and not found.seconds and found.rank == 6
    stddev = np.sqrt(np.diagonal(learnt.filter.offset_spread[:6, 2:8]))
    # It takes the last two blocks of 0.1 s as well, where the filter waits for the next.
    np.testing.assert_allclose(found.together[2:8], stddev, rtol=0.3)
    assert (found.together[2:8] < stddev).all()
    assert not found.seen[[0, 1, 8, 9]].any() and found.seen[2:8].all()
    text = observability_text.lines(found)
    assert "never surely slide" in text[0] and "s in the air" in text[0] and len(text) == 7
    assert text[1].startswith("force bias along x: seen, to 0.1")


@pytest.mark.parametrize("how", ["stated", "tared"])
def test_a_peg_in_the_air_is_there_whatever_its_untared_sensor_reads(tmp_path, how):
    """3 N off are a contact to whom the configuration or a tare does not tell what they are."""
    force = 0.5 * 9.80665 * np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    torque = np.cross([0.0, 0.0, -0.035], force)
    with BagWriter(tmp_path / "air.mcap") as bag:
        for i in range(1200):
            t_ns = 10**9 + i * MS
            bag.write("/joint_states", JOINTS, joints(t_ns), t_ns)
            bag.write("/wrench", WRENCH, wrench(t_ns, force + [3.0, 0.0, 0.0], torque), t_ns)
            if how == "tared" and i == 100:
                bag.write(EVENT_TOPIC, STRING, {"data": "tare"}, t_ns)
    stddev = {"wrench.bias_force_stddev": 3.0} if how == "stated" else {}
    bag, given = Bag(tmp_path / "air.mcap"), from_parameters(stddev)
    shares = []
    found = observability_text.observe(bag, given, shares.append)
    assert found.free > 1.0 and found.seen[2:8].all()
    assert shares == sorted(shares) and 0.8 < shares[-1] < 1.0


def test_a_moment_of_sliding_does_not_make_a_bias_that_the_air_tells_too_small(configuration):
    """A few newtons of a touch-down are no load: 0.2 N would be of no use beside 4 % of them."""
    made = []
    run(configuration, lambda *given: made.append(ObservingFilter(*given)) or made[-1], 2)
    (observing,) = made
    observing.seconds, observing._pressed = 0.001, 0.003
    observing.information[range(2, 8), range(2, 8)] = 1 / 0.2**2
    assert observing.observability().seen[2:5].all()


def test_joint_states_that_come_late_are_put_in_their_place(tmp_path):
    """As in a replay: recorded 10 ms behind the wrenches of their stamps, they tell the same."""
    source = Bag(BAG)
    given = stored_configuration(source)
    rows = []
    for topic, t_ns, message in source.messages(["/wrench", "/joint_states"]):
        if topic == "/joint_states":
            fields = {"header": header(t_ns, ""), "name": message.name}
            rows.append((t_ns + 10 * MS, topic, JOINTS, fields | {"position": message.position}))
        else:
            sides = message.wrench.force, message.wrench.torque
            fields = wrench(t_ns, *([side.x, side.y, side.z] for side in sides))
            rows.append((t_ns, topic, WRENCH, fields))
    with BagWriter(tmp_path / "late.mcap") as bag:
        for t_ns, topic, ros_type, fields in sorted(rows, key=lambda row: row[0]):
            bag.write(topic, ros_type, fields, t_ns)
    found = observability_text.observe(Bag(tmp_path / "late.mcap"), given)
    ordered = observability_text.observe(source, given)
    assert found.seconds == ordered.seconds > 0.5
    np.testing.assert_allclose(found.together, ordered.together, rtol=1e-9)
