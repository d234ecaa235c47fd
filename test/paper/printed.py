"""
The paper's equations as they are printed, kept to be compared with the true ones.

The package uses none of them. `docs/errata.md` says where they differ; scalars only.
`gamma'` is taken literally as the rate that is passed.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.mechanics.geometry import contact_geometry, normals
from peg_on_hole_ros.mechanics.scene import Scene


def planar_velocities(scene: Scene, gamma: float, psi: float, dgamma: float) -> np.ndarray:
    """Return V^gamma at K, B1, B2 along x, y, z [m/s]. Eq. (12)."""
    g = contact_geometry(scene, gamma)
    KL = 2 * g.a1 / g.s
    c, s = np.cos(psi), np.sin(psi)
    K = [-KL * g.s * c, -KL * g.s * s, KL * g.c]
    B = [-2 * g.a1 * c, -2 * g.a1 * s, -2 * g.S1]
    return np.array([K, B, B]) * dgamma


def slide_velocities(scene: Scene, gamma: float, psi: float, dpsi: float) -> np.ndarray:
    """Return V^psi at K, B1, B2 along x, y, z [m/s]. Eq. (13), which is right."""
    g, D = contact_geometry(scene, gamma), scene.hole_diameter
    c, s = np.cos(psi), np.sin(psi)
    K = [D / 2 * s, -D / 2 * c, 0]
    B1 = [-(g.S1 * s - g.b * c), g.S1 * c + g.b * s, 0]
    B2 = [-(g.S1 * s + g.b * c), g.S1 * c - g.b * s, 0]
    return np.array([K, B1, B2]) * dpsi


def slide_velocities_auxiliary(scene: Scene, gamma: float, dpsi: float) -> np.ndarray:
    """Return V^psi at B1, B2 along h, e [m/s]. Eq. (14)."""
    g = contact_geometry(scene, gamma)
    return np.array([[g.b, -g.S1], [-g.b, -g.S1]]) * dpsi


def slide_velocity_B2_zeta(scene: Scene, gamma: float, dpsi: float) -> float:
    """Return V^psi_B2 along zeta by the middle expression of eq. (15), V_B2h sin(gamma) [m/s]."""
    g = contact_geometry(scene, gamma)
    return float(slide_velocities_auxiliary(scene, gamma, dpsi)[1, 0] * g.s)


def slip_velocities(scene: Scene, gamma: float, psi: float, dphi: float) -> np.ndarray:
    """
    Return V^phi at B1, B2 along x, y, z by the middle expressions of eqs. (18.1), (18.2) [m/s].

    With V_h of (17) and V_e of (16) along e; the last expressions of (18) are right.
    """
    g = contact_geometry(scene, gamma)
    c, s = np.cos(psi), np.sin(psi)
    h1, h2, e = g.b * g.c, -g.b * g.c, g.S2
    B1 = [h1 * c - e * s, h1 * s + e * c, h1 * s]
    B2 = [-h2 * c - e * s, -h2 * s + e * c, -g.b * g.s]
    return np.array([B1, B2]) * dphi


def slip_velocities_moving(scene: Scene, gamma: float, dphi: float) -> np.ndarray:
    """
    Return V^phi at B1, B2 along eps, eta by the first expressions of eq. (16) [m/s].

    cos(beta) = S2/(d/2), sin(beta) = b/(d/2); what follows after the second sign of equality is
    right, and has other signs at V_B1eps and V_B2eta.
    """
    g, half = contact_geometry(scene, gamma), scene.peg_diameter / 2
    cosine, sine = g.S2 / half, g.b / half
    return half * dphi * np.array([[cosine, sine], [-cosine, sine]])


def absolute_velocities(
    scene: Scene, gamma: float, psi: float, rates: Sequence[float] | np.ndarray
) -> np.ndarray:
    """
    Return V at B1, B2 along x, y as far as eq. (19) is legible in the scan [m/s].

    Its last expressions; z, and K, are lost or garbled.
    """
    g, (dgamma, dpsi, dphi) = contact_geometry(scene, gamma), rates
    c, s = np.cos(psi), np.sin(psi)
    rows = []
    for b in (g.b, -g.b):
        rows.append(
            [
                -2 * g.a1 * c * dgamma
                - (g.S1 * s - b * c) * dpsi
                - (g.S2 * s - b * g.c * c) * dphi,
                -2 * g.a1 * s * dgamma
                + (g.S1 * c + b * s) * dpsi
                + (g.S2 * c + b * g.c * s) * dphi,
            ]
        )
    return np.array(rows)


def moving_velocities(
    scene: Scene, gamma: float, rates: Sequence[float] | np.ndarray
) -> np.ndarray:
    """Return V at K, B1, B2 along eps, eta [m/s]. Eqs. (20.1)-(20.3)."""
    g, (dgamma, dpsi, dphi) = contact_geometry(scene, gamma), rates
    D, d = scene.hole_diameter, scene.peg_diameter
    turn = g.b * g.c * dpsi + g.b * dphi
    K = [D / 2 * dpsi + d / 2 * dphi, 0]
    B1 = [-g.S1 * dpsi - g.S2 * dphi, -2 * g.a2 * dgamma + turn]
    B2 = [g.S1 * dpsi - g.S2 * dphi, -2 * g.a2 * dgamma - turn]
    return np.array([K, B1, B2])


def left_sides(
    scene: Scene,
    gamma: float,
    rates: Sequence[float] | np.ndarray,
    accelerations: Sequence[float] | np.ndarray,
) -> np.ndarray:
    """Return the left sides of Lagrange's equations [N m]. Eqs. (7.1)-(7.3), (28.1)-(28.3)."""
    g, (dgamma, dpsi, _) = contact_geometry(scene, gamma), rates
    m, Ie, Iz = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia
    ddgamma, ddpsi, ddphi = accelerations
    dI_z = 2 * (Ie - Iz) * g.s * g.c
    return np.array(
        [
            (m * (g.dh_c**2 + g.dz_c**2) + Ie) * ddgamma
            + m * (g.dh_c * g.ddh_c + g.dz_c * g.ddz_c) * dgamma**2
            - (m * g.dh_c * g.ddh_c + dI_z / 2) * dpsi**2,
            (m * g.h_c**2 + Ie * g.s**2 + Iz * g.c**2) * ddpsi + dI_z * dgamma * dpsi,
            Iz * ddphi,
        ]
    )


