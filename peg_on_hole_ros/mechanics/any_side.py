"""
The six equations solved for any choice of unknowns.

The six equations are linear in twelve quantities: three accelerations, three reactions, and six
components of the applied wrench. Any six of them may be asked for; not every six can be told.
"""

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.mechanics.checks import require_finite
from peg_on_hole_ros.mechanics.reference import precession_axes, six_equations, wrench_axes
from peg_on_hole_ros.mechanics.scene import Scene

ACCELERATIONS = ("ddgamma", "ddpsi", "ddphi")
REACTIONS = ("N_K", "N_B1", "N_B2")
# Components of the applied wrench in each frame.
AXES = {
    "hole": ("x", "y", "z"),
    "auxiliary": ("h", "e", "z"),
    "moving": ("eps", "eta", "zeta"),
    "peg": ("1", "2", "3"),
}
EQUATIONS = (
    "Lagrange's equation of gamma",
    "Lagrange's equation of psi",
    "Lagrange's equation of phi",
    "force balance along h",
    "force balance along e",
    "force balance along z",
)
# Singular values under this share of the largest count as zero: rounding leaves 1e-15, and a
# quantity that is told only with a ten-millionth of the usual effect is not told in practice.
RANK_TOLERANCE = 1e-8


class Solvability(Enum):
    """Whether the unknowns follow from the knowns; the values are advice."""

    UNIQUE = "the unknowns follow from the knowns"
    UNDETERMINED = "the equations do not distinguish these unknowns: give one of them"
    CONTRADICTORY = "no value of these unknowns fits the knowns: free one of the knowns"


class AnySide(NamedTuple):
    """
    Answer of `solve_any`.

    Attributes
    ----------
    values : dict of str to ndarray
        The unknowns: SI units; where they are not unique the smallest that fit best.
    solvability : Solvability
        The worst of all states given.
    reason : str
        In words, naming the quantities or equations; empty when unique.
    together : tuple of str
        Unknowns that the equations do not tell apart.
    residual : float
        Largest misfit of the equations over the size of their terms.
    pulling : tuple of str
        Reactions that came out negative: a contact cannot pull, so the motion is not three-point.

    """

    values: dict[str, np.ndarray]
    solvability: Solvability
    reason: str
    together: tuple[str, ...]
    residual: float
    pulling: tuple[str, ...]


def quantities(frame: str = "auxiliary") -> tuple[str, ...]:
    """
    Return the names of the twelve quantities, applied wrench in the given frame.

    Units: rad/s^2, N, N and N m.
    """
    if frame not in AXES:
        raise PegOnHoleError(f"frame = {frame!r} is none of {', '.join(AXES)}")
    wrench = tuple(f"{kind}_{axis}" for kind in "FM" for axis in AXES[frame])
    return ACCELERATIONS + REACTIONS + wrench


def frame_axes(frame: str, q: ArrayLike) -> np.ndarray:
    """
    Return the matrix that takes components along h, e, z to those of a frame.

    Parameters
    ----------
    frame : {"hole", "auxiliary", "moving", "peg"}
        `moving` is (eps, eta, zeta).
    q : array_like, shape (3, ...)
        gamma, psi, phi [rad].

    Returns
    -------
    ndarray, shape (3, 3, ...)

    Raises
    ------
    PegOnHoleError
        Where the frame has no such name.

    """
    gamma, psi, phi = np.broadcast_arrays(*np.asarray(q))
    zero = 0 * gamma
    if frame == "hole":
        return precession_axes(psi + zero)
    if frame == "auxiliary":
        return precession_axes(zero)
    if frame == "moving":
        s, c = np.sin(gamma), np.cos(gamma)
        return np.array([[zero, zero - 1, zero], [c, zero, s], [-s, zero, c]])
    if frame == "peg":
        return np.swapaxes(wrench_axes(gamma, phi), 0, 1)
    raise PegOnHoleError(f"frame = {frame!r} is none of {', '.join(AXES)}")


