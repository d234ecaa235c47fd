"""The direction of friction where the slip is known only so well: its mean, and what is left."""

from math import sqrt

from peg_on_hole_ros.estimator.rim_geometry import Rows, rim_normal, rim_slip
from peg_on_hole_ros.estimator.scratch import Scratch
from peg_on_hole_ros.estimator.state import FRICTION, RATE, StatePlaces
from peg_on_hole_ros.estimator.tuned import SLIP_FLOOR
from peg_on_hole_ros.mechanics.geometry import ClosedForms
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def friction_direction_statistics(
    scene: SceneScalars,
    geo: ClosedForms,
    x: Floats,
    P: Floats,
    share: float,
    scales: Floats,
    left: Floats,
) -> float:
    """
    Fill in how well the direction of friction is known at each contact.

    For a slip v that is normal with variances along and across it, v / sqrt(v^2 + s^2) is the
    mean direction where s is the scale that is filled in; its derivative is that of the mean
    (Stein's lemma).

    Parameters
    ----------
    scene : SceneScalars
    geo : ClosedForms
    x : ndarray
        Mean of the component.
    P : ndarray
        Its covariance.
    share : float
        Of the rates' variance.
    scales : ndarray, shape (3,)
        Filled with the scales of K, B1, B2 [m/s].
    left : ndarray, shape (3,)
        Filled with the share of the friction that no Jacobian explains, 0 to 1.

    Returns
    -------
    turned : float
        How far the slip may point elsewhere: the square of its sine, a mean over the contacts.

    """
    turned = 0.0
    for i in range(3):
        other, left[i], s2 = slip_statistics(rim_slip(scene, geo, i), x, P, share)
        scales[i] = sqrt(s2 + SLIP_FLOOR.least_scale_square)
        turned += other / 3.0
    return turned


@compiled
def slip_statistics(rows: Rows, x: Floats, P: Floats, share: float) -> tuple[float, float, float]:
    """
    Return the moments of the direction of one slip, see `friction_direction_statistics`.

    Parameters
    ----------
    rows : tuple of 3 tuples of 3 float
        Its components by the rates [m/rad].
    x, P, share
        As for `friction_direction_statistics`.

    Returns
    -------
    turned, left, scale2 : float
        Square of the sine by which it may point elsewhere; share of friction that no
        Jacobian explains; square of the scale [m^2/s^2].

    """
    w0, w1, w2 = x[RATE], x[RATE + 1], x[RATE + 2]
    q00, q01, q02 = P[RATE, RATE], P[RATE, RATE + 1], P[RATE, RATE + 2]
    q11, q12, q22 = P[RATE + 1, RATE + 1], P[RATE + 1, RATE + 2], P[RATE + 2, RATE + 2]
    speed2, total, d0, d1, d2 = 0.0, 0.0, 0.0, 0.0, 0.0
    for a, b, c in rows:
        v = a * w0 + b * w1 + c * w2
        speed2 += v * v
        d0 += v * a
        d1 += v * b
        d2 += v * c
        total += a * a * q00 + b * b * q11 + c * c * q22
        total += 2.0 * (a * b * q01 + a * c * q02 + b * c * q12)
    along = d0 * d0 * q00 + d1 * d1 * q11 + d2 * d2 * q22
    along += 2.0 * (d0 * d1 * q01 + d0 * d2 * q02 + d1 * d2 * q12)
    total = max(total, SLIP_FLOOR.least_variance)
    along = min(max(along / max(speed2, 1e-30), 0.0), total)
    across = total - along
    mean = 0.5 * total
    ratio = speed2 / mean
    blend = (across * ratio + 2.0 * mean) / (ratio + 2.0)
    # Of a spread that is even the mean direction (a quotient of Bessel functions) within 1.3 %.
    s2 = share * (1.0 + 1.55 / (1.0 + 0.27 * ratio)) * blend
    w = 1.0 / (speed2 + s2)
    left = max(1.0 - speed2 * w - w * across - s2 * s2 * w * w * w * along, 0.0)
    return across / (speed2 + across), left, s2


