"""What a motion tells of the parameters, against estimators that learn one of them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.bag_steps import bag_samples
from estimates import learnt as learnt_by
from peg_on_hole_ros.bags.arrival_record import EVENT_TOPIC
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli import observability_text
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.parameters_file import read_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.identification.observability import (
    PARAMETER_NAMES,
    ObservingFilter,
    observability,
)
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.replay.run import stored_configuration
from simulated import ROOT
from small_bags import JOINTS, MS, WRENCH, header, joints, wrench
from tiers import nightly

BAG = ROOT / "bags" / "closing_with_slip.mcap"
CONFIG = ROOT / "config" / "closing_with_slip.yaml"
FORCE, TORQUE = slice(2, 5), slice(5, 8)


@pytest.fixture(scope="module")
def configuration():
    """Everything known, and friction that does not wander."""
    found = from_parameters(read_parameters(CONFIG))
    scene = replace(found.scene, friction_stddev=0.0, clearance_stddev=0.0)
    return replace(found, scene=scene, filter=replace(found.filter, friction_noise=0.0))


def run(configuration, make=ContactFilter, count=10_000, bag=BAG):
    pipeline = Pipeline(configuration, make=make)
    for sample, _ in zip(bag_samples(bag, configuration), range(count)):
        pipeline.on_sample(sample)
    return pipeline.filter


@pytest.fixture(scope="module")
def observed(configuration):
    return run(configuration, ObservingFilter)


@pytest.fixture(scope="module")
def given():
    return stored_configuration(Bag(BAG))


@pytest.fixture(scope="module")
def whole(given):
    return observability_text.observe(Bag(BAG), given)


@pytest.mark.nightly
def test_friction_alone_is_told_as_the_estimator_that_learns_it_has_it(configuration, observed):
    scene = replace(configuration.scene, friction_stddev=0.1)
    learnt = run(replace(configuration, scene=scene)).friction[1]
    told = observed.observability().alone[PARAMETER_NAMES.index("friction")]
    # The slopes of one are taken at the stated friction, of the other where it has come to.
    assert told == pytest.approx(learnt, rel=0.05)
    assert learnt < 1e-3


def test_clearance_alone_is_told_as_the_estimator_that_learns_it_has_it(configuration, observed):
    scene = replace(configuration.scene, clearance_stddev=3e-5)
    learnt = run(replace(configuration, scene=scene)).clearance[1]
    told = observed.observability().alone[PARAMETER_NAMES.index("clearance")]
    assert told == pytest.approx(learnt, rel=0.05)
    assert learnt < 1e-6


@pytest.mark.parametrize(("kind", "of", "prior"), [("force", FORCE, 3.0), ("torque", TORQUE, 0.1)])
def test_a_bias_is_told_as_the_estimator_that_learns_it_has_it(
    configuration, observed, kind, of, prior
):
    wide = replace(configuration.wrench, **{f"bias_{kind}_stddev": prior})
    kalman = run(replace(configuration, wrench=wide))
    learnt = [learnt_by(kalman)[f"bias_{kind}_{axis}_stddev"] for axis in "xyz"]
    information = observed.information[of, of] + np.eye(3) / prior**2
    told = np.sqrt(np.diagonal(np.linalg.inv(information)))
    assert told == pytest.approx(learnt, rel=0.15)
    assert max(learnt) < 0.1 * prior


def test_the_estimate_is_that_of_the_estimator(configuration):
    observing, plain = (run(configuration, make, 300) for make in (ObservingFilter, ContactFilter))
    np.testing.assert_array_equal(observing.x, plain.x)
    np.testing.assert_array_equal(observing.P, plain.P)


@pytest.mark.parametrize("of", [{"method": "quasi_static"}, *nightly({"late_window": 0.0})])
def test_a_motion_tells_the_same_whatever_estimator_is_configured(given, whole, of):
    other = replace(given, filter=replace(given.filter, **of))
    found = observability_text.observe(Bag(BAG), other)
    assert found.seconds == whole.seconds > 0.5
    np.testing.assert_array_equal(found.together, whole.together)


def test_what_looks_alike_is_named_and_what_moves_nothing_too():
    # Useful: 1 N, 0.05 N m. Told only as a sum; torque about x moves nothing.
    information = np.diag([1e6, 1e14, 0, 1e6, 1e6, 0, 0, 1e8, 1e8, 1e8])
    x, y = PARAMETER_NAMES.index("bias_force_x"), PARAMETER_NAMES.index("bias_torque_y")
    along = np.zeros(10)
    along[[x, y]] = 100.0, 2000.0
    found = observability(information + np.outer(along, along), 1e-4, 1.0, 0.5, 0.1)
    seen = dict(zip(PARAMETER_NAMES, found.seen))
    assert not seen["bias_force_x"] and not seen["bias_torque_y"] and not seen["bias_torque_x"]
    assert sum(seen.values()) == 7 and found.rank == 8 and found.condition == np.inf
    assert found.partner[x] == "bias_torque_y" and found.partner[y] == "bias_force_x"
    assert np.isinf(found.alone[PARAMETER_NAMES.index("bias_torque_x")])
    text = "\n".join(observability_text.lines(found))
    assert "8 of 10 combinations" in text and "turned by 29 degrees" in text
    assert "force bias along x: not determined" in text
    assert "looks like torque bias about y; turn the peg about its axis by 90 degrees" in text
    assert "torque bias about x: not seen" in text and "changes no measurement" in text
    assert "friction: seen, to 0.001; it can be estimated" in text


def test_nothing_is_told_where_nothing_slides():
    found = observability(np.zeros((10, 10)), 1e-4)
    assert not found.seen.any() and found.rank == 0
    assert "three contacts never slide together" in observability_text.lines(found)[0]


@pytest.mark.nightly
def test_two_motions_tell_what_each_tells(configuration):
    """The second as if the first had not been: what was gathered stays, and adds up."""
    once = run(configuration, ObservingFilter, 600)
    twice = run(configuration, ObservingFilter, 600)
    pipeline = Pipeline(configuration, make=lambda *_: twice)
    first = twice.information
    twice.end_estimate()
    np.testing.assert_array_equal(twice.information, first)
    for sample, _ in zip(bag_samples(BAG, configuration), range(600)):
        pipeline.on_sample(sample)
    np.testing.assert_allclose(twice.information, 2 * once.information, rtol=1e-6)
    assert twice.seconds == pytest.approx(2 * once.seconds)


def test_inspect_says_it(capsys):
    asked = ["inspect", str(BAG), "--config", str(CONFIG), "--observability"]
    assert main(asked) == 0
    text = capsys.readouterr().out
    assert "force bias along x: not determined" in text and "friction: seen" in text
    assert main([*asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["observability"]
    assert told["of"] == 10 and 6 <= told["rank"] < 10
    assert told["parameters"]["bias_force_x"]["looks_like"] == "bias_torque_y"


def test_a_peg_that_hangs_free_tells_a_bias():
    """And of nothing else."""
    bag = ROOT / "bags" / "working_cycle.mcap"
    plain = from_parameters(read_parameters(ROOT / "config" / "working_cycle.yaml"))
    told = run(plain, ObservingFilter, 1700, bag).observability()
    assert 1.0 < told.free < 1.2 and not told.seconds
    assert not told.seen[[0, 1, 8, 9]].any() and told.seen[2:8].all()
    text = observability_text.lines(told)
    assert (
        "three contacts never slide together" in text[0]
        and "s in the air" in text[0]
        and len(text) == 7
    )
    assert text[1].startswith("force bias along x: seen, to ")


@pytest.mark.parametrize("told", [{"tare_in_contact": True}, *nightly({"bias_force_stddev": 3.0})])
def test_a_peg_in_the_air_is_there_whatever_its_untared_sensor_reads(tmp_path, told):
    """3 N off are a contact to whom the configuration or a tare does not tell what they are."""
    force = 0.5 * 9.80665 * np.array([np.sin(0.3), 0.0, np.cos(0.3)])
    torque = np.cross([0.0, 0.0, -0.035], force)
    with BagWriter(tmp_path / "air.mcap") as bag:
        for i in range(1200):
            t_ns = 10**9 + i * MS
            bag.write("/joint_states", JOINTS, joints(t_ns), t_ns)
            bag.write("/wrench", WRENCH, wrench(t_ns, force + [3.0, 0.0, 0.0], torque), t_ns)
            if i == 100:
                bag.write(EVENT_TOPIC, STRING, {"data": "tare"}, t_ns)
    bag, shares = Bag(tmp_path / "air.mcap"), []
    given = from_parameters({f"wrench.{name}": value for name, value in told.items()})
    found = observability_text.observe(bag, given, shares.append)
    assert found.free > 1.0 and found.seen[2:8].all()
    assert shares == sorted(shares) and 0.8 < shares[-1] < 1.0


def test_joint_states_that_come_late_are_put_in_their_place(tmp_path, given, whole):
    """As in a replay: recorded 10 ms behind the wrenches of their stamps, they tell the same."""
    rows, source = [], Bag(BAG)
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
    late = observability_text.observe(Bag(tmp_path / "late.mcap"), given)
    assert late.seconds == whole.seconds > 0.5
    np.testing.assert_allclose(late.together, whole.together, rtol=1e-9)
