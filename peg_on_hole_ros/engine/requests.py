"""What a stream is asked for, such as a tare or a reset, and what is answered."""

from collections import Counter

import numpy as np

from peg_on_hole_ros.engine.announced_motion import AnnouncedMotion
from peg_on_hole_ros.engine.engine import Engine
from peg_on_hole_ros.engine.free_peg import FREE, FreeFor, why_not_free
from peg_on_hole_ros.engine.still_poses import StillPoses
from peg_on_hole_ros.engine.tuned import TARE
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.records import Answer, WrenchSample

_ALL_THE_SAME = (
    "; call again once it hangs free and still (wrench.tare_in_contact: true accepts it now)"
)


class Requests:
    """
    Carries out what is asked for.

    Parameters
    ----------
    engine : Engine
    counts : Counter
        Counted up, and looked at for whether there was a tare.

    """

    def __init__(self, engine: Engine, counts: Counter[str]) -> None:
        self._engine, self._counts = engine, counts
        self.forget()

    def forget(self) -> None:
        """Forget what was asked for, and begin by the settings of the engine."""
        self._expected, self._poses = AnnouncedMotion(), StillPoses(self._engine.configuration)
        self._free = FreeFor(self._engine.configuration)

    @property
    def watching(self) -> bool:
        """Whether the outputs of each wrench are looked at."""
        return self._free.asked

    @property
    def expecting(self) -> bool:
        """Whether a motion was announced and has not come about."""
        return bool(self._expected.what)

    def without_announced_alarms(self, outputs: OutputView) -> OutputView:
        """Return outputs in which what is expected is no alarm."""
        return self._expected.without_announced_alarms(outputs)

    def tare_if_free(self) -> None:
        """Tare a peg that has hung free for long, where that is asked for."""
        settings = self._engine.settings_against_data
        free = self._free.asked and self._free.long(self._engine.latest, settings.zero_open_ns)
        if free and not settings.unsure_of_meaning:
            self._counts["tare_automatic"] += self.tare().success

    def reset(self) -> Answer:
        """Restart filter and monitor, forget what was learnt; the tare stays."""
        self._engine.reset()
        self.forget()
        self._counts["reset"] += 1
        return Answer(
            True,
            "filter and monitor are restarted, with friction and clearance as stated and with the "
            "last tare; they wait for a joint state"
            if self._counts["tare"]
            else "filter and monitor are restarted, with friction and clearance as stated; they "
            "wait for a joint state",
        )

    def tare(self) -> Answer:
        """Take the mean of the last wrenches as zero, where they show a peg that hangs free."""
        samples = self._latest()
        lacking = self._lacking(samples)
        if lacking:
            return self.refuse_tare(lacking)
        held = self._held(samples)
        if held and not self._all_the_same:
            return self.refuse_tare(f"{held}{_ALL_THE_SAME}")
        shown = self._shown_by(held)
        taken = self._engine.tare(samples)
        self._counts["tare"] += 1
        numbers = ", ".join(f"{value:.6g}" for value in taken)
        seconds = (samples[-1].t_ns - samples[0].t_ns) * 1e-9
        return Answer(
            True,
            f"tare over {len(samples)} samples of {seconds:.3g} s, sensor axes "
            f"[Fx, Fy, Fz N, Mx, My, Mz N m]: {numbers}{shown}",
        )

    def refuse_tare(self, reason: str) -> Answer:
        """Refuse a tare, and count that; stamps do not show how long ago the last wrench came."""
        self._counts["tare_refused"] += 1
        return Answer(False, f"nothing taken: {reason}")

    def expect(self, what: str) -> Answer:
        """Process what the robot's program announces, `lift_off`, `insertion` or `nothing`."""
        self._expected.announce(what)
        self._counts["expected"] += 1
        return Answer(True, f"expected: {what}")

    def take_pose(self) -> Answer:
        """Use the present pose as that of a free and still peg; return what all such show."""
        samples = self._latest()
        refused = self._poses.refused or self._lacking(samples)
        if not refused and not self._all_the_same:
            held = self._held(samples, payload_unknown=True)
            refused = f"{held}{_ALL_THE_SAME}" if held else ""
        if refused:
            return Answer(False, f"no pose taken: {refused}")
        mean = np.mean([[*sample.force, *sample.torque] for sample in samples], axis=0)
        processor = self._engine.processor
        read = processor.in_sensor_axes(mean)
        return Answer(True, self._poses.take(processor.gravity_in_sensor, read, len(samples)))

    @property
    def _all_the_same(self) -> bool:
        """Whether a peg counts as free by the user's word."""
        return self._engine.configuration.wrench.tare_in_contact

    def _lacking(self, samples) -> str:
        """Return what there is too little of for any mean, or nothing."""
        if not samples or not self._engine.processor.oriented:
            return "no wrench and orientation have arrived yet"
        seconds = (samples[-1].t_ns - samples[0].t_ns) * 1e-9
        if seconds < TARE.least_ns * 1e-9:
            return (
                f"call again after {TARE.least_ns * 1e-9:g} s: {len(samples)} wrenches over "
                f"{seconds:.3g} s have come since a start, reset or silence (filter.max_gap), or "
                "since the wrench changed again"
            )
        return ""

    def _held(self, samples, payload_unknown=False):
        """Return why nothing shows a free peg, or nothing."""
        engine = self._engine
        settings = engine.settings_against_data
        unsure, open_ns = settings.unsure_of_meaning, settings.zero_open_ns
        # What hangs there may be a payload as well as a zero.
        open_ns = 0 if payload_unknown else open_ns
        return why_not_free(
            engine.latest, samples, engine.processor, unsure, payload_unknown, open_ns
        )

    def _shown_by(self, held):
        """Return what there is to add to a tare where the contact mode did not show a free peg."""
        if held:
            return f"; accepted because of wrench.tare_in_contact, although {held}"
        latest = self._engine.latest
        mode = latest and latest.contact_mode
        if mode == FREE:
            return ""
        still_ns = self._engine.settings_against_data.zero_open_ns
        if still_ns:
            return (
                f"; contact mode {mode}: the peg has been at rest for {still_ns * 1e-9:.2g} s "
                "since the start, and the reading is assumed to be the bias of a sensor that was "
                "never tared; tare it again in the air if it touched. Earlier estimates are "
                "discarded"
            )
        return (
            f"; contact mode {mode}, but the sensor reads no more than the weight and a plausible "
            "bias"
        )

    def _latest(self) -> list[WrenchSample]:
        """
        Return the wrenches that a mean is taken of.

        They are the last, with no silence between, since one value stood still; where nobody has
        taken a zero, all of the last half second.
        """
        last: list[WrenchSample] = []
        silence_ns = self._engine.configuration.filter.max_gap * 1e9
        stood_ns = self._engine.processor.stood_still_until_ns
        all_of_them = self._engine.settings_against_data.zero_open_ns > 0
        for sample in reversed(self._engine.recent):
            if sample.t_ns <= stood_ns:
                break
            if last:
                since_ns = last[0].t_ns - sample.t_ns
                lasts_ns = last[0].t_ns - last[-1].t_ns
                enough = len(last) >= TARE.fewest and lasts_ns >= TARE.least_ns
                enough = enough and not all_of_them
                if enough or since_ns > TARE.oldest_ns or last[-1].t_ns - sample.t_ns > silence_ns:
                    break
            last.append(sample)
        return last[::-1]
