"""Simulated bags: what they hold, and that the committed ones come out of their configurations."""

import json
from dataclasses import replace

import numpy as np
import pytest

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import write_bag
from peg_on_hole_ros.cli.settings import load
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.replay.run import CONFIGURATION_METADATA, stored_configuration
from peg_on_hole_ros.sim.measure import START_NS, measure
from simulated import ROOT, SAMPLES, truth
from tiers import at_push

pytestmark = pytest.mark.xdist_group("simulation")

INPUTS = ["/joint_states", "/wrench"]
TRUTH = ["/truth/contact_mode", "/truth/contacts", "/truth/state"]


def rows(bag):
    """Topic, log time, texts and numbers of every message."""
    for topic, log_ns, message in bag.messages(INPUTS + TRUTH):
        if topic == "/wrench":
            f, t = message.wrench.force, message.wrench.torque
            yield topic, log_ns, message.header.frame_id, [f.x, f.y, f.z, t.x, t.y, t.z]
        elif topic == "/truth/contact_mode":
            yield topic, log_ns, message.data, []
        else:
            numbers = [*message.position, *message.velocity, *message.effort]
            yield topic, log_ns, list(message.name), numbers


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")

    def write(name, **more):
        path = folder / f"{name}{len(more)}.mcap"
        if not path.exists():
            write_bag(path, truth(name), **more)
        return path

    return write


def simulated_part(bag):
    """Leave out the estimator's own settings: they may be tuned without a new simulation."""
    configuration = stored_configuration(bag)
    scene = replace(configuration.scene, friction_stddev=0.0, clearance_stddev=0.0)
    used = (scene, configuration.wrench, configuration.joints, configuration.topics)
    return used, {k: v for k, v in bag.metadata.items() if k != CONFIGURATION_METADATA}


@pytest.mark.parametrize("name", at_push(SAMPLES[:2], SAMPLES))
def test_committed_bag_comes_out_of_its_configuration(name, written):
    committed = ROOT / "bags" / f"{name}.mcap"
    assert committed.stat().st_size <= 5_000_000
    again, before = Bag(written(name)), Bag(committed)
    assert simulated_part(again) == simulated_part(before)
    count = 0
    for new, old in zip(rows(again), rows(before), strict=True):
        assert new[:3] == old[:3]
        # Another machine's rounding may choose other steps of the integrator: 1e-5 N of
        # reactions in the hundreds. Forces that have fallen to millinewtons are differences of
        # such: 1e-9 of a hundred newtons. Angles and rates agree far closer.
        least = 1e-7 if new[0] in ("/wrench", "/truth/contacts") else 1e-8
        assert np.allclose(new[3], old[3], rtol=1e-6, atol=least), new
        count += 1
    assert count > 2000


@pytest.mark.parametrize("name", SAMPLES)
def test_committed_bag_carries_the_present_defaults(name):
    """What is in none of the file's lines is as it is now, not as when the bag was made."""
    configuration, _ = load(ROOT / "config" / f"{name}.yaml")
    stored = stored_configuration(Bag(ROOT / "bags" / f"{name}.mcap"))
    assert to_parameters(stored) == to_parameters(configuration), (
        f"make it anew: peg-on-hole simulate --config config/{name}.yaml --out bags/{name}.mcap"
    )


def test_bag_holds_the_truth_that_was_integrated(written):
    result = truth("closing_without_slip")
    bag = Bag(written("closing_without_slip"))
    seen = list(rows(bag))
    states = [row for row in seen if row[0] == "/truth/state"]
    assert len(states) == len(result.t_ns)
    assert [row[1] - START_NS for row in states] == result.t_ns.tolist()
    numbers = np.array([row[3] for row in states])
    assert numbers[:, [0, 3, 4, 5]] == pytest.approx(np.c_[result.q[:, 0], result.rates])
    contacts = [row for row in seen if row[0] == "/truth/contacts"]
    assert contacts[0][2] == ["K", "B1", "B2"]
    assert len(contacts) == result.known.sum() < len(states)
    values = np.array([row[3] for row in contacts])
    assert (values[:, :3] == 1).all()
    assert values[:, 3:6] == pytest.approx(result.slip_speed[result.known])
    assert values[:, 6:] == pytest.approx(result.normal[result.known])
    modes = [row[2] for row in seen if row[0] == "/truth/contact_mode"]
    assert modes == ["three_point", "unknown"]
    wrench = [row[3] for row in seen if row[0] == "/wrench"]
    samples = [s.force + s.torque for s in measure(result) if hasattr(s, "force")]
    assert wrench == [list(sample) for sample in samples]


def test_truth_angles_wrap_as_the_nodes_do(written):
    bag = Bag(written("working_cycle"))
    phi = np.array([row[3][2] for row in rows(bag) if row[0] == "/truth/state"])
    true = truth("working_cycle").q[:, 2]
    assert true.max() > np.pi >= phi.max() and phi.min() > -np.pi
    assert np.exp(1j * phi) == pytest.approx(np.exp(1j * true), abs=1e-12)


def test_metadata_says_what_the_bag_is(written):
    metadata = Bag(written("closing_without_slip")).metadata
    about = metadata["peg_on_hole_simulation"]
    assert about["ended_by"] == "jammed"
    assert "The paper's scene" in about["origin"]
    assert "seed 1: force 0.2 N, torque 0.005 N m, orientation 0.0001 rad" in about["noise"]
    events = json.loads(about["events"])
    assert events[0]["stamp"] > START_NS and "wedged" in events[0]["what"]
    assert json.loads(metadata["peg_on_hole_configuration"]["scene.peg_diameter"]) == 0.0499


def test_another_seed_is_another_bag_of_the_same_truth(written):
    one, other = (rows(Bag(written("closing_with_slip", **k))) for k in ({}, {"seed": 99}))
    for a, b in zip(one, other, strict=True):
        assert a[:2] == b[:2]
        assert (a[3] == b[3]) == a[0].startswith("/truth")