def solve_any(
    scene: Scene,
    q: ArrayLike,
    rates: ArrayLike,
    unknown: Sequence[str],
    known: Mapping[str, ArrayLike] | None = None,
    frame: str = "auxiliary",
    slip_velocity_scale: float = 0.0,
) -> AnySide:
    """
    Solve the six equations for the quantities declared unknown.

    Parameters
    ----------
    scene : Scene
    q, rates : array_like, shape (3, ...)
        gamma, psi, phi [rad] and their rates [rad/s].
    unknown : sequence of str
        Names out of `quantities(frame)`. Motion from forces: accelerations and reactions; forces
        from motion: the wrench; any mix. Fewer than six are allowed where the knowns agree.
    known : mapping of str to float or ndarray, optional
        Values of the others; what is not named is zero.
    frame : {"hole", "auxiliary", "moving", "peg"}
        Of the applied wrench's components, about the mass centre.
    slip_velocity_scale : float
        [m/s].

    Returns
    -------
    AnySide

    Raises
    ------
    PegOnHoleError
        Where a name is not known, is named twice, or more than six are unknown.

    Source: L1, L2; the paper's "from the law of change of one set the other two".

    """
    names = quantities(frame)
    known = dict(known or {})
    unknown = tuple(unknown)
    _check_names(names, unknown, known)
    q = require_finite("state", "rad", q, 3)
    rates = require_finite("rates", "rad/s", rates, 3)
    columns, right = _twelve_columns(scene, q, rates, frame, slip_velocity_scale)
    for name, value in known.items():
        if not np.all(np.isfinite(value)):
            raise PegOnHoleError(f"{name} = {value} is not finite: give a number")
        right = right - columns[:, names.index(name)] * np.asarray(value, float)
    chosen = np.stack([columns[:, names.index(name)] for name in unknown], axis=1)

    A, r = np.moveaxis(chosen, (0, 1), (-2, -1)), np.moveaxis(right, 0, -1)
    row = 1 / np.max(np.abs(np.moveaxis(columns, (0, 1), (-2, -1))), axis=-1)
    A, r = A * row[..., None], r * row
    size = np.linalg.norm(A, axis=-2)
    size = np.where(size == 0, 1, size)
    U, sigma, Vt = np.linalg.svd(A / size[..., None, :], full_matrices=False)
    kept = sigma > RANK_TOLERANCE * sigma[..., :1]
    inverse = np.where(kept, 1 / np.where(kept, sigma, 1), 0)
    parts = np.einsum("...ij,...i->...j", U, r) * inverse
    y = np.einsum("...ij,...i->...j", Vt, parts) / size
    misfit = r - np.einsum("...ij,...j->...i", A, y)
    terms = np.abs(r).max(axis=-1) + np.abs(A * y[..., None, :]).max(axis=(-2, -1))
    residual = np.max(np.abs(misfit).max(axis=-1) / np.where(terms == 0, 1, terms))

    together = _together(unknown, kept, Vt)
    values = {name: y[..., k][()] for k, name in enumerate(unknown)}
    pulling = tuple(n for n in REACTIONS if n in values and np.any(values[n] < 0))
    solvability, reason = _verdict(together, misfit, terms, residual)
    return AnySide(values, solvability, reason, together, float(residual), pulling)


def _check_names(names, unknown, known):
    for name in (*unknown, *known):
        if name not in names:
            raise PegOnHoleError(f"{name!r} is none of the quantities {', '.join(names)}")
    twice = [name for name in names if unknown.count(name) + (name in known) > 1]
    if twice:
        raise PegOnHoleError(f"{', '.join(twice)} named twice: a quantity is known or unknown")
    if not 1 <= len(unknown) <= 6:
        raise PegOnHoleError(
            f"{len(unknown)} unknowns: six equations determine one to six; declare others known"
        )


def _twelve_columns(scene, q, rates, frame, slip_velocity_scale):
    """Return columns (6, 12, ...) and right side with columns @ quantities = right."""
    A, r = six_equations(scene, q, rates, np.zeros(6), slip_velocity_scale)
    q = np.asarray(q, float)
    to_peg = frame_axes("peg", q)
    # Components in the frame to peg axes: peg <- (h, e, z) <- frame.
    turn = np.einsum("ij...,kj...->ik...", to_peg, frame_axes(frame, q))
    columns = []
    for part in range(2):
        for axis in range(3):
            wrench = np.zeros((6, *turn.shape[2:]))
            wrench[3 * part : 3 * part + 3] = turn[:, axis]
            _, pushed = six_equations(scene, q, rates, wrench, slip_velocity_scale)
            columns.append(r - pushed)
    wrench_columns = np.stack(columns, axis=1)
    A = np.broadcast_to(A, (6, 6, *wrench_columns.shape[2:]))
    return np.concatenate([A, wrench_columns], axis=1), r


def _together(unknown, kept, Vt):
    """Return the unknowns with a part in any null direction of any state."""
    rank_lost = ~kept[..., :, None] & (np.abs(Vt) > 1e-6)
    mask = np.any(rank_lost.reshape(-1, len(unknown)), axis=0)
    return tuple(name for name, used in zip(unknown, mask, strict=True) if used)


def _verdict(together, misfit, terms, residual):
    if residual > 1e-8:
        share = np.abs(misfit) / np.where(terms == 0, 1, terms)[..., None]
        worst = np.max(share.reshape(-1, 6), axis=0)
        failed = [EQUATIONS[k] for k in range(6) if worst[k] > 1e-8]
        reason = f"no choice of the unknowns satisfies {', '.join(failed)}"
        if together:
            reason += f"; {', '.join(together)} act there alike, or not at all"
        return Solvability.CONTRADICTORY, reason
    if together:
        if len(together) == 1:
            return Solvability.UNDETERMINED, f"{together[0]} enters none of the equations"
        return (
            Solvability.UNDETERMINED,
            f"only one combination of {', '.join(together)} enters the equations",
        )
    return Solvability.UNIQUE, ""
