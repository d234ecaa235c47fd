"""What moves in the drawing: pose, contacts, forces and reactions, in the axes of the tilt."""

import numpy as np

from peg_on_hole_ros.mechanics.geometry import contact_geometry
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.records import CONTACTS

# The peg leans in the plane of h and z, its top towards -h; e is square to both.
_AXES = ("h", "e", "z")


def moving(moments: dict[str, np.ndarray], scene: Scene) -> dict[str, np.ndarray]:
    """
    Return the columns that the drawing needs.

    Parameters
    ----------
    moments : dict of str to ndarray, shape (n,)
        See `Tracks.moments`.
    scene : Scene

    Returns
    -------
    dict of str to ndarray, shape (n,)
        `t` [s]; `gamma`, `psi`, `phi` [rad]; `psi_stddev`, `phi_stddev` [rad], NaN where they are
        not determined; `p_h`, `p_e`, `p_z` of the peg's origin [m];
        `S1`, `b`, `a1` of the contact's geometry [m], NaN where there is no three-point contact;
        for each contact reaction and `_stddev` [N], `_closed`, and the force on the peg as `h_`,
        `e_`, `z_` [N]; `friction`, `jamming_risk`.

    """
    gamma, psi = moments["gamma"], moments["psi"]
    found = {
        name: moments[name] for name in ("t", "gamma", "psi", "phi", "psi_stddev", "phi_stddev")
    }
    place = _turned(psi, *(moments[axis] for axis in "xyz"))
    found |= {f"p_{axis}": column for axis, column in zip(_AXES, place)}
    found |= _geometry(gamma, scene)
    for contact in CONTACTS:
        force = _turned(psi, *(moments[f"{axis}_{contact}"] for axis in "XYZ"))
        found |= {f"{axis}_{contact}": column for axis, column in zip(_AXES, force)}
        for name in (contact, f"{contact}_stddev", f"{contact}_closed"):
            found[name] = moments[name]
    return found | {name: moments[name] for name in ("friction", "jamming_risk")}


def _turned(psi, x, y, z):
    c, s = np.cos(psi), np.sin(psi)
    return c * x + s * y, c * y - s * x, z


def _geometry(gamma, scene):
    rests = (gamma > scene.gamma0) & (gamma < np.pi / 2)
    columns = {name: np.full(len(gamma), np.nan) for name in ("S1", "b", "a1")}
    if rests.any():
        geometry = contact_geometry(scene, gamma[rests].astype(float))
        for name, column in columns.items():
            column[rests] = getattr(geometry, name)
    return columns
