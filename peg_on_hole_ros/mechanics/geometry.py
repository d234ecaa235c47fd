"""Closed-form geometry of three-point contact, from the tilt gamma alone (scalars or arrays)."""

from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.scene import Scene


class ContactGeometry(NamedTuple):
    """
    Lengths of the three-point pose in the frame (h, e, z), each shaped as gamma [m].

    Attributes
    ----------
    gamma0, s, c : float, ndarray, ndarray
        Smallest tilt with three contacts [rad]; sin and cos of gamma.
    a1, a2 : ndarray
        Distance of the axes' crossing O from the hole's rim centre and from the peg's end centre.
    S1, S2, b : ndarray
        B1 = (S1, -b, 0), B2 = (S1, b, 0); S2 is their eta coordinate in the peg's end face.
    db : ndarray
        db/dgamma [m/rad]; it diverges where gamma reaches gamma0.
    h_c, z_c : ndarray
        Mass centre.
    dh_c, dz_c, ddh_c, ddz_c : ndarray
        First and second derivatives by gamma [m/rad], [m/rad^2].

    """

    gamma0: float
    s: np.ndarray
    c: np.ndarray
    a1: np.ndarray
    a2: np.ndarray
    S1: np.ndarray
    S2: np.ndarray
    b: np.ndarray
    db: np.ndarray
    h_c: np.ndarray
    z_c: np.ndarray
    dh_c: np.ndarray
    dz_c: np.ndarray
    ddh_c: np.ndarray
    ddz_c: np.ndarray


class ClosedForms(NamedTuple):
    """The fields of `ContactGeometry` after gamma0, in its order; of an array of tilts, arrays."""

    s: float
    c: float
    a1: float
    a2: float
    S1: float
    S2: float
    b: float
    db: float
    h_c: float
    z_c: float
    dh_c: float
    dz_c: float
    ddh_c: float
    ddz_c: float


def contact_geometry(scene: Scene, gamma: float | np.ndarray) -> ContactGeometry:
    """
    Return the geometry of three-point contact at a tilt.

    Parameters
    ----------
    scene : Scene
    gamma : float or ndarray
        Angle between the axes [rad], gamma0 < gamma < pi/2 (complex values pass unchecked, for
        derivatives by a complex step).

    Returns
    -------
    ContactGeometry

    Raises
    ------
    PegOnHoleError
        Where a tilt has no three-point contact.

    Notes
    -----
    What a rounded gamma can still tell of gamma - gamma0
    limits the accuracy of a1 and b; give the difference itself to `contact_geometry_above` where
    it is known better.

    Source: docs/notation.md, G1 to G16; eq. (3) of the paper.

    """
    gamma0 = scene.gamma0
    if not np.iscomplexobj(gamma):
        _check_tilt(gamma, gamma0)
    d, D, H_c = scene.peg_diameter, scene.hole_diameter, scene.mass_center_height
    forms: Any = closed_forms(d, D, H_c, gamma0, gamma)
    return ContactGeometry(gamma0, *forms)


def contact_geometry_above(scene: Scene, excess: float | np.ndarray) -> ContactGeometry:
    """
    Return the geometry of three-point contact at gamma0 + excess, exact for the smallest excess.

    Parameters
    ----------
    scene : Scene
    excess : float or ndarray
        e = gamma - gamma0 [rad], 0 < e < pi/2 - gamma0 (complex values pass unchecked).

    Returns
    -------
    ContactGeometry
        Every entry within 4 units in the last place times its condition number.

    Raises
    ------
    PegOnHoleError
        Where the excess is not positive, not finite, or reaches a level peg.

    Source: docs/notation.md, G1 to G16; eqs. (3), (29).

    """
    gamma0 = scene.gamma0
    if not np.iscomplexobj(excess):
        excess = np.asarray(excess, float)[()]
        good = (excess > 0) & (excess < np.pi / 2 - gamma0)
        if not np.all(good):
            bad = np.asarray(excess)[~np.asarray(good)].flat[0]
            raise PegOnHoleError(
                f"gamma - gamma0 = {bad:g} rad has no three-point contact: it must lie within 0 "
                f"and {np.pi / 2 - gamma0:.9g} rad; below 0 the contact is two-point"
            )
    d, D, H_c = scene.peg_diameter, scene.hole_diameter, scene.mass_center_height
    forms: Any = closed_forms(d, D, H_c, gamma0, gamma0 + excess, excess)
    return ContactGeometry(gamma0, *forms)


