"""One setting that explains wrench and motion of a cycle, where what is stated does not."""

from collections import deque
from collections.abc import Callable
from math import exp
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.diagnosis import setting_fit
from peg_on_hole_ros.diagnosis.finding import CLEARANCE_OFF, Finding, listed
from peg_on_hole_ros.diagnosis.setting_fit import Cycle, Fit, SettingFit
from peg_on_hole_ros.diagnosis.suspected.suspect import Instant, Stated, Suspect
from peg_on_hole_ros.diagnosis.tuned import SETTING_FIT_TEST
from peg_on_hole_ros.identification.recording import slow_slip
from peg_on_hole_ros.measurements.rotations import rotation_from_rpy, rpy_of, tilt_axes
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.typed_record import Floats

MAY_BE = (
    "wrench.gravity, payload_mass, sensor_xyz, the sensor's zero (tare it; it may have jumped), "
    "units (N, N m), scene.peg_mass, hole_diameter - peg_diameter, joints.hole_rpy, peg_rpy, "
    "tip_frame, joints.delay, the order of joints.names, a joint's zero"
)


class _Look(NamedTuple):
    """What came since the look before."""

    t_ns: int  # the mean of the wrenches' stamps
    wrench: Floats
    wrenches: int
    oriented_ns: int
    q: Floats
    free: bool
    beside: bool  # on a plate beside the hole, which carries as no rim does


class Kind(NamedTuple):
    """
    One kind of setting that may be off.

    Attributes
    ----------
    name : str
    open : slice or None
        Its coordinates; None: the weight is taken off where it is stated not to be, or the
        other way round.
    said : callable
        Returns the finding of configuration and what fits; None: it is too little to be told.

    """

    name: str
    open: slice | None
    said: "Callable[[Configuration, Floats], Finding | None]"


def _gravity(configuration, x):
    measured = configuration.wrench.gravity == "compensated"
    value = "measured" if measured else "compensated"
    already = "is subtracted from the wrench already"
    what = "is not subtracted from the wrench" if measured else already
    text = f"the weight {what}: set wrench.gravity: {value}; {{fits}}"
    return Finding(text, {"gravity": value})


def _mass(configuration, x):
    more, moment = float(x[setting_fit.MASS][0]), x[setting_fit.MASS][1:]
    scene, wrench = configuration.scene, configuration.wrench
    hung = scene.peg_mass + wrench.payload_mass
    if abs(more) < max(SETTING_FIT_TEST.least_mass, SETTING_FIT_TEST.least_weight * hung):
        return None
    centre, R_PS = np.array([0.0, 0.0, scene.mass_center_height]), _sensor(wrench)
    place = centre + moment / more
    payload = np.array(wrench.sensor_xyz) + R_PS @ np.array(wrench.payload_com)
    what = f"{quantity(abs(more), 'kg')} {'more' if more > 0 else 'less'} than is stated"
    near = SETTING_FIT_TEST.near_mass
    sums, its = scene.peg_mass + more, ""
    if np.linalg.norm(place - centre) < near and sums > 0.0:
        its = f"set scene.peg_mass: {number(sums)}, or another wrench.payload_mass"
    elif wrench.payload_mass > 0.0 and np.linalg.norm(place - payload) < near:
        its = f"set wrench.payload_mass: {number(max(wrench.payload_mass + more, 0.0))}"
    else:
        mass = wrench.payload_mass + more
        if mass < SETTING_FIT_TEST.least_mass:
            its = "set another scene.peg_mass or wrench.payload_mass"
        else:
            both = (wrench.payload_mass * payload + more * place) / mass
            com = R_PS.T @ (both - np.array(wrench.sensor_xyz))
            its = f"set wrench.payload_mass: {number(mass)} and payload_com: {listed(com, 4)}"
            its += ", or another scene.peg_mass"
    return Finding(f"below the sensor hangs {what}: {its}; {{fits}}", {})


def _place(configuration, x):
    moved = x[setting_fit.PLACE]
    if np.linalg.norm(moved) < SETTING_FIT_TEST.least_place:
        return None
    found = np.array(configuration.wrench.sensor_xyz) + moved
    what = (
        f"the sensor is {quantity(float(np.linalg.norm(moved)), 'm', 2)} from where it is stated"
    )
    return Finding(f"{what}: set wrench.sensor_xyz: {listed(found, 4)}; {{fits}}", {})


