"""No contact: the peg hangs free, and a batch of wrenches measures its weight and the bias."""

from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.tuned import WRENCH_STEP
from peg_on_hole_ros.estimator.update import reset_three
from peg_on_hole_ros.mechanics.kernel import SceneScalars, compiled
from peg_on_hole_ros.typed_record import Floats

SOLVED_REACTIONS = 0
WRENCH_MAY_DRIVE = False
IN_HOLE = False
# Which of the batches in the air is filled, waits until no touch follows it, corrects the bias.
FILLED, WAITS, SETTLED = range(3)


@compiled
def begin_reactions(x: Floats, P: Floats, first: int, variance: float) -> None:
    """Set the reactions to zero, and give each its prior variance [N^2]."""
    for i in range(first, first + 3):
        x[i] = 0.0
    reset_three(P, first, first + 3, variance)


@compiled
def linearise(
    kalman: FilterRecord, scene: SceneScalars, x: Floats, P: Floats, mode_stddev: float
) -> float:
    """
    Linearise the mean balance of the batch that corrects the bias.

    Parameters
    ----------
    kalman : FilterRecord
        With the batch; residual, jacobian and noise of `scratch` are filled.
    scene : SceneScalars
        The scene as stated.
    x, P : ndarray
        Mean and covariance of the component.
    mode_stddev : float
        Of accelerations [rad/s^2]: how the holder moves the peg is noise.

    Returns
    -------
    turned : float
        Zero: there is no slip.

    """
    settings, places, scratch = kalman.settings, kalman.places, kalman.scratch
    E, residual, R = scratch.jacobian, scratch.residual, scratch.noise
    batch, n = kalman.state.air[SETTLED], kalman.places.reactions
    dt = max(batch.time / batch.wrenches, WRENCH_STEP.least_time)
    moved = moved_force_variance(scene, settings.free_walk, dt) / batch.wrenches
    slow = max(settings.mode_time[settings.modes - 1] / dt, 1.0)
    turned = slow * (scene.Ie * mode_stddev) ** 2 / batch.wrenches
    for i in range(6):
        for k in range(n + 3):
            E[i, k] = 0.0
        for k in range(6):
            R[i, k] = kalman.noise[i, k] / batch.wrenches
            E[i, places.bias + k] = -kalman.bias_map[i, k]
        R[i, i] += moved if i < 3 else turned
        residual[i] = batch.load[i] / batch.wrenches
        for k in range(n):
            residual[i] += E[i, k] * x[k]
    return 0.0


@compiled
def moved_force_variance(scene: SceneScalars, free_walk: float, dt: float) -> float:
    """Return the variance of the force of a holder that moves the peg, over a sample [N^2]."""
    return (scene.m * free_walk) ** 2 / max(dt, WRENCH_STEP.least_time)
