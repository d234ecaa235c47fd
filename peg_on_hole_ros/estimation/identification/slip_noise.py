"""Whether the motion of a recording is faster than what noise of one wrench makes of it."""

from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.estimation.measurement import WrenchReduction
from peg_on_hole_ros.mechanics.geometry import contact_geometry, velocity_jacobians
from peg_on_hole_ros.mechanics.reference import peg_axes, six_equations
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample

# Slip of the surest contact over what noise of a wrench does to it within its interval. In 35
# simulated recordings (4 to 150 mm, 100 Hz to 5 kHz, with and without turning) up to 44 % of the
# steps were not believed where it was 8.6 and more, and 85 % and more where it was 6.3 and less.
BELIEVED = 8.0
# Rates are differences of angles over such a time [s], and none over a longer one.
WINDOW, LONGEST = 0.05, 0.5
# In standard deviations of that difference: below, a peg may rest.
MOVES = 3.0
# Beyond, recordings are looked at evenly thinned.
_MOST = 2000
_TILTS = 1.001, 1.4


class SlipNoise(NamedTuple):
    """
    What a recording has of motion on three contacts.

    Attributes
    ----------
    windows, hidden : int
        Stretches of WINDOW in which the pressed peg moves above gamma0; those of them whose steps
        will not be believed.
    ratio : float
        Median of slip over its noise.
    slip, noise : float
        Medians, of the contact whose slip is told best: its speed, and the standard deviation that
        noise of one wrench gives it within an interval [m/s].

    """

    windows: int
    hidden: int
    ratio: float
    slip: float
    noise: float


class SlipNoiseOf:
    """
    Takes the samples of a recording as they come, and keeps a few numbers a WINDOW of them.

    Parameters
    ----------
    configuration : Configuration
        Its scene, sensor pose and noise.

    """

    def __init__(self, configuration: Configuration):
        self._configuration = configuration
        self._reduction = WrenchReduction(configuration.wrench, configuration.scene)
        self._begin: AngleMeasurement | None = None
        self._force, self._count = np.zeros(6), 0
        self._moves: list[np.ndarray] = []

    def wrench(self, sample: WrenchSample) -> None:
        """Take a wrench."""
        self._force += (*sample.force, *sample.torque)
        self._count += 1

    def angles(self, measurement: AngleMeasurement) -> None:
        """Take an orientation."""
        begin = self._begin
        seconds = 0.0 if begin is None else (measurement.t_ns - begin.t_ns) * 1e-9
        if 0.0 < seconds < WINDOW:
            return
        if WINDOW <= seconds <= LONGEST and self._pressed(begin.q):
            step = np.subtract(measurement.q, begin.q)
            step[1:] = (step[1:] + np.pi) % (2.0 * np.pi) - np.pi
            spread = np.add(measurement.covariance, begin.covariance) / seconds**2
            self._moves.append(np.concatenate([begin.q, step / seconds, spread.ravel()]))
        self._begin, self._count = measurement, 0
        self._force[:] = 0.0

    def _pressed(self, q):
        scene = self._configuration.scene
        if not self._count or not _TILTS[0] * scene.gamma0 < q[0] < _TILTS[1]:
            return False
        mean = self._force / self._count
        on_peg = self._reduction.on_peg(mean[:3], mean[3:], np.asarray(q))[:3]
        weight = scene.peg_mass * peg_axes(np.asarray(q)).T @ scene.gravity
        return (
            np.linalg.norm(on_peg + weight) > self._configuration.monitor.contact_force_threshold
        )

    def result(self, period: float) -> SlipNoise | None:
        """Return it for a time between wrenches [s]; None: nothing moves on three contacts."""
        if not self._moves:
            return None
        moves = np.array(self._moves[:: -(-len(self._moves) // _MOST)]).T
        q, rates, spread = moves[:3], moves[3:6], moves[6:].T.reshape(-1, 3, 3)
        slip, along = _slips(self._configuration.scene, q, rates)
        moving = (slip > MOVES * _stddev(along, spread)).any(axis=1)
        if not moving.any():
            return None
        q, rates, slip, along = q[:, moving], rates[:, moving], slip[moving], along[moving]
        noise = _stddev(along, self._rate_noise(q, rates, period))
        ratio = slip / np.maximum(noise, 1e-12)
        best = ratio.argmax(axis=1)[:, None]
        ratio, slip, noise = (
            np.take_along_axis(values, best, 1)[:, 0] for values in (ratio, slip, noise)
        )
        medians = (float(np.median(values)) for values in (ratio, slip, noise))
        return SlipNoise(len(ratio), int((ratio < BELIEVED).sum()), *medians)

    def _rate_noise(self, q, rates, period):
        """Return the covariance that one wrench's noise gives the rates, shape (n, 3, 3)."""
        scene, scale = self._configuration.scene, self._configuration.filter.slip_velocity_scale
        none = np.zeros((6, q.shape[1]))
        A, still = six_equations(scene, q, rates, none, scale)
        sides = [
            six_equations(scene, q, rates, none + unit[:, None], scale)[1] - still
            for unit in np.eye(6)
        ]
        # At the singular set no acceleration follows; a pseudo-inverse does not raise there.
        by_wrench = np.linalg.pinv(np.moveaxis(A, -1, 0)) @ np.moveaxis(sides, (0, 1), (2, 1))
        G = period * by_wrench[:, :3]
        return G @ self._reduction.covariance @ np.swapaxes(G, 1, 2)


def _slips(scene, q, rates):
    """Return slip speeds, shape (n, 3), and their derivatives by the rates, shape (n, 3, 3)."""
    geometry = contact_geometry(scene, q[0])
    J = velocity_jacobians(geometry, scene.peg_diameter, scene.hole_diameter)
    velocity = np.einsum("icrn,rn->nic", J, rates)
    speed = np.linalg.norm(velocity, axis=2)
    return speed, np.einsum("nic,icrn->nir", velocity, J) / np.maximum(speed, 1e-12)[..., None]


def _stddev(along, covariance):
    return np.sqrt(np.maximum(np.einsum("nir,nrs,nis->ni", along, covariance, along), 0.0))
