"""The sensor's zero, by what a free peg reads beside its weight; also a wrong payload or lever."""

from math import hypot, sqrt

import numpy as np

from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import FREE_AIR_TEST
from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.records import WrenchSample


class FreeAir(Suspect):
    """
    Looks for what stays the same in the sensor's axes of a peg that hangs free for certain.

    It looks if the contact mode is `open`, or if the peg turns and the sensor turns with it: the
    force of a contact keeps its direction in the hole.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "free_air"
    FINDS = (
        (
            "`wrench.bias_force`: the bias is wrong, or along gravity `wrench.payload_mass`; tare",
            "a peg in the contact mode `open`, or one that turns in the air with its sensor",
        ),
        (
            "`wrench.bias_torque`: the bias of the torque alone is wrong, as by `sensor_xyz`",
            "the same",
        ),
    )
    OF_ZERO = True

    def __init__(self, stated: Stated) -> None:
        configuration, reduction = stated.configuration, stated.reduction
        scene, wrench = configuration.scene, configuration.wrench
        self._reduction = reduction
        self._about_sensor = np.linalg.inv(reduction.matrix)
        self._gravity_H = np.array(scene.gravity)
        self._mass = scene.peg_mass
        hung = (scene.peg_mass + wrench.payload_mass) * float(np.linalg.norm(scene.gravity))
        carried = FREE_AIR_TEST.carried * scene.peg_mass * configuration.monitor.free_acceleration
        self._known = (
            FREE_AIR_TEST.weight_known * hung + carried,
            FREE_AIR_TEST.center_known * hung + carried * scene.peg_height,
        )
        self._noise = np.array([wrench.force_stddev] * 3 + [wrench.torque_stddev] * 3)
        self._zero = wrench.bias_force_stddev, wrench.bias_torque_stddev
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        # A ring: of each wrench its stamp, what is left, the axes, and whether it was free.
        self._t_ns = np.zeros(FREE_AIR_TEST.kept, np.int64)
        self._read = np.zeros((FREE_AIR_TEST.kept, 6))
        self._axes = np.zeros((FREE_AIR_TEST.kept, 3, 3))
        self._free = np.zeros(FREE_AIR_TEST.kept, bool)
        self._taken = 0
        self.finding: Finding | None = None

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench, see the package."""
        if not unsure:
            self._take(instant.sample, instant.measured.q, instant.in_air is True)

    def _take(self, sample: WrenchSample, q: np.ndarray, free: bool) -> None:
        R_HP = peg_axes(q)
        weight = self._mass * (R_HP.T @ self._gravity_H)
        left = self._reduction.on_peg(sample.force, sample.torque, q)
        left[:3] += weight
        since_ns = sample.t_ns - int(self._t_ns[(self._taken - 1) % FREE_AIR_TEST.kept])
        if self._taken and not 0 < since_ns < 10**9:
            self._taken = 0
        at = self._taken % FREE_AIR_TEST.kept
        # About the sensor, as noise and zero are: the mass centre's lever would mix the two.
        self._read[at] = self._about_sensor @ left
        self._t_ns[at], self._axes[at] = sample.t_ns, R_HP
        self._free[at] = free
        self._taken += 1
        oldest_ns = int(self._t_ns[self._taken % FREE_AIR_TEST.kept])
        full = self._taken >= FREE_AIR_TEST.kept
        full = full and sample.t_ns - oldest_ns >= FREE_AIR_TEST.span_ns
        if full and self.finding is None:
            self._judge(q)

    def _judge(self, q):
        mean = self._read.sum(axis=0) / FREE_AIR_TEST.kept
        force, torque = hypot(*mean[:3]), hypot(*mean[3:])
        least = [
            hypot(
                FREE_AIR_TEST.sure * self._noise[3 * part] / sqrt(FREE_AIR_TEST.kept),
                FREE_AIR_TEST.stated * self._zero[part],
                self._known[part],
            )
            for part in (0, 1)
        ]
        off = force > least[0], torque > least[1]
        if off[0] and self._hangs(least[0]):
            return
        if not any(off) or not self._surely_free(off):
            return
        sign = self._reduction.sign
        shown = ", ".join(number(sign * x, 2) for x in mean[:3])
        turned = ", ".join(number(sign * x, 2) for x in mean[3:])
        gravity_S = self._reduction.gravity_in_sensor(q, self._gravity_H)
        pull, gravity = -float(mean[:3] @ gravity_S), float(np.linalg.norm(gravity_S))
        if off[0] and abs(pull) > FREE_AIR_TEST.along * force * gravity:
            text = (
                f"wrench.payload_mass: a free peg weighs {quantity(pull / gravity**2, 'kg', 2)} "
                f"more than is stated, or the zero is off by [{shown}] N: tare it, or calibrate "
                "--payload"
            )
        elif off[0]:
            text = (
                f"wrench.bias_force: a free peg reads [{shown}] N beside its weight, in the "
                "sensor's axes: tare it, or state the zero"
            )
        else:
            text = (
                f"wrench.bias_torque: a free peg reads [{turned}] N m beside its weight, though "
                "its force fits: tare it, or check sensor_xyz, payload_com and mass_center_height"
            )
        self.finding = Finding(text, {})

    def _surely_free(self, off):
        if self._free.all():
            return True
        part = slice(0, 3) if off[0] else slice(3, 6)
        noise = self._noise[part][0] ** 2
        same = _spread(self._read[:, part]) / noise
        if same >= 3.0 * FREE_AIR_TEST.same:
            return False
        # The same force, of a constant direction in the hole.
        other = _spread(self._in_hole(part)) / noise
        return 0.5 * FREE_AIR_TEST.kept * (other - same) > FREE_AIR_TEST.likelier

    def _hangs(self, least):
        """Find a weight: it keeps its direction in the hole as a contact does, and pulls."""
        part, noise = slice(0, 3), self._noise[0] ** 2
        other, force = _spread(self._read[:, part]) / noise, self._in_hole(part)
        same, mean = _spread(force) / noise, force.sum(axis=0) / FREE_AIR_TEST.kept
        gravity = float(np.linalg.norm(self._gravity_H))
        steady = (
            same < 3.0 * FREE_AIR_TEST.same
            and 0.5 * FREE_AIR_TEST.kept * (other - same) > FREE_AIR_TEST.likelier
        )
        # Without gravity nothing weighs.
        if not steady or not gravity:
            return False
        pull = -float(mean @ self._gravity_H) / gravity
        if not pull > max(least, FREE_AIR_TEST.along * hypot(*mean)):
            return False
        self.finding = Finding(
            "wrench.payload_mass: a peg that turns in the air weighs "
            f"{quantity(pull / gravity, 'kg', 2)} more than is stated: state it, or calibrate "
            "--payload",
            {},
        )
        return True

    def _in_hole(self, part):
        """Return forces or torques in the hole's axes, shape (n, 3)."""
        R_HS = self._axes @ self._reduction.matrix[:3, :3]
        return np.einsum("nij,nj->ni", R_HS, self._read[:, part])


def _spread(rows):
    """Return the sum of the variances of three components."""
    apart = rows - rows.sum(axis=0) / len(rows)
    return float(np.vdot(apart, apart)) / len(rows)
