"""Another meaning of the wrench: sign, axes, weight, units, or steps in which it is rounded."""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from peg_on_hole_ros.diagnosis import hypothesis_window
from peg_on_hole_ros.diagnosis.finding import Finding
from peg_on_hole_ros.diagnosis.hypotheses import WrenchTransform, changed, finding_text, hypotheses
from peg_on_hole_ros.diagnosis.rounding import Steps
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import LOOK_WINDOW, WRENCH_BALANCE, WRONG_WRENCH_TEST
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction
from peg_on_hole_ros.mechanics.scene import scene_scalars
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.records import AngleMeasurement, WrenchSample
from peg_on_hole_ros.typed_record import at, dtype_of


class WrongWrench(Suspect):
    """
    Tries what else a wrench may mean on the last second.

    Parameters
    ----------
    stated : Stated

    Attributes
    ----------
    doubtful : bool
        Whether something else fits better by far: what rests on the wrench is withheld.

    """

    NAME = "wrong_wrench"
    ADOPTS = True
    FINDS = (
        ("sign", "`wrench.acts_on`"),
        (
            "axes of the base, of a link below the arm that stands still, or of the sensor turned "
            "by any of 24 quarter and half turns",
            "`wrench.axes`, `wrench.sensor_rpy`",
        ),
        (
            "left-handed axes: one axis mirrored, or two exchanged, of force and torque alike",
            "none: correct the driver. A wrong `wrench.acts_on` with a wrong `sensor_rpy` looks "
            "the same",
        ),
        ("weight that the controller subtracts already", "`wrench.gravity`"),
        ("force in kN, torque in N mm or kN m", "none: the driver has to send N and N m"),
        (
            "numbers rounded more coarsely than the stated noise",
            "`wrench.force_stddev`, `wrench.torque_stddev`, and `bias_..._stddev`",
        ),
    )

    def __init__(self, stated: Stated) -> None:
        configuration = stated.configuration
        self._taken_off = np.array(stated.taken_off)
        self._stated = configuration.wrench
        self._all = hypotheses(configuration.wrench)
        self._meanings = np.array([each.meaning for each in self._all], dtype_of(WrenchTransform))
        self._costs = np.array([each.cost for each in self._all])
        all_said = [set(each.settings) for each in self._all]
        self._rival = [np.array([not one <= more for more in all_said]) for one in all_said]
        # A round peg hardly shows which of its axes is mirrored: it is enough that one is.
        self._left = np.array([each.left_handed for each in self._all])
        for each, rival in zip(self._all, self._rival):
            if each.mirrored:
                rival &= ~self._left
        self._cell = _cell(configuration)
        self._noise = self._cell["noise"][0]
        self._known = self._noise.copy()
        hung = configuration.scene.peg_mass + configuration.wrench.payload_mass
        weight = hung * float(np.linalg.norm(configuration.scene.gravity))
        zero = configuration.wrench.bias_force_stddev
        self._vague = zero > WRONG_WRENCH_TEST.vague * weight
        self.restart()

    def restart(self) -> None:
        """Forget all."""
        self.doubtful = self._coarse = False
        self.finding: Finding | None = None
        self._is_new = False
        self._rows, self._balances = hypothesis_window.new_window(len(self._all))
        self._at, self._best = -1, 0
        self._steps = Steps(), Steps()
        self._last_ns = self._begun_ns = self._odd = self._seen = 0

    @property
    def unsure(self) -> bool:
        """Whether what rests on the wrench is withheld."""
        return self.doubtful or self.finding is not None or self._coarse

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process a wrench and the latest orientation, see the package."""
        before = self.finding
        # On a plate beside the hole neither free air nor three contacts explain a wrench.
        if not instant.beside:
            self._take(instant.sample, instant.measured)
        self._is_new = self.finding is not before

    def findings(self) -> Sequence[Finding]:
        """Return what the last wrench has shown: what there was before it was reported then."""
        new = self.finding if self._is_new else None
        return [finding for finding in (self._rounded(), new) if finding is not None]

    def _take(self, sample: WrenchSample, measurement: AngleMeasurement) -> None:
        t_ns = sample.t_ns
        if self._at < 0 or not self._last_ns < t_ns:
            finding = self.finding
            self.restart()
            self.finding, self._begun_ns = finding, t_ns
        self._seen += 1
        self._last_ns = t_ns
        self._at = (self._at + 1) % LOOK_WINDOW.kept
        row = self._rows[self._at]
        row["t"] = (t_ns - self._begun_ns) * 1e-9
        row["wrench"] = np.subtract((*sample.force, *sample.torque), self._taken_off)
        row["q"] = measurement.q
        self._notice_steps(sample.force, 0)
        self._notice_steps(sample.torque, 1)
        judged = self._odd < WRONG_WRENCH_TEST.often or not self._at % WRONG_WRENCH_TEST.often
        surprising = hypothesis_window.take(
            self._rows, self._balances, self._at, self._meanings, self._cell, judged
        )
        self._odd = self._odd + 1 if surprising else 0
        if not surprising:
            self.doubtful = False
            if hypothesis_window.full(self._rows):
                self.finding = None
        elif judged:
            self._judge()

    def _notice_steps(self, values, part):
        """Use the steps in which a driver rounds forces (0) or torques (1) as noise."""
        steps = self._steps[part]
        if steps.notice(values):
            noise = self._known[3 * part] + steps.variance
            self._noise[3 * part : 3 * part + 3] = noise
        stated = self._stated.torque_stddev if part else self._stated.force_stddev
        self._coarse = self._coarse and part == 1 or steps.coarse(stated)

    def _judge(self):
        tried, balances = hypothesis_window.tried(self._rows), self._balances
        likelihood, left = balances["likelihood"][tried], balances["left"][tried]
        n = len(likelihood)
        ahead = likelihood - likelihood[:, :1]
        gains = ahead.sum(axis=0) * (min(n, WRONG_WRENCH_TEST.news) / n) - self._costs
        gains[0] = 0.0
        best = int(np.argmax(gains))
        self.doubtful = False
        explained = (left[:, best] < LOOK_WINDOW.fits).mean()
        if (
            not best
            or explained < WRONG_WRENCH_TEST.explained
            or left[:, 0].mean() < LOOK_WINDOW.surprise
        ):
            return
        before, after = (float(np.median(balances["unbalanced"][tried, i])) for i in (0, best))
        if after > min(WRONG_WRENCH_TEST.halved * before, self._balanced()):
            return
        # A zero that may be as large as the weight, or a wrong mass, looks like a weight that is
        # taken off: `one_setting` tells them apart, once the peg has turned.
        if self._vague and self._all[best].options.gravity != self._stated.gravity:
            return
        self.doubtful = bool(gains[best] > WRONG_WRENCH_TEST.doubt)
        # What states the same and more is no rival: it is tried again from there on.
        rival = gains[self._rival[best]].max()
        if (
            n < WRONG_WRENCH_TEST.enough
            or gains[best] < WRONG_WRENCH_TEST.sure
            or gains[best] - rival < WRONG_WRENCH_TEST.apart
        ):
            return
        found = self._all[best]
        if self._best != best:
            self._best = best
            near = np.flatnonzero(gains > gains[best] - WRONG_WRENCH_TEST.apart).tolist()
            others = {self._all[i].mirrored for i in near} - {found.mirrored, ""}
            alike = sorted(others) if found.mirrored else []
            text, instead = finding_text(found, before, after, alike), changed(self._stated, found)
            # Several faults at once fit by chance.
            self.finding = Finding(text, instead, voids=True, alone=len(instead) == 1)

    def _balanced(self):
        """Return to how much forces may balance where all is as it should be [N]."""
        forces = self._rows["wrench"][hypothesis_window.tried(self._rows), :3]
        load = float(np.median(np.linalg.norm(forces, axis=1)))
        return (
            WRONG_WRENCH_TEST.room * sqrt(3.0 * self._noise[0]) + WRENCH_BALANCE.unexplained * load
        )

    def _rounded(self) -> Finding | None:
        """Return what is to be stated where a driver rounds more coarsely than noise is stated."""
        found, widths = {}, []
        for name, unit, steps in zip(("force", "torque"), ("N", "N m"), self._steps):
            noise, zero = (getattr(self._stated, key) for key in _noise_of(name))
            if steps.coarse(noise):
                # What rounding takes off stays for as long as a load does: it is noise and zero.
                values = steps.stddev(noise), max(zero, steps.stddev(0.0))
                found |= {key: float(f"{x:.3g}") for key, x in zip(_noise_of(name), values)}
                widths.append(f"the {name} comes in steps of {quantity(steps.step, unit)}")
        if not found or self._seen < WRONG_WRENCH_TEST.enough:
            return None
        settings = " and ".join(f"wrench.{name}: {number(value)}" for name, value in found.items())
        return Finding(
            f"{' and '.join(widths)}, coarser than the stated noise: {settings} would fit", found
        )


def _noise_of(name):
    return f"{name}_stddev", f"bias_{name}_stddev"


def _cell(configuration):
    """Return what compiled code needs to know, a `KnownCell`, shape (1,)."""
    scene, wrench = configuration.scene, configuration.wrench
    sensor, R_PS = np.array(wrench.sensor_xyz), rotation_from_rpy(wrench.sensor_rpy)
    friction = scene.friction
    near = max(1.5 * scene.friction_stddev, 0.15 * friction)
    far = max(3.0 * scene.friction_stddev, 0.5 * friction)
    likely = np.linspace(friction - near, friction + near, WRENCH_BALANCE.likely_frictions)
    others = np.linspace(
        friction - far, friction + far, WRENCH_BALANCE.frictions - WRENCH_BALANCE.likely_frictions
    )
    carried = scene.peg_mass * configuration.monitor.free_acceleration * WRONG_WRENCH_TEST.carried
    noise = WrenchReduction(wrench, scene).noise
    # The weight, its place, and the sensor's zero are known to so much [N], [N m].
    weight = (scene.peg_mass + wrench.payload_mass) * float(np.linalg.norm(scene.gravity))
    known = noise + np.square(
        [WRONG_WRENCH_TEST.weight_known * weight] * 3
        + [WRONG_WRENCH_TEST.center_known * weight] * 3
    )
    known += np.square([wrench.bias_force_stddev] * 3 + [wrench.bias_torque_stddev] * 3)
    memory = np.zeros(1, dtype_of(hypothesis_window.KnownCell))
    cell = at(hypothesis_window.KnownCell, memory)
    cell.scene[:], cell.sensor[:] = scene_scalars(scene), sensor
    cell.payload_mass = wrench.payload_mass
    cell.payload_center[:] = R_PS @ np.array(wrench.payload_com)
    cell.noise[:], cell.carried = known, max(carried, 1e-3) ** 2
    cell.lever = max(float(np.linalg.norm(sensor)), scene.peg_height)
    cell.base_axes[:] = rotation_from_rpy(configuration.joints.hole_rpy).T
    cell.frictions[:] = np.maximum(np.concatenate([likely, others]), 0.0)
    cell.slowest = configuration.monitor.rest_rate * scene.hole_diameter
    cell.angle_stddev = configuration.joints.position_stddev
    return memory