def kinetic_energy(scene: Scene, gamma: float, rates: Sequence[float] | np.ndarray) -> float:
    """Return T [J]. Eq. (6)."""
    g, (dgamma, dpsi, dphi) = contact_geometry(scene, gamma), rates
    m, Ie, Iz = scene.peg_mass, scene.transverse_inertia, scene.axial_inertia
    v2 = (g.dh_c**2 + g.dz_c**2) * dgamma**2 + g.h_c**2 * dpsi**2
    I_z = Ie * g.s**2 + Iz * g.c**2
    return float(m * v2 + Ie * dgamma**2 + I_z * dpsi**2 + Iz * dphi**2) / 2


def inertia_about_z(scene: Scene, gamma: float) -> float:
    """Return I_z, "moment of peg relative to hole axis", by the line below eq. (5) [kg m^2]."""
    g = contact_geometry(scene, gamma)
    return float(scene.transverse_inertia * g.s**2 + scene.axial_inertia * g.c**2)


def gravity_moment(scene: Scene, gamma: float) -> float:
    """Return the moment of the weight about Ll by the middle expression of eq. (24) [N m]."""
    g = contact_geometry(scene, gamma)
    return float(scene.peg_mass * scene.gravity[2] * (g.S1 - g.h_c))


class FrictionTerms(NamedTuple):
    """Friction's part of a right side over f N/V: rows gamma, psi, phi; columns K, B1, B2."""

    moments: np.ndarray
    generalized: np.ndarray
    equations: np.ndarray


def friction_terms(
    scene: Scene, gamma: float, rates: Sequence[float] | np.ndarray
) -> FrictionTerms:
    """
    Return friction's generalised forces over f N_i/V_i, in the three places they are printed.

    `moments`: m_Ll, m_z, m_zeta; `generalized`: (27.1)-(27.3); `equations`: (28.1)-(28.3) [m^2/s].
    """
    g, (p, y, w) = contact_geometry(scene, gamma), rates
    D, d = scene.hole_diameter, scene.peg_diameter
    KL2, BL2 = (2 * g.a1 / g.s) ** 2, 4 * (g.a1**2 + g.S1**2)
    mixed = g.S1 * g.S2 + g.b**2 * g.c
    one, two = 2 * g.a1 * g.b, 2 * g.a2 * g.b
    K = [KL2 * p, -(D**2 * y + d * D * w) / 4, -(d**2 * w + d * D * y) / 4]
    m_phi = one * p - d**2 * w / 4 - mixed * y
    moments = [
        [K[0], BL2 * p - one * y - two * w, BL2 * p + one * y + two * w],
        [K[1], one * p - mixed * w - D**2 * y / 4, -(one * p + mixed * w + D**2 * y / 4)],
        [K[2], m_phi, m_phi],
    ]
    first = [K[0], BL2 * p + one * y - two * w, BL2 * p + two * w + one * y]
    generalized = [first, moments[1], [K[2], m_phi, m_phi]]
    equations = [
        first,
        [K[1], one * p - mixed * w - D**2 * y / 4, -(one * p + mixed * w - D**2 * y / 4)],
        [
            K[2],
            two * p + d**2 * w / 4 - mixed * y,
            -(one * p - d**2 * w / 4 - mixed * y),
        ],
    ]
    return FrictionTerms(np.array(moments), np.array(generalized), np.array(equations))


