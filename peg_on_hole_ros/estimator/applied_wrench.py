"""The applied wrench about the mass centre in (h, e, z), its Jacobian, and its noise."""

from math import cos, sin

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.scene_at_mean import tilted_gravity
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.state import StatePlaces
from peg_on_hole_ros.mechanics.kernel import SceneScalars, Wrench, compiled
from peg_on_hole_ros.mechanics.linear_algebra import TORQUE, hez_rotation
from peg_on_hole_ros.typed_record import Floats

# Force and moment about the mass centre in (h, e, z): F_h, F_e, F_z, M_h, M_e, M_z [N], [N m].
Column = tuple[float, float, float, float, float, float]


@compiled
def applied_wrench(
    kalman: FilterRecord, scene: SceneScalars, x: Floats, s: float, c: float
) -> Wrench:
    """
    Return the applied wrench, weight included and bias taken off.

    Parameters
    ----------
    kalman : FilterRecord
        `scratch.applied_jacobian` (6, 11) is filled with the derivatives of that wrench by gamma,
        psi, phi, by the wrench in peg axes (6), and by a tilt of the hole (2).
    scene : SceneScalars
    x : ndarray
        Mean of the component.
    s, c : float
        Sine and cosine of the tilt at which the contacts are taken.

    """
    u, places, columns = kalman.wrench, kalman.places, kalman.scratch.applied_jacobian
    u0, u1, u2, u3, u4, u5 = six_of(u)
    if places.bias >= 0:
        b = x[places.bias : places.bias + 6]
        u0 -= _row(kalman.bias_map, 0, b)
        u1 -= _row(kalman.bias_map, 1, b)
        u2 -= _row(kalman.bias_map, 2, b)
        u3 -= _row(kalman.bias_map, 3, b)
        u4 -= _row(kalman.bias_map, 4, b)
        u5 -= _row(kalman.bias_map, 5, b)
    g_x, g_y, g_z = tilted_gravity(scene, x, places)
    sp, cp, sps, cps = sin(x[2]), cos(x[2]), sin(x[1]), cos(x[1])
    r00, r01, r02, r10, r11, r20, r21, r22 = hez_rotation(s, c, sp, cp)
    F_h, F_e, F_z = r00 * u0 + r01 * u1 + r02 * u2, r10 * u0 + r11 * u1, r20 * u0 + r21 * u1
    F_z += r22 * u2
    M_h, M_e, M_z = r00 * u3 + r01 * u4 + r02 * u5, r10 * u3 + r11 * u4, r20 * u3 + r21 * u4
    M_z += r22 * u5
    g_h, g_e = scene.m * (cps * g_x + sps * g_y), scene.m * (cps * g_y - sps * g_x)
    for i in range(6):
        columns[i, 0] = columns[i, 2] = 0.0
    put_column(columns, 1, (g_e, -g_h, 0.0, 0.0, 0.0, 0.0))
    add_turn(columns, s, c, Wrench(F_h, F_e, F_z, M_h, M_e, M_z))
    for j in range(2):
        put_column(columns, 3 + 3 * j, (r00, r10, r20, r00, r10, r20))
        put_column(columns, 4 + 3 * j, (r01, r11, r21, r01, r11, r21))
        put_column(columns, 5 + 3 * j, (r02, 0.0, r22, r02, 0.0, r22))
        for i in range(3):
            for k in range(3 + 3 * j, 6 + 3 * j):
                columns[3 * (1 - j) + i, k] = 0.0
    # Gravity tilts by -g_z t_y, g_z t_x in the hole's axes.
    l_y, l_x = scene.m * scene.g_z, -scene.m * scene.g_z
    put_column(columns, 9, (sps * l_y, cps * l_y, -scene.m * scene.g_y, 0.0, 0.0, 0.0))
    put_column(columns, 10, (cps * l_x, -sps * l_x, scene.m * scene.g_x, 0.0, 0.0, 0.0))
    return Wrench(F_h + g_h, F_e + g_e, F_z + scene.m * g_z, M_h, M_e, M_z)


@compiled
def six_of(values: Floats) -> Column:
    """Return six values as a tuple."""
    return values[0], values[1], values[2], values[TORQUE], values[TORQUE + 1], values[TORQUE + 2]


@compiled
def add_turn(columns: Floats, s: float, c: float, wrench: Wrench) -> None:
    """Add how a wrench turns with its peg: with gamma about -e, with phi about the peg's axis."""
    F_h, F_e, F_z, M_h, M_e, M_z = wrench
    for i, h, e, z in ((0, F_h, F_e, F_z), (3, M_h, M_e, M_z)):
        columns[i, 0] -= z
        columns[i + 2, 0] += h
        columns[i, 2] -= c * e
        columns[i + 1, 2] += c * h + s * z
        columns[i + 2, 2] -= s * e


@compiled
def put_column(columns: Floats, j: int, column: Column) -> None:
    """Fill in a column."""
    (
        columns[0, j], columns[1, j], columns[2, j], columns[3, j], columns[4, j], columns[5, j],
    ) = column  # fmt: skip


@compiled
def subtract_applied_jacobian(scratch: Scratch, places: StatePlaces, bias_map: Floats) -> None:
    """Subtract the Jacobian of an applied wrench, on the right side, from the residual's."""
    columns, E = scratch.applied_jacobian, scratch.jacobian
    for i in range(6):
        for j in range(3):
            E[i, j] -= columns[i, j]
        if places.bias >= 0:
            for j in range(6):
                t = 0.0
                for k in range(6):
                    t += columns[i, 3 + k] * bias_map[k, j]
                E[i, places.bias + j] = t
        if places.tilt >= 0:
            E[i, places.tilt], E[i, places.tilt + 1] = -columns[i, 9], -columns[i, 10]


@compiled
def _row(matrix: Floats, i: int, b: Floats) -> float:
    t = 0.0
    for j in range(6):
        t += matrix[i, j] * b[j]
    return t


@compiled
def fill_wrench_noise(scratch: Scratch, noise: Floats) -> None:
    """Fill in the residual's covariance by that of the wrench, shape (6, 6)."""
    columns, product, R = scratch.applied_jacobian, scratch.product, scratch.noise
    for i in range(6):
        for j in range(6):
            t = 0.0
            for k in range(6):
                t += columns[i, 3 + k] * noise[k, j]
            product[i, j] = t
    for i in range(6):
        for j in range(i + 1):
            t = 0.0
            for k in range(6):
                t += product[i, k] * columns[j, 3 + k]
            R[i, j] = t
            R[j, i] = t
