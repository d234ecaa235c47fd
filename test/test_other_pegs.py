"""Pegs and sensors unlike those that all thresholds were chosen with: size, mass, rate, noise."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from grid_score import run_seeds
from peg_on_hole_ros.edges.live.diagnostics import Diagnostics
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.options import Configuration, JointInput, WrenchInput
from peg_on_hole_ros.pipeline import Pipeline
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.simulation.measure import measure
from peg_on_hole_ros.simulation.plan import plan_from_tree
from peg_on_hole_ros.simulation.truth import integrate


class Peg(NamedTuple):
    """Diameter and clearance [m], mass [kg], noise [N], [N m], stiffness [N/m], [N m/rad]."""

    diameter: float
    clearance: float
    mass: float
    force: float
    torque: float
    stiffness: float
    rotational: float
    tilt: float = 0.19


PEGS = {
    "4 mm": Peg(4e-3, 8e-6, 0.2, 0.05, 1e-3, 5e3, 50.0),
    "10 mm": Peg(0.01, 2e-5, 0.2, 0.05, 1e-3, 5e3, 100.0),
    "50 mm": Peg(0.05, 1e-4, 0.5, 0.2, 5e-3, 2e4, 2e3),
    "150 mm": Peg(0.15, 3e-4, 8.0, 2.0, 0.1, 1e5, 2e4),
}


@cache
def closing(name, wrench_rate=1000, joint_rate=500, rate=-0.05, duration=0.6):
    """Return a peg that closes and turns about its axis by 2 rad/s, friction uncertain by 0.05."""
    peg = PEGS[name]
    scene = Scene(
        hole_diameter=peg.diameter,
        peg_diameter=peg.diameter - peg.clearance,
        peg_height=1.4 * peg.diameter,
        peg_mass=peg.mass,
    )
    configuration = Configuration(
        scene=scene,
        wrench=WrenchInput(
            sensor_xyz=(0.0, 0.0, 1.4 * peg.diameter),
            force_stddev=peg.force,
            torque_stddev=peg.torque,
        ),
        joints=JointInput(),
    )
    tree = {
        "lead_in": 0.05,
        "wrench_rate": wrench_rate,
        "joint_rate": joint_rate,
        "holder": {
            "stiffness": peg.stiffness,
            "rotational_stiffness": peg.rotational,
            "force_limit": 1000.0,
            "torque_limit": 200.0,
        },
        "start": {
            "angles": [peg.tilt, 0.0, 0.0],
            "rates": [rate, 0.0, 2.0],
            "offset": [0.0, 0.0, -0.001],
        },
        "phases": {"close": {"kind": "contact", "duration": duration, "rates": [rate, 0.0, 2.0]}},
    }
    return integrate(plan_from_tree(configuration, tree))


def covered(truth, seeds=3):
    """Return the shares of errors inside their 95 % bounds after 0.1 s, shape (9,)."""
    runs = run_seeds(truth, range(50, 50 + seeds))
    told = truth.t_ns >= 100_000_000
    assert not runs.diverged.any()
    inside = np.abs(runs.error[:, told]) <= 1.96 * runs.stddev[:, told]
    assert runs.contact[:, told].mean() > 0.9
    return inside[runs.contact[:, told]].mean(axis=0)


# Errors are correlated over some 20 ms: of 3 times 0.5 s a share of 0.95 scatters by 0.02 to 0.03.
LEAST = 0.88


def with_friction(truth, friction):
    """Return a truth of which another friction is told."""
    plan = truth.plan
    scene = replace(plan.configuration.scene, friction=friction)
    return replace(
        truth, plan=replace(plan, configuration=replace(plan.configuration, scene=scene))
    )


@pytest.mark.parametrize(
    ("name", "wrench_rate", "joint_rate"),
    [
        *((name, 1000, 500) for name in PEGS),
        *((name, *rates) for name in ("4 mm", "150 mm") for rates in ((100, 100), (5000, 500))),
    ],
)
def test_bounds_hold_for_other_pegs_and_rates(name, wrench_rate, joint_rate):
    share = covered(closing(name, wrench_rate, joint_rate))
    assert share.min() > LEAST, share.round(3)


@pytest.mark.parametrize("name", ["4 mm", "10 mm"])
@pytest.mark.parametrize("off", [-0.2, 0.2])
def test_a_clearance_is_learnt_or_left_and_never_run_away_with(name, off):
    """Of 4 mm a quarter of it was learnt, 15 deviations off: reactions covered in 3 %."""
    truth = closing(name, duration=1.2)
    configuration, clearance = truth.plan.configuration, PEGS[name].clearance
    told = replace(
        configuration.scene,
        peg_diameter=configuration.scene.peg_diameter - off * clearance,
        clearance_stddev=0.2 * clearance,
    )
    plan = replace(truth.plan, configuration=replace(configuration, scene=told))
    share = covered(replace(truth, plan=plan), seeds=2)
    # At 10 mm N_K is covered in 86 to 88 %: learnt together, the two are not told well apart.
    assert share[6:].min() > 0.8, share.round(3)


def test_friction_is_learnt_where_no_step_is_found_within_what_is_allowed():
    """At 100 Hz all steps of some runs are refused; friction then stayed as it was stated."""
    truth = with_friction(closing("50 mm", 100, 100), 0.125)
    pipeline = Pipeline(truth.plan.configuration)
    for _ in pipeline.play(measure(truth, 3)):
        pass
    friction, stddev = pipeline.filter.friction
    assert pipeline.counts["step_limited"]
    assert stddev < 0.01 and abs(friction - 0.2) < 3 * stddev


def with_tare(samples, newton):
    for sample in samples:
        if isinstance(sample, WrenchSample):
            x, y, z = sample.force
            sample = sample._replace(force=(x + newton, y, z))
        yield sample


SLOW_FOR_THEIR_SIZE = [
    ("4 mm", 1000, 500),
    ("10 mm", 250, 250),
    ("10 mm", 500, 500),
    ("50 mm", 100, 100),
    ("50 mm", 250, 250),
]
WRONG = ("innovations_too_large", "forces_out_of_balance")


@pytest.mark.parametrize(("name", "wrench_rate", "joint_rate"), SLOW_FOR_THEIR_SIZE)
def test_a_tare_that_is_off_is_told_where_hardly_a_step_is_believed(name, wrench_rate, joint_rate):
    truth = closing(name, wrench_rate, joint_rate)
    for off in (0.0, 10.0 * PEGS[name].force):
        pipeline = Pipeline(truth.plan.configuration)
        for _ in pipeline.play(with_tare(measure(truth, 5), off)):
            pass
        counts = pipeline.counts
        # A wrong tare may end the contact mode, and with it these steps.
        assert off or counts["step_without_direction"] > 20
        assert any(counts[name] for name in WRONG) == (off > 0), counts
        report, _ = Diagnostics().report(0, 10**9, dict(counts), pipeline.health)
        status = next(item for item in report["status"] if item["name"].endswith("filter"))
        assert ("the tare" in status["message"]) == (off > 0)