def _hole(configuration, x):
    turn = x[setting_fit.HOLE]
    if np.hypot(*turn) < SETTING_FIT_TEST.least_turn:
        return None
    rpy = rpy_of(rotation_from_rpy(configuration.joints.hole_rpy) @ tilt_axes(turn))
    return Finding(
        f"the hole leans by {np.degrees(np.hypot(*turn)):.1f} degrees from where it is stated: "
        f"set joints.hole_rpy: {listed(rpy, 4)}; {{fits}}",
        {},
        "joints",
    )


def _peg(configuration, x):
    turn = x[setting_fit.PEG]
    if np.hypot(*turn) < SETTING_FIT_TEST.least_turn:
        return None
    rpy = rpy_of(rotation_from_rpy(configuration.joints.peg_rpy) @ tilt_axes(turn))
    robot = configuration.joints.source == "robot"
    what = f"set joints.peg_rpy: {listed(rpy, 4)}" if robot else "state the peg's axis elsewhere"
    return Finding(
        f"the peg leans by {np.degrees(np.hypot(*turn)):.1f} degrees from where it is stated: "
        f"{what}; {{fits}}; a joint's zero that is off looks the same",
        {},
        "joints",
    )


def _clearance(configuration, x):
    larger = float(x[setting_fit.CLEARANCE][0])
    if abs(larger) < SETTING_FIT_TEST.least_larger:
        return None
    scene = configuration.scene
    size = 1e3 * (scene.hole_diameter - scene.peg_diameter) * exp(larger)
    return Finding(f"{CLEARANCE_OFF} {number(size, 2)} mm; {{fits}}", {}, "scene")


def _delay(configuration, x):
    late = float(x[setting_fit.DELAY][0])
    if abs(late) < SETTING_FIT_TEST.least_delay:
        return None
    delay = round(configuration.joints.delay + late, 3)
    who = ("joint states", "wrenches") if late > 0.0 else ("wrenches", "joint states")
    return Finding(
        f"{who[0]} come some {1e3 * abs(late):.0f} ms behind {who[1]} of the same moment: set "
        f"joints.delay: {delay:g}; {{fits}}",
        {},
        "joints",
    )


KINDS = (
    Kind("gravity", None, _gravity),
    Kind("mass", setting_fit.MASS, _mass),
    Kind("place", setting_fit.PLACE, _place),
    Kind("hole", setting_fit.HOLE, _hole),
    Kind("peg", setting_fit.PEG, _peg),
    Kind("clearance", setting_fit.CLEARANCE, _clearance),
    Kind("delay", setting_fit.DELAY, _delay),
)


