"""A motion that the robot's program has announced, and that therefore is no alarm."""

from peg_on_hole_ros.engine.tuned import ANNOUNCED_MOTION
from peg_on_hole_ros.monitor.output_view import OutputView

# What can be announced, and the modes in which it has come about.
MODES = {"lift_off": ("open",), "insertion": ("two_point", "inserted")}
NOTHING = "nothing"


class AnnouncedMotion:
    """
    Withholds `contact_loss` while an announced motion is under way, and for a while behind it.

    Attributes
    ----------
    what : str
        A key of MODES; empty: nothing is expected.

    """

    def __init__(self) -> None:
        self.what = ""
        self._since_ns: int | None = None

    def announce(self, what: str) -> None:
        """Expect a motion from now on, or NOTHING."""
        self.what = what if what in MODES else ""
        self._since_ns = None

    def without_announced_alarms(self, outputs: OutputView) -> OutputView:
        """Return outputs in which what is expected is no alarm; notice whether it has come."""
        if not self.what:
            return outputs
        if outputs.contact_mode not in MODES[self.what]:
            self._since_ns = None
        elif self._since_ns is None or outputs.t_ns < self._since_ns:
            self._since_ns = outputs.t_ns
        alarms = tuple(map(self._without, outputs.alarms))
        raised = alarms != outputs.alarms
        behind_ns = ANNOUNCED_MOTION.behind_ns
        over = self._since_ns is not None and outputs.t_ns - self._since_ns >= behind_ns
        if over and not raised:
            self.announce(NOTHING)
        return OutputView(outputs.t_ns, outputs.row, alarms)

    def _without(self, alarm):
        if alarm.name != "contact_loss" or not alarm.level:
            return alarm
        return alarm._replace(level=0, message=f"expected ({self.what}): {alarm.message}")