def closed_forms(
    d: float, D: float, H_c: float, gamma0: float, gamma: Any, excess: Any = None
) -> ClosedForms:
    """
    Return the closed forms of the geometry; unchecked, and compiled by the kernel.

    `excess` is gamma - gamma0 where that is known better than by the difference.

    Notes
    -----
    d - D cos(gamma) vanishes at gamma0; written as a product of sines it keeps its digits there.
    D - d is exact in floating point where it is small (Sterbenz), and b = 2 sqrt(c a1 a2)/s has no
    difference. S1 is a sum of terms of one sign; where little is taken from D/2, that difference
    has fewer roundings (S2 alike). What is left are differences with a real zero.

    """
    above = gamma - gamma0 if excess is None else excess
    s, c = np.sin(gamma), np.cos(gamma)
    half = np.sin(gamma / 2) ** 2
    a1 = D * np.sin(gamma - above / 2) * np.sin(above / 2) / s
    a2 = ((D - d) + 2 * d * half) / (2 * s)
    taken = 2 * a1 / s
    near = 1.0 * (taken.real < D / 8)
    spread, tan2 = (D - d) * c / s**2, half / (1 - half)
    S1 = near * (D / 2 - c * taken) + (1 - near) * (spread + D / 2 * tan2)
    S2 = near * (d / 2 - taken) + (1 - near) * (spread - d / 2 * tan2)
    b = 2 * np.sqrt(c * a1 * a2) / s
    db = 2 * S1 * S2 / (s * b)
    h_c = ((D - d) + 2 * d * half) / 2 - H_c * s
    z_c = (H_c - a2) * c + a1
    dh_c = d / 2 * s - H_c * c
    dz_c = h_c + S1
    ddh_c = d / 2 * c + H_c * s
    ddz_c = dh_c - 2 * S2 / s
    return ClosedForms(s, c, a1, a2, S1, S2, b, db, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c)


def small_forms(d: float, D: float, H_c: float, gamma0: float, gamma: float) -> ClosedForms:
    """Return what `closed_forms` does, to leading order in a small tilt: sin = gamma, cos = 1."""
    a1 = D * (gamma - gamma0) * (gamma + gamma0) / (4 * gamma)
    a2 = ((D - d) + d / 2 * gamma * gamma) / (2 * gamma)
    shrunk = (gamma0 / gamma) ** 2
    S = D / 2 * shrunk
    b = D / 2 * np.sqrt(1 - shrunk * shrunk)
    db = D * D / 2 * shrunk * shrunk / (gamma * b)
    h_c, z_c = gamma * (a2 - H_c), a1 - a2 + H_c
    dh_c, dz_c = 2 * a1 - z_c, h_c + S
    ddh_c, ddz_c = 2 * a2 / gamma - dz_c, dh_c - 2 * S / gamma
    return ClosedForms(gamma, 1.0, a1, a2, S, S, b, db, h_c, z_c, dh_c, dz_c, ddh_c, ddz_c)


def _check_tilt(gamma, gamma0):
    gamma = np.asarray(gamma)
    # Written so that a NaN fails it.
    if np.all((gamma > gamma0) & (gamma < np.pi / 2)):
        return
    bad = gamma[~((gamma > gamma0) & (gamma < np.pi / 2))].flat[0]
    raise PegOnHoleError(
        f"gamma = {bad:g} rad has no three-point contact: it must lie within "
        f"{gamma0:.9g} rad (gamma0 = acos(d/D)) and 1.5708 rad (pi/2); below gamma0 the contact "
        "is two-point, and a tilt in degrees must be converted"
    )


def contact_points(g: ContactGeometry, hole_diameter: float) -> np.ndarray:
    """Return K, B1, B2 in (h, e, z) as rows, shape (3, 3, ...) [m]."""
    zero = 0 * g.s
    return np.array(
        [[zero - hole_diameter / 2, zero, zero], [g.S1, -g.b, zero], [g.S1, g.b, zero]]
    )


def normals(g: ContactGeometry) -> np.ndarray:
    """
    Return the unit normals on the peg at K, B1, B2 in (h, e, z) as rows, shape (3, 3, ...).

    At K along eta, square to the peg's side; at B1, B2 towards O, where the axes meet.

    Source: eqs. (8), (9).

    """
    to_O = np.array([[-g.S1, g.b, g.a1], [-g.S1, -g.b, g.a1]])
    n_B1, n_B2 = to_O / np.sqrt(g.S1**2 + g.b**2 + g.a1**2)
    return np.array([[g.c, 0 * g.c, g.s], n_B1, n_B2])


def velocity_jacobians(g: ContactGeometry, d: float, D: float) -> np.ndarray:
    """
    Return dv_i/d(gamma', psi', phi') of the peg's material points at K, B1, B2 in (h, e, z).

    Parameters
    ----------
    g : ContactGeometry
    d, D : float
        Peg and hole diameter [m].

    Returns
    -------
    ndarray, shape (3, 3, 3, ...)
        By contact, component (h, e, z), rate, as gamma [m/rad].

    Source: eqs. (10)-(21), corrected: symmetric at B1 and B2, gamma' = +dgamma/dt throughout.

    """
    zero = 0 * g.s
    v_K = [[2 * g.a1, zero, zero], [zero, zero - D / 2, zero - d / 2]]
    v_K.append([-2 * g.a1 * g.c / g.s, zero, zero])
    v_B = [
        [[2 * g.a1, b, b * g.c], [zero, g.S1, g.S2], [2 * g.S1, zero, b * g.s]]
        for b in (g.b, -g.b)
    ]
    return np.array([v_K, *v_B])