class OneSetting(Suspect):
    """
    Fits settings, one kind at a time, to a peg that hangs free and then slides on three contacts.

    Zero and friction are open beside each. A kind is told that explains what is stated does not,
    that no other does nearly as well, and that, found in the first half of the contact, explains
    the second. Where none explains it, reactions are withheld, and it is told which may be wrong.

    Parameters
    ----------
    stated : Stated

    """

    NAME = "one_setting"
    FINDS = (
        (
            "`wrench.gravity`, `scene.peg_mass`, `wrench.payload_mass`, `wrench.sensor_xyz`, "
            "`joints.hole_rpy`, `joints.peg_rpy`, the clearance, `joints.delay`: the one that "
            "explains wrench and motion together; where none does, reactions are withheld "
            "(`replay` alone)",
            "half a second in the air, and one and a half that slides on three contacts",
        ),
    )
    OFFLINE = True
    SPANS_TARE = True

    def __init__(self, stated: Stated) -> None:
        self.restate(stated)
        self.restart()

    def restate(self, stated: Stated) -> None:
        """Take another zero, about which that of the fit is spread."""
        self._configuration = stated.configuration
        self._off = np.array(stated.taken_off)

    def restart(self) -> None:
        """Forget all."""
        self._kept: deque[_Look] = deque(maxlen=SETTING_FIT_TEST.kept)
        self._passed: list[tuple[np.ndarray, np.ndarray]] = []
        self._air: list = []
        self._in_contact, self._next = 0, SETTING_FIT_TEST.first
        self._unexplained = 0
        self.finding: Finding | None = None

    @property
    def unsure(self) -> bool:
        """Whether what rests on the wrench is withheld: it means something else than is stated."""
        return self.finding is not None and self.finding.of == "wrench"

    def take_every_wrench(self, t_ns: np.ndarray, wrenches: np.ndarray) -> None:
        """Process every wrench, see the package."""
        if self.finding is None and len(t_ns):
            self._passed.append((t_ns, wrenches))

    def take(self, instant: Instant, unsure: bool) -> None:
        """Process what came since the last look, see the package."""
        if self.finding is not None or not self._passed:
            return
        t_ns, wrenches = (np.concatenate(each) for each in zip(*self._passed))
        self._passed = []
        measured = instant.measured
        if self._kept:
            apart = measured.t_ns - self._kept[-1].oriented_ns
            if apart == 0:
                return
            if not 0 < apart < SETTING_FIT_TEST.silence_ns:
                self.restart()
                return
        mean_ns = int(t_ns[0]) + int((t_ns - t_ns[0]).mean())
        mean = wrenches.mean(axis=0)
        free_now = instant.in_air is True or self._is_clear(measured)
        beside = instant.beside and not free_now
        self._kept.append(
            _Look(mean_ns, mean, len(t_ns), measured.t_ns, measured.q, free_now, beside)
        )
        free = np.array([look.free for look in self._kept])
        too_few = not self._in_contact and free.sum() < SETTING_FIT_TEST.fewest_air
        if free_now or beside or too_few:
            return
        self._in_contact += 1
        if self._in_contact >= self._next and not unsure:
            self._judge(free)

    def _is_clear(self, measured):
        """Return whether the place shows a peg above the rim: a wrong wrench shows no air."""
        if measured.position is None:
            return False
        reach = 0.5 * self._configuration.scene.peg_diameter * np.sin(measured.q[0])
        return bool(measured.position[2] - reach > SETTING_FIT_TEST.clear)

    def _judge(self, free):
        kept = list(self._kept)
        begin_ns = kept[0].t_ns
        t = (np.array([look.t_ns for look in kept]) - begin_ns) * 1e-9
        knots = (np.array([look.oriented_ns for look in kept]) - begin_ns) * 1e-9
        wrench = np.array([look.wrench for look in kept])
        q = np.unwrap(np.array([look.q for look in kept]), axis=0)
        counts = np.array([look.wrenches for look in kept], float)
        cycle = Cycle(t, wrench, counts, knots, q, self._off)
        rows, rim = self._rows(cycle, free, np.array([look.beside for look in kept]))
        self._next = self._in_contact + SETTING_FIT_TEST.first
        if np.count_nonzero(rim) < SETTING_FIT_TEST.fewest:
            return
        fit = SettingFit(self._configuration, cycle, rows, rim)
        weight = self._configuration.wrench.gravity == "compensated"
        stated = fit.fitted(None, fit.start, weight)
        if stated.total - fit.freedoms < 2.0 * SETTING_FIT_TEST.sure:
            self._unexplained = 0
            return
        # What is not told by so much is told by more.
        self._next = 2 * self._in_contact
        fits = {kind.name: self._fitted(fit, kind, weight) for kind in KINDS}
        name = min(fits, key=lambda each: fits[each].total)
        # What takes the weight off is a mass as well.
        room = 2.0 * SETTING_FIT_TEST.apart * self._scale(fits[name], fit)
        if name == "mass" and fits["gravity"].total < fits["mass"].total + room:
            name = "gravity"
        best = next(kind for kind in KINDS if kind.name == name)
        self.finding = None
        if self._named(fit, stated, fits, name):
            self.finding = self._told(cycle, rows, rim, best, weight, fits[name].x)
        if self.finding is None:
            self._note_unexplained(cycle, rows, rim, weight)

    def _rows(self, cycle, free, beside):
        """Return rows in the air before the first contact, and those that slide on the rim."""
        configuration = self._configuration
        scene, wrench = configuration.scene, configuration.wrench
        first = int(np.argmin(free[int(np.argmax(free)) :])) + int(np.argmax(free))
        air = np.flatnonzero(free[: max(first - SETTING_FIT_TEST.before, 0)])
        if len(air) < 10:
            return np.zeros(0, int), np.zeros(0, bool)
        hung = (scene.peg_mass + wrench.payload_mass) * float(np.linalg.norm(scene.gravity))
        least = max(
            SETTING_FIT_TEST.least_load,
            SETTING_FIT_TEST.loud * wrench.force_stddev,
            0.5 * min(hung, 40.0),
        )
        load = np.linalg.norm(cycle.wrench[:, :3] - cycle.wrench[air, :3].mean(axis=0), axis=1)
        loaded = (load > least) & (cycle.q[:, 0] > SETTING_FIT_TEST.above * scene.gamma0)
        loaded &= (np.arange(len(load)) >= first) & (cycle.q[:, 0] < 1.2) & ~beside
        rim = np.flatnonzero(loaded)
        if len(rim):
            every = SettingFit(configuration, cycle, rim, np.ones(len(rim), bool))
            rim = rim[every.slowest() > slow_slip(configuration)]
        air, rim = (_thinned(*each) for each in ((air, 40), (rim, SETTING_FIT_TEST.most)))
        return np.r_[air, rim], np.r_[np.zeros(len(air), bool), np.ones(len(rim), bool)]

    def _fitted(self, fit, kind, weight):
        if kind.open is None:
            return fit.fitted(None, fit.start, not weight)
        begin = fit.start
        if kind.open is setting_fit.DELAY:
            trials = []
            for delay in SETTING_FIT_TEST.delays:
                trial = fit.start
                trial[setting_fit.DELAY] = delay
                trials.append(fit.at(trial, weight))
            begin = min(trials, key=lambda each: each.total).x
        return fit.fitted(kind.open, begin, weight)

    @staticmethod
    def _scale(found: Fit, fit: SettingFit) -> float:
        """Return by how much what is left exceeds the noise: as many nats count for one."""
        return max(found.total / fit.freedoms, 1.0)

    def _named(self, fit, stated, fits, best):
        """Return whether a kind explains it, and no other nearly as well."""
        scale = self._scale(fits[best], fit)
        gains = {kind: 0.5 * (stated.total - each.total) / scale for kind, each in fits.items()}
        nested = {"gravity", "mass"} if best == "gravity" else {best}
        rival = max(gain for kind, gain in gains.items() if kind not in nested)
        return (
            scale < SETTING_FIT_TEST.explained
            and gains[best] > SETTING_FIT_TEST.sure
            and gains[best] - rival > SETTING_FIT_TEST.apart
        )

    def _told(self, cycle, rows, rim, best, weight, x):
        """Return the finding of a kind, if the first half of the contact explains the second."""
        finding = best.said(self._configuration, x)
        contact = np.flatnonzero(rim)
        if finding is None:
            return None
        halves = [
            np.r_[np.flatnonzero(~rim), half]
            for half in (contact[: len(contact) // 2], contact[len(contact) // 2 :])
        ]
        first, second = (
            SettingFit(self._configuration, cycle, rows[half], rim[half]) for half in halves
        )
        found = self._fitted(first, best, weight).x
        other = weight != (best.open is None)
        before, after = second.at(second.start, weight), second.at(found, other)
        scale = self._scale(after, second)
        gain = 0.5 * (before.total - after.total) / scale
        if not (gain > SETTING_FIT_TEST.held_out and scale < SETTING_FIT_TEST.explained):
            return None
        text = (
            f"with it wrench and motion fit each other to {number(_left(after, second), 2)} times "
            f"the noise instead of {number(_left(before, second), 2)}"
        )
        return finding._replace(text=finding.text.replace("{fits}", text), voids=True)

    def _note_unexplained(self, cycle, rows, rim, weight):
        """Withhold the reactions where nothing explains more than a share of the loads."""
        fit = SettingFit(self._configuration, cycle, rows, rim, SETTING_FIT_TEST.unexplained_much)
        stated = fit.fitted(None, fit.start, weight)
        far = (stated.left[rim] > SETTING_FIT_TEST.far).mean()
        self._unexplained = self._unexplained + 1 if far > SETTING_FIT_TEST.often else 0
        if self._unexplained >= SETTING_FIT_TEST.looks:
            self.finding = Finding(
                f"wrench and motion contradict each other in {100 * far:.0f} % of a slide on "
                f"three contacts, and no one setting mends it: check {MAY_BE}",
                {},
                "scene",
                voids=True,
                hint=True,
            )


def _sensor(wrench):
    return rotation_from_rpy(wrench.sensor_rpy)


def _left(found, fit):
    return (found.total / fit.freedoms) ** 0.5


def _thinned(places, most):
    if len(places) <= most:
        return places
    return places[np.arange(most) * len(places) // most]
