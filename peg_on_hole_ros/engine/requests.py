"""What a stream is asked for, such as a tare or a reset, and what is answered."""

from collections import Counter

import numpy as np

from peg_on_hole_ros.engine.announced_motion import Expected
from peg_on_hole_ros.engine.engine import Engine
from peg_on_hole_ros.engine.free_peg import UNKNOWN, FreeFor, not_free, turns
from peg_on_hole_ros.engine.still_poses import StillPoses
from peg_on_hole_ros.monitor.outputs import outputs_of
from peg_on_hole_ros.records import Answer, Outputs, WrenchSample

# A tare takes no wrench that is older: the peg may have touched before.
TARE_NS = 500_000_000


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
        self._free = FreeFor(engine.configuration)
        self._forget()

    def _forget(self):
        self._expected, self._poses = Expected(), StillPoses(self._engine.configuration)

    @property
    def watching(self) -> bool:
        """Whether what is told of each wrench is looked at."""
        return self.expecting or self._free.asked

    @property
    def expecting(self) -> bool:
        """Whether a motion was announced and has not come about."""
        return bool(self._expected.what)

    def judged(self, outputs: Outputs) -> Outputs:
        """Return outputs in which what is expected is no alarm."""
        return self._expected.judged(outputs)

    def tare_if_free(self) -> None:
        """Tare a peg that has hung free for long, where that is asked for."""
        free = self._free.asked and self._free.long(self._told)
        if free and not self._engine.findings.unsure:
            self._counts["tare_automatic"] += self.tare().success

    def reset(self) -> Answer:
        """Restart filter and monitor, forget what was learnt; the tare stays."""
        self._engine.reset()
        self._forget()
        self._counts["reset"] += 1
        return Answer(
            True,
            "filter and monitor restarted, with friction and clearance as stated, and the tare as "
            "it was taken; they wait for a joint state"
            if self._counts["tare"]
            else "filter and monitor restarted, with friction and clearance as stated; they wait "
            "for a joint state",
        )

    def tare(self) -> Answer:
        """Take the mean of the last wrenches as that of a free-hanging peg, if there are any."""
        wrench = self._engine.configuration.wrench
        if self._lacking:
            return self.refuse_tare(self._lacking)
        told, findings = self._told, self._engine.findings
        held = not_free(told, self._engine.configuration, findings.unsure)
        if held and not wrench.tare_in_contact:
            return self.refuse_tare(
                f"{held}; call again once it hangs free and still (wrench.tare_in_contact takes "
                "it all the same)"
            )
        samples = self._latest()
        taken = self._engine.tare(samples)
        self._counts["tare"] += 1
        numbers = ", ".join(f"{value:.6g}" for value in taken)
        seconds = (samples[-1].t_ns - samples[0].t_ns) * 1e-9
        return Answer(
            True,
            f"tare over {len(samples)} samples of {seconds:.3g} s, sensor axes "
            f"[Fx, Fy, Fz N, Mx, My, Mz N m]: {numbers}{_unknown(told)}",
        )

    def refuse_tare(self, reason: str) -> Answer:
        """Take no tare, and count that; stamps do not tell how long ago the last wrench came."""
        self._counts["tare_refused"] += 1
        return Answer(False, f"nothing taken: {reason}")

    def expect(self, what: str) -> Answer:
        """Take what the robot's program announces, `lift_off`, `insertion` or `nothing`."""
        self._expected.announce(what)
        self._counts["expected"] += 1
        return Answer(True, f"expected: {what}")

    def take_pose(self) -> Answer:
        """Take the present pose as that of a free and still peg; say what all such poses tell."""
        refused = self._poses.refused or self._lacking
        if not refused and self._told is not None:
            # Whether it touches cannot be told before the payload is known.
            refused = turns(self._told, self._engine.configuration)
        if refused:
            return Answer(False, f"no pose taken: {refused}")
        samples = self._latest()
        mean = np.mean([[*sample.force, *sample.torque] for sample in samples], axis=0)
        gravity_S = self._engine.processor.gravity_in_sensor
        return Answer(True, self._poses.take(gravity_S, mean, len(samples)))

    @property
    def _lacking(self) -> str:
        if self._engine.recent and self._engine.processor.oriented:
            return ""
        return "no wrench and orientation have arrived yet"

    def _latest(self) -> list[WrenchSample]:
        """Return the wrenches of the last moment."""
        recent = self._engine.recent
        return [each for each in recent if recent[-1].t_ns - each.t_ns <= TARE_NS]

    @property
    def _told(self):
        told = self._engine.told
        return None if told is None else outputs_of(*told)


def _unknown(told):
    """Return what there is to add to a tare where nothing told whether the peg hung free."""
    if told is None or told.contact_mode != UNKNOWN:
        return ""
    return "; the contact mode was unknown: right only of a peg that hung free"
