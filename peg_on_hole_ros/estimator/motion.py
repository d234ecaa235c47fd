"""How a held peg moves on: its accelerations fade, and white noise of a process-noise mode."""

from math import cos, exp, sin

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.friction_walk import add_friction_noise
from peg_on_hole_ros.estimator.settings import Settings
from peg_on_hole_ros.estimator.state import ACCELERATION, ANGLE, FRICTION, RATE
from peg_on_hole_ros.estimator.tuned import PROCESS_NOISE_FLOOR
from peg_on_hole_ros.mechanics.kernel import compiled
from peg_on_hole_ros.typed_record import Floats


@compiled
def move_on(kalman: FilterRecord, component: int, dt: float) -> None:
    """
    Predict one component over a time.

    Parameters
    ----------
    kalman : FilterRecord
        Of the component, the rows of the reactions in its covariance stay.
    component : int
        Number of the component.
    dt : float
        [s].

    """
    settings, x, P = kalman.settings, kalman.state.x[component], kalman.state.P[component]
    n, mode = kalman.places.reactions, component % settings.modes
    k = exp(-dt / settings.mode_time[mode])
    half = 0.5 * dt
    for i in range(3):
        x[i] += dt * (x[RATE + i] + half * x[ACCELERATION + i])
        x[RATE + i] += dt * x[ACCELERATION + i]
        x[ACCELERATION + i] *= k
    for i in range(3):
        for j in range(n):
            P[i, j] += dt * (P[RATE + i, j] + half * P[ACCELERATION + i, j])
            P[RATE + i, j] += dt * P[ACCELERATION + i, j]
            P[ACCELERATION + i, j] *= k
    for j in range(n):
        for i in range(3):
            P[j, i] += dt * (P[j, RATE + i] + half * P[j, ACCELERATION + i])
            P[j, RATE + i] += dt * P[j, ACCELERATION + i]
            P[j, ACCELERATION + i] *= k
    add_process_noise(x, P, settings, mode, dt)
    for j in range(FRICTION, n):
        P[j, j] += kalman.walk[j] * dt
    add_friction_noise(kalman, component, dt)
    for i, moves in ((1, settings.psi_moves), (2, settings.phi_moves)):
        if moves == 0.0:
            forget_value(x, P, RATE + i, n + 3)
            forget_value(x, P, ACCELERATION + i, n + 3)


@compiled
def forget_value(x: Floats, P: Floats, place: int, w: int) -> None:
    """Make a value zero, and exactly known, among w."""
    x[place] = 0.0
    for j in range(w):
        P[place, j] = 0.0
        P[j, place] = 0.0


@compiled
def add_process_noise(x: Floats, P: Floats, settings: Settings, mode: int, dt: float) -> None:
    """Add what a mode's white noise, in each angle and about any axis, makes of the motion."""
    stddev, time = settings.mode_stddev[mode], settings.mode_time[mode]
    s, c = sin(x[ANGLE]), cos(x[ANGLE])
    density = 2.0 / time * stddev * stddev
    sine_square = max(s * s, PROCESS_NOISE_FLOOR.least_sine_square)
    turning = settings.around_axes * settings.around_axes * density / sine_square
    d2, d3 = dt * dt / 2.0, dt * dt * dt / 3.0
    d4, d5, d6 = dt**4 / 8.0, dt**5 / 20.0, dt**3 / 6.0
    for i in range(3):
        for j in range(3):
            q = density if i == j else 0.0
            if i > 0 and j > 0:
                q += turning if i == j else -c * turning
            if q == 0.0:
                continue
            P[ACCELERATION + i, ACCELERATION + j] += q * dt
            P[RATE + i, ACCELERATION + j] += q * d2
            P[ACCELERATION + i, RATE + j] += q * d2
            P[RATE + i, RATE + j] += q * d3
            P[i, RATE + j] += q * d4
            P[RATE + i, j] += q * d4
            P[i, ACCELERATION + j] += q * d6
            P[ACCELERATION + i, j] += q * d6
            P[i, j] += q * d5