@compiled
def fill_direction_noise(
    scene: SceneScalars,
    geo: ClosedForms,
    x: Floats,
    friction_force2: Floats,
    scratch: Scratch,
) -> None:
    """
    Fill in the six equations' covariance by friction whose direction no Jacobian explains.

    Parameters
    ----------
    scene : SceneScalars
    geo : ClosedForms
    x : ndarray
        Mean of the component.
    friction_force2 : ndarray, shape (3,)
        Mean square of the friction at each contact [N^2].
    scratch : Scratch
        With what `friction_direction_statistics` fills in: `velocity_scale` and `unexplained`;
        `direction_noise` and `by_friction` are filled.

    """
    noise, by_friction = scratch.direction_noise, scratch.by_friction
    for j in range(6):
        for k in range(6):
            noise[j, k] = 0.0
    for i in range(3):
        J = rim_slip(scene, geo, i)
        n0, n1, n2 = rim_normal(geo, i)
        # A force does work along the slip, and stands in the balance of forces.
        rows = (
            (J[0][0], J[1][0], J[2][0]),
            (J[0][1], J[1][1], J[2][1]),
            (J[0][2], J[1][2], J[2][2]),
            (1.0, 0.0, 0.0),
            (0.0, 1.0, 0.0),
            (0.0, 0.0, 1.0),
        )
        v0, v1, v2 = along_slip(J[0], x), along_slip(J[1], x), along_slip(J[2], x)
        scale = scratch.velocity_scale[i]
        unit = 1.0 / sqrt(v0 * v0 + v1 * v1 + v2 * v2 + scale * scale)
        amount = 0.5 * scratch.unexplained[i] * friction_force2[i]
        for j in range(6):
            r0, r1, r2 = rows[j]
            by_friction[j, i] = unit * (r0 * v0 + r1 * v1 + r2 * v2)
            along = r0 * n0 + r1 * n1 + r2 * n2
            for k in range(j + 1):
                t0, t1, t2 = rows[k]
                other = t0 * n0 + t1 * n1 + t2 * n2
                value = amount * (r0 * t0 + r1 * t1 + r2 * t2 - along * other)
                noise[j, k] += value
                if k != j:
                    noise[k, j] += value


@compiled
def along_slip(row: tuple[float, float, float], x: Floats) -> float:
    """Return one component of a slip by its row of the Jacobian [m/s]."""
    speed: float = row[0] * x[RATE] + row[1] * x[RATE + 1] + row[2] * x[RATE + 2]
    return speed


@compiled
def fill_product_covariance(P: Floats, places: StatePlaces, product: Floats) -> None:
    """
    Fill in the covariance of the products of the errors of friction and each reaction [N^2].

    They are normal, so it is that of Isserlis. No Jacobian explains these products: of a friction
    that is wide the equations are no plane, and one that is linearised anew with every wrench
    would distinguish friction from a bias by its own noise.

    Parameters
    ----------
    P : ndarray
        Covariance of a component after a wrench.
    places : StatePlaces
    product : ndarray, shape (3, 3)
        Filled.

    """
    n, place_K = places.reactions, places.friction_k
    for i in range(3):
        for j in range(3):
            own = P[FRICTION, FRICTION]
            i_j, j_i = P[FRICTION, n + j], P[FRICTION, n + i]
            if place_K >= 0:
                if i == 0:
                    own += P[FRICTION, place_K]
                    i_j += P[place_K, n + j]
                if j == 0:
                    own += P[FRICTION, place_K]
                    j_i += P[place_K, n + i]
                if i == 0 and j == 0:
                    own += P[place_K, place_K]
            product[i, j] = own * P[n + i, n + j] + i_j * j_i


@compiled
def add_product_noise(by_friction: Floats, product: Floats, noise: Floats) -> None:
    """Add what the products of the errors of friction and reactions are in the equations."""
    for i in range(3):
        for j in range(3):
            if product[i, j] != 0.0:
                for a in range(6):
                    t = product[i, j] * by_friction[a, i]
                    for b in range(6):
                        noise[a, b] += t * by_friction[b, j]
