"""Whether a peg at rest on three contacts can stay there by Coulomb friction."""

import numpy as np
from scipy.optimize import nnls

from peg_on_hole_ros.sim.dynamics import contacts
from peg_on_hole_ros.sim.guided import hole_axes
from peg_on_hole_ros.sim.holder import mass_centre

# Edges of the pyramid inside each friction cone; it holds up to 1 % less than the cone.
EDGES = 24


def rest_residual(p: np.ndarray, q: np.ndarray, F: np.ndarray, M: np.ndarray) -> float:
    """
    Return how much of a load three contacts at rest cannot balance, as a share of it.

    Zero: there are forces inside the friction cones that balance it, so rest is a solution (they
    are not unique: nine components, six equations).

    Parameters
    ----------
    p : ndarray
        Scene.
    q : ndarray, shape (3,)
    F, M : ndarray, shape (3,)
        Of the holder about the mass centre, hole axes [N], [N m].

    """
    points, _, normals, _ = contacts(p, np.asarray(q, float), np.zeros(3), 1.0)
    at_rest = np.zeros((3, 6))
    at_rest[0, :3] = q
    centre = mass_centre(p, at_rest)[0]
    columns = []
    # Metres become comparable with the force rows by the hole's radius.
    radius = p[1] / 2
    for point, normal in zip(points, normals, strict=True):
        point, normal = hole_axes(q[1], point), hole_axes(q[1], normal)
        a = np.cross(normal, [0.0, 0.0, 1.0])
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        for angle in np.arange(EDGES) * (2 * np.pi / EDGES):
            force = normal + p[6] * (np.cos(angle) * a + np.sin(angle) * b)
            columns.append([*force, *np.cross(point - centre, force) / radius])
    load = np.concatenate([F + p[3] * p[8:11], M / radius])
    _, residual = nnls(np.array(columns).T, -load)
    return float(residual / max(np.linalg.norm(load), 1e-12))