def z_force(
    scene: Scene, gamma: float, normal: ArrayLike, friction_cosines: np.ndarray
) -> dict[str, float]:
    """
    Return the contacts' force along z as (23.3) and (28.6) print it [N].

    Parameters
    ----------
    scene : Scene
    gamma : float
        [rad], with psi = 0.
    normal : array_like, shape (3,)
        [N].
    friction_cosines : ndarray, shape (3, 3)
        [contact, x y z].

    """
    n, N = normals(contact_geometry(scene, gamma)), np.asarray(normal)
    return {
        "(23.3)": float(N @ (n[:, 1] + scene.friction * friction_cosines[:, 1])),
        "(28.6)": float(N @ (n[:, 2] + friction_cosines[:, 2])),
    }


def axis_offset(scene: Scene, excess: float) -> dict[str, float]:
    """Return a1 [m] at gamma0 + excess by eq. (29) and its stages (iii), (iv)."""
    D, d, gamma0 = scene.hole_diameter, scene.peg_diameter, scene.gamma0
    return {
        "(29)": D * gamma0 * excess / (2 * (gamma0 + excess)),
        "(iii)": D * gamma0 / 2,
        "(iv)": (d - D * np.cos(excess)) / (2 * np.sin(excess)),
    }


def small_tilt(scene: Scene) -> dict[str, float]:
    """Return ddh_c, ddz_c of eq. (30) [m] and gamma0 of 2.6.2 [rad]."""
    D = scene.hole_diameter
    gamma0 = (D - scene.peg_diameter) / D
    return {"ddh_c": -D / 2, "ddz_c": D / scene.gamma0, "gamma0": gamma0}


def small_tilt_velocities(
    scene: Scene, psi: float, dpsi: float, dphi: float
) -> dict[str, np.ndarray]:
    """Return V^psi of (33) and V^phi of (34) at K and B along x, y [m/s]."""
    half, c, s = scene.hole_diameter / 2, np.cos(psi), np.sin(psi)
    return {
        "(33)": half * dpsi * np.array([[s, c], [-s, -c]]),
        "(34)": half * dphi * np.array([[s, c], [-c, c]]),
    }


def small_tilt_speeds(scene: Scene, rates: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return V_K, V_B [m/s]. Eq. (36)."""
    dgamma, dpsi, dphi = rates
    half, turn = scene.hole_diameter / 2, dpsi + dphi
    return half * np.array([turn, np.sqrt((2 * dgamma) ** 2 + turn**2)])


def friction_at_K(psi: float) -> np.ndarray:
    """Return friction at K over f N_K along x, y, by (37.1), (37.2)."""
    return np.array([-np.sin(psi), np.cos(psi)])


def momentum_rates(scene: Scene, psi: float, rates: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return the right sides of (37.1), (37.2) and (38.1), (38.2) [N]."""
    dgamma, dpsi, _ = rates
    D, H, m = scene.hole_diameter, scene.peg_height, scene.peg_mass
    c, s = np.cos(psi), np.sin(psi)
    return m * np.array(
        [
            -D / 2 * c * dgamma**2 + H * s * dgamma * dpsi,
            -D / 2 * s * dgamma**2 + H * c * dgamma * dpsi,
            -D / 2 * dgamma**2,
            -H * dgamma * dpsi,
        ]
    )


def reaction(scene: Scene, closing_rates: Sequence[float] | np.ndarray) -> float:
    """
    Return N_K = N_B1 + N_B2 close to gamma0 [N]. Eq. (39); gamma' is the closing speed there.

    At rest the friction term is left out.
    """
    dgamma, dpsi, dphi = closing_rates
    root = np.sqrt((2 * dgamma) ** 2 + (dpsi + dphi) ** 2)
    share = 2 * dgamma / root if root else 0.0
    return -scene.peg_mass * scene.gravity[2] / (scene.gamma0 + scene.friction * share)
