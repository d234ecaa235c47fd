"""An orientation as a measurement: its residual and Jacobian, in a hole that may be tilted."""

from math import atan2, cos, pi, sin, sqrt

import numpy as np

from peg_on_hole_ros.estimator.state import RATE, StatePlaces
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def fill_orientation_jacobian(x: Floats, places: StatePlaces, w: int, E: Floats) -> None:
    """
    Fill in the Jacobian of an orientation's residual (3, w), the derivatives by the values.

    A hole that is tilted by (t_x, t_y) is measured as a peg that is turned by them; one that is
    stamped too late by a delay is where the peg was.
    """
    for i in range(3):
        for j in range(w):
            E[i, j] = 0.0
        E[i, i] = 1.0
    if places.tilt >= 0:
        j = places.tilt
        s, c = sin(x[1]), cos(x[1])
        over = 1.0 / max(sin(x[0]), 1e-6)
        E[0, j], E[0, j + 1] = s, -c
        E[2, j], E[2, j + 1] = -c * over, -s * over
        E[1, j], E[1, j + 1] = cos(x[0]) * c * over, cos(x[0]) * s * over
    if places.delay >= 0:
        for i in range(3):
            E[i, places.delay] = -x[RATE + i]


@compiled
def fill_orientation_residual(
    x: Floats, places: StatePlaces, q: Floats, E: Floats, residual: Floats
) -> None:
    """Fill in an orientation less what is expected of it; psi and phi may be off by turns."""
    seen = (q[0], q[1], q[2])
    if places.tilt >= 0:
        seen = _turned_back(seen, x[places.tilt], x[places.tilt + 1])
    for i in range(3):
        t = seen[i] - x[i]
        if places.delay >= 0:
            t -= E[i, places.delay] * x[places.delay]
        if i > 0:
            t -= 2.0 * pi * np.round(t / (2.0 * pi))
        residual[i] = t


@compiled
def _turned_back(
    q: tuple[float, float, float], t_x: float, t_y: float
) -> tuple[float, float, float]:
    """Return gamma, psi, phi in the axes of a hole that is turned by (t_x, t_y, 0) [rad]."""
    s, c, sps, cps, sp, cp = sin(q[0]), cos(q[0]), sin(q[1]), cos(q[1]), sin(q[2]), cos(q[2])
    turn2 = t_x * t_x + t_y * t_y
    turn = sqrt(turn2)
    a = sin(turn) / turn if turn > 0.0 else 1.0
    b = 2.0 * (sin(0.5 * turn) / turn) ** 2 if turn > 0.0 else 0.5
    # The peg's axis in the hole's axes, then the hole's in the peg's.
    x, y, z = -cps * s, -sps * s, c
    axis_x = x - a * t_y * z - b * t_y * (t_y * x - t_x * y)
    axis_y = y + a * t_x * z + b * t_x * (t_y * x - t_x * y)
    axis_z = z + a * (t_y * x - t_x * y) - b * turn2 * z
    up_x = s * cp * (1.0 - b * turn2) + a * (
        t_y * (cps * c * cp - sps * sp) - t_x * (sps * c * cp + cps * sp)
    )
    up_y = -s * sp * (1.0 - b * turn2) - a * (
        t_y * (cps * c * sp + sps * cp) - t_x * (sps * c * sp - cps * cp)
    )
    return (
        atan2(sqrt(up_x * up_x + up_y * up_y), axis_z),
        atan2(-axis_y, -axis_x),
        atan2(-up_y, up_x),
    )
