"""An unscented filter on the estimator's own process: sigma points in place of tangents."""

import numpy as np
from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

from peg_on_hole_ros.estimator.held_peg import ContactSet, HeldPeg
from peg_on_hole_ros.estimator.methods import CONSTANTS
from peg_on_hole_ros.estimator.settings import default_settings
from peg_on_hole_ros.estimator.state import ACCELERATION, ANGLE, FRICTION, OPEN, RATE
from peg_on_hole_ros.estimator.step import follow_load
from peg_on_hole_ros.mechanics.kernel import closed_forms, equations, pose_of, workspace

# Friction is Coulomb's: what is not known of its direction is for the sigma points to tell [m/s].
_SHARP = (1e-6,) * 3
_NEAREST = 1e-5
# All weights of the mean are positive, so that no covariance is lost.
_SPREAD, _NORMAL, _KAPPA = 1.0, 2.0, 0.0


def make_unscented(scene, options, wrench_noise, offsets=None) -> "Unscented":
    """Return the filter; parameters as for `HeldPeg`."""
    constants = default_settings(**CONSTANTS["one_level"])
    return Unscented(scene, options, wrench_noise, offsets, constants)


class Unscented(HeldPeg):
    """
    filterpy's unscented filter for the wrench, with one level of acceleration.

    Process and orientations are linear: there sigma points give what Kalman's filter gives. What
    else a scene may leave open than friction is refused.
    """

    def __init__(self, *arguments):
        super().__init__(*arguments)
        if self._n != OPEN:
            raise ValueError("the unscented filter learns friction, and nothing else")
        w = self._n + 3
        points = MerweScaledSigmaPoints(w, _SPREAD, _NORMAL, _KAPPA)
        self._unscented = UnscentedKalmanFilter(w, 6, 0.0, _unbalance, None, points)
        self._points, self._work = points, workspace()

    def weigh(self, u, contacts: ContactSet):
        """Take a wrench on the peg, and fill in the record; see `HeldPeg`."""
        s, o, n = self.state, self.constants, self._n
        # The first wrench finds the reactions, by tangents that are taken anew.
        if contacts is not ContactSet.THREE or s.since[1] < 0.0:
            super().weigh(u, contacts)
            return
        self._u[:] = u
        follow_load(s, o, self.scalars, self._u, s.step[0])
        s.since[1] += s.step[0]
        s.step[0] = 0.0
        x, P = s.x[0], s.P[0]
        P[n:, :] = P[:, n:] = 0.0
        P[range(n, n + 3), range(n, n + 3)] = (o.reaction_prior * s.load[0]) ** 2
        kalman = self._unscented
        kalman.x, kalman.P = x.copy(), P.copy()
        kalman.sigmas_f = self._points.sigma_points(kalman.x, kalman.P)
        more = {"p": self.scalars, "work": self._work}
        at_mean = _unbalance(x, self._u, **more)
        columns = [_unbalance(x, self._u + unit, **more) - at_mean for unit in np.eye(6)]
        noise = np.transpose(columns) @ self.wrench_noise @ columns
        kalman.update(np.zeros(6), noise, u=self._u, **more)
        x[:], P[:] = kalman.x, 0.5 * (kalman.P + kalman.P.T)
        x[FRICTION] = max(x[FRICTION], 0.0)
        s.nis[1] = float(kalman.y @ kalman.SI @ kalman.y)
        s.mean[:], s.covariance[:] = x, P
        s.friction_force2[:] = x[FRICTION] ** 2 * (x[n:] ** 2 + np.diagonal(P)[n:])
        self._fill()


def _unbalance(x, u, p, work):
    """Return by how much the six equations do not hold at a state with its reactions."""
    pose = np.array(x[ANGLE : ANGLE + 3])
    pose[0] = max(pose[0], p.gamma0 + _NEAREST)
    _, wrench = pose_of(p, pose, u, work)
    geo = closed_forms(p.d, p.D, p.H_c, p.gamma0, pose[0])
    rates = tuple(x[RATE : RATE + 3].tolist())
    friction = max(float(x[FRICTION]), 0.0)
    equations(p.m, p.Ie, p.Iz, friction, p.d, p.D, _SHARP, geo, rates, wrench, work)
    s, c, h_c, dh_c, dz_c = geo[0], geo[1], geo[8], geo[10], geo[11]
    g, a, b = x[ACCELERATION : ACCELERATION + 3]
    inert = np.array(
        [
            (p.m * (dh_c**2 + dz_c**2) + p.Ie) * g,
            (p.m * h_c**2 + p.Ie * s**2 + p.Iz * c**2) * a + p.Iz * c * b,
            p.Iz * (c * a + b),
            p.m * dh_c * g,
            p.m * h_c * a,
            p.m * dz_c * g,
        ]
    )
    contacts = work[:18].reshape(6, 3)
    return inert - contacts @ x[OPEN : OPEN + 3] - work[18:24]
