"""Arrays of states through the compiled equations, against the numpy model."""

import numpy as np
import pytest

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics import over_arrays, reference
from peg_on_hole_ros.mechanics.scene import Scene

SCENE = Scene()


def test_many_states_are_solved_as_the_numpy_model_solves_them():
    rng = np.random.default_rng(1)
    n = 200
    q = np.array([rng.uniform(0.08, 1.2, n), *rng.uniform(-3, 3, (2, n))])
    rates = rng.uniform(-2, 2, (3, n))
    wrench = rng.uniform(-5, 5, (6, n)) * np.array([1, 1, 1, 0.05, 0.05, 0.05])[:, None]
    found = over_arrays.solve_many(SCENE, q, rates, wrench, 1e-4)
    A, r = reference.six_equations(SCENE, q, rates, wrench, 1e-4)
    y = np.linalg.solve(np.moveaxis(A, -1, 0), r.T[..., None])[..., 0].T
    size = np.max(np.abs(y), axis=1)[:, None]
    np.testing.assert_allclose(np.vstack([found.acceleration, found.normal]) / size, y / size,
                               rtol=1e-9, atol=1e-11)  # fmt: skip
    one = over_arrays.solve_many(SCENE, q[:, :3], rates[:, :3], np.zeros(6), 1e-4)
    cubic = reference.friction_cubic(SCENE, q[:, 0], rates[:, 0], 1e-4)
    assert one.determinant[0] == pytest.approx(np.polyval(cubic[::-1], SCENE.friction), rel=1e-9)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"q": np.array([[0.1, 0.05], [0, 0], [0, 0]])}, "gamma = 0.05 rad has no three-point"),
        ({"rates": np.array([[0.1, np.nan], [0, 0], [0, 0]])}, "state 1 of 2 is not finite"),
        ({"rates": np.zeros(3)}, None),
        ({"q": np.array([0.1, 0, 0])}, r"shapes \(3,\), .* are not \(3, n\)"),
    ],
)
def test_bad_states_are_refused(change, message):
    given = {
        "q": np.array([[0.1, 0.2], [0, 0], [0, 0]]),
        "rates": np.array([[-0.1, 0.1], [0, 0], [1, 1]]),
        "wrench_P": np.zeros(6),
    } | change
    if message is None:
        # A peg at rest is solved with a velocity scale, where friction is zero at rest.
        assert np.all(
            np.isfinite(over_arrays.solve_many(SCENE, **given, slip_velocity_scale=1e-5).normal)
        )
        with pytest.raises(PegOnHoleError, match="needs slip_velocity_scale above 0 m/s"):
            over_arrays.solve_many(SCENE, **given)
        return
    with pytest.raises(PegOnHoleError, match=message):
        over_arrays.solve_many(SCENE, **given)
