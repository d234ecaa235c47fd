"""Where no acceleration is unlikely, the estimator is the filter of the differential equations."""

import numpy as np
import pytest

from compiled_beside import Compiled, cell_of, samples, with_scene
from driven_filter import DrivenFilter
from peg_on_hole_ros.estimator import mixture
from peg_on_hole_ros.estimator.methods import dde_driven
from peg_on_hole_ros.mechanics.kernel import accelerate, workspace
from peg_on_hole_ros.mechanics.reference import peg_axes, solve_contact
from peg_on_hole_ros.mechanics.scene import Scene, scene_scalars
from simulated import truth
from tiers import nightly

# The method as it is shipped, with friction along the mean slip as the driven filter has it (a
# share of zero would leave a peg at rest without any direction), from the first sample on.
WIDE = dde_driven.SETTINGS | {"direction_share": 1e-4, "settling": 0.0}


def begin(estimator, row, rates, rate_stddev):
    """Start an estimator at rates that are known to a standard deviation."""
    estimator.start(row.q, row.R, rate_stddev, estimator.cell.scene.friction, 1e-9, *_NOTHING)
    if isinstance(estimator, Compiled):
        estimator.mixture.x[:, 3:6] = rates
        mixture.combine(estimator.state)
    else:
        estimator.x[3:] = rates


_NOTHING = np.zeros(0), np.zeros(0)


@pytest.mark.parametrize("seed", range(8))
def test_one_wrench_gives_what_the_equations_are_solved_for(seed):
    rng = np.random.default_rng(seed)
    scene = Scene(friction=rng.uniform(0.05, 0.3))
    # A state that is known, and a prior that is 1e6 times as wide as the wrench's noise: it takes
    # 1e-12 of the answer.
    noise = np.diag([1e-8] * 3 + [1e-12] * 3)
    cell = cell_of(scene, noise, **WIDE)
    estimator = Compiled(cell, 1)
    row = type("Row", (), {"q": rng.uniform([0.1, -3, -3], [0.35, 3, 3]), "R": 1e-30 * np.eye(3)})
    rates = rng.uniform(-1.0, 1.0, 3)
    begin(estimator, row, rates, 1e-15)
    u = rng.normal(size=6) * ([30.0] * 3 + [0.5] * 3)
    estimator.predict(0.0)
    estimator.weigh(u)
    x = estimator.mean[:6]
    assert np.allclose(x, [*row.q, *rates], rtol=0.0, atol=1e-12)
    found = np.concatenate([estimator.mean[6:9], estimator.mean[10:]])
    R = peg_axes(x[:3])
    solved = solve_contact(scene, x[:3], x[3:], R @ u[:3], R @ u[3:])
    answer = np.empty(6)
    accelerate(scene_scalars(scene), np.zeros(3), x, u, workspace(), answer)
    for expected in (np.concatenate([solved.acceleration, solved.normal]), answer):
        for part in (slice(0, 3), slice(3, 6)):
            size = np.abs(expected[part]).max()
            assert np.abs(found[part] - expected[part]).max() < 1e-9 * size


# Stretches on which the peg slides, and how long at least all slips are told and a step is stable.
STRETCHES = [
    ("closing_with_slip", 0, 500),
    ("working_cycle", 1220, 1200),
    ("working_cycle", 2520, 300),
    ("working_cycle", 3520, 740),
    ("working_cycle", 4320, 940),
    ("working_cycle", 5320, 150),
    ("working_cycle", 9010, 1000),
]
ENDS = {1220: 2480, 2520: 3480, 3520: 4280, 4320: 5280, 5320: 5780, 9010: 10200}


@pytest.mark.parametrize(
    "name, first, least",
    [
        STRETCHES[2],
        *nightly(*STRETCHES[:2], *STRETCHES[3:]),
    ],
)
def test_the_sample_scenes_as_the_driven_filter_has_them(name, first, least):
    """
    Both hold a wrench until the next and take one explicit step.

    They are compared until a slip is not told, or a step of the driven filter is unstable: within
    a millisecond friction then changes by more than itself, and neither tells anything.
    """
    recorded = truth(name)
    rows, noise = samples(recorded)
    cell = cell_of(with_scene(recorded, friction_stddev=0.0), noise, **WIDE)
    driven, wide = DrivenFilter(cell), Compiled(cell, 1)
    compared, last = 0, None
    for k in range(first, ENDS.get(first, len(rows))):
        row = rows[k]
        for estimator in (driven, wide):
            if last is None:
                begin(estimator, row, recorded.rates[k], 0.05)
            else:
                estimator.predict(row.t - last)
                if row.q is not None:
                    estimator.correct(row.q, row.R)
            estimator.weigh(row.u)
        last = row.t
        speed, stddev = driven.slips()
        if np.any(speed < 3.0 * stddev) or driven.growth > 1.1:
            break
        own = np.sqrt(np.diagonal(driven.P))
        assert np.all(np.abs(wide.mean[:6] - driven.x) < 0.25 * own), (k, compared)
        assert np.all(np.abs(np.sqrt(np.diagonal(wide.covariance)[:6]) / own - 1.0) < 0.1)
        compared += 1
    assert compared >= least


def test_no_slip_is_told_where_a_peg_closes_without_slip():
    """The third scene has nothing to compare: it slides slower than the driven filter can tell."""
    recorded = truth("closing_without_slip")
    rows, noise = samples(recorded, count=600)
    cell = cell_of(with_scene(recorded, friction_stddev=0.0), noise, **WIDE)
    driven, told = DrivenFilter(cell), []
    for k, row in enumerate(rows):
        if k == 0:
            begin(driven, row, recorded.rates[0], 0.05)
        else:
            driven.predict(row.t - rows[k - 1].t)
            if row.q is not None:
                driven.correct(row.q, row.R)
        driven.weigh(row.u)
        told.append(np.all(recorded.slip_speed[k] > 3.0 * driven.slips()[1]))
    assert sum(told) < 5
