"""The wrench of a peg that hangs free as a measurement of the sensor's bias."""

from math import isfinite

from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.estimator.contact_sets.free import FILLED, SETTLED, WAITS
from peg_on_hole_ros.estimator.contact_sets.registry import linearise
from peg_on_hole_ros.estimator.filter_record import FilterRecord
from peg_on_hole_ros.estimator.scene_at_mean import tilted_gravity
from peg_on_hole_ros.estimator.start import forget_batch
from peg_on_hole_ros.estimator.state import AirBatch
from peg_on_hole_ros.estimator.update import update
from peg_on_hole_ros.mechanics.kernel import compiled, scene_of
from peg_on_hole_ros.mechanics.linear_algebra import in_peg_axes, peg_turns
from peg_on_hole_ros.typed_record import Floats


@compiled
def corrects_bias(kalman: FilterRecord, contact_set: int) -> bool:
    """Return whether the wrench corrects the bias; where it drives the motion, it cannot."""
    smooth = isfinite(kalman.settings.mode_time[0])
    return contact_set == ContactSet.NONE and kalman.places.bias >= 0 and smooth


@compiled
def update_bias_in_air(kalman: FilterRecord) -> None:
    """
    Use the wrench of a peg that hangs free; correct the bias by a batch that has settled.

    A touch is detected late, and what it carries until then is no bias. So a batch of wrenches
    waits until the peg has hung free for another `touch_time`.
    """
    state, settings, scratch = kalman.state, kalman.settings, kalman.scratch
    scene, n, first = scene_of(kalman.scene), kalman.places.reactions, kalman.places.bias
    air, x = state.air, state.mixture_mean
    gravity = tilted_gravity(scene, x, kalman.places)
    _gather(air[FILLED], x, scene.m, gravity, kalman.wrench, state.time_since_wrench)
    if air[FILLED].time < settings.touch_time:
        return
    air[SETTLED] = air[WAITS]
    air[WAITS] = air[FILLED]
    forget_batch(air[FILLED])
    if air[SETTLED].wrenches == 0:
        return
    # How far the bias has walked from its mean over the batch.
    since = air[WAITS].time + air[SETTLED].time / 3.0
    mode_stddev = settings.mode_stddev[settings.modes // 2]
    for j in range(state.components):
        if state.alive[j // settings.modes] == 0.0:
            continue
        x, P = state.x[j], state.P[j]
        linearise(ContactSet.NONE.value, kalman, scene, x, P, mode_stddev)
        for i in range(6):
            scratch.residual[i] = -scratch.residual[i]
            P[first + i, first + i] -= since * _walk(kalman, i)
        update(kalman, kalman.estimated, P, n, 6, 0.0)
        for i in range(6):
            P[first + i, first + i] += since * _walk(kalman, i)
        for i in range(n):
            x[i] += scratch.step[i]


@compiled
def _walk(kalman: FilterRecord, i: int) -> float:
    """Return the variance that a component of the bias gains in a second in the air."""
    variance: float = kalman.walk[kalman.places.bias + i] + kalman.bias_walk_in_air[i]
    return variance


@compiled
def add_bias_process_noise(kalman: FilterRecord) -> None:
    """Add what the bias may have walked in the air since the last wrench."""
    state, first = kalman.state, kalman.places.bias
    for j in range(state.components):
        if state.alive[j // kalman.settings.modes] > 0.0:
            for i in range(6):
                walked = kalman.bias_walk_in_air[i] * state.time_since_wrench
                state.P[j, first + i, first + i] += walked


@compiled
def _gather(
    batch: AirBatch,
    x: Floats,
    mass: float,
    gravity: tuple[float, float, float],
    u: Floats,
    dt: float,
) -> None:
    """
    Add a wrench, less the weight, to a batch.

    A tilt of the hole turns the peg and gravity alike: in peg axes the weight contains nothing of
    it.
    """
    weight = in_peg_axes(peg_turns(x[0], x[1], x[2]), gravity)
    batch.time += dt
    batch.wrenches += 1
    for i in range(6):
        batch.load[i] += u[i]
    for i in range(3):
        batch.load[i] += mass * weight[i]
