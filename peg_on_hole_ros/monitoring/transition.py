"""The transition flag: three-point contact has become two-point contact."""

from peg_on_hole_ros.options import MonitorOptions

# A peg that has been in the air above gamma0 for so long [s] has left the rim.
LEFT = 0.2


class TransitionFlag:
    """
    True once three-point contact has become two-point contact, with hysteresis and dwell.

    It can rise after contact above gamma0 only, and not once the peg has left the rim again: one
    that comes upright through the air has not gone through three-point contact. It falls once the
    tilt has surely been above gamma0 for a while.
    """

    def __init__(self, options: MonitorOptions):
        self.options = options
        self.restart()

    def restart(self):
        """Lower the flag."""
        self.raised = False
        self._armed = False
        self._since: float | None = None
        self._aloft: float | None = None

    def update(self, t: float, below: float, touching: float) -> bool:
        """
        Return the flag.

        Parameters
        ----------
        t : float
            [s].
        below, touching : float
            Probabilities that gamma is below gamma0, and that anything touches.

        """
        options = self.options
        if not self.raised:
            above = touching * (1.0 - below)
            self._armed |= above > options.transition_probability_on
            if (1.0 - touching) * (1.0 - below) <= 0.5:
                self._aloft = None
            elif self._aloft is None:
                self._aloft = t
            elif t - self._aloft >= LEFT:
                self._armed = False
            self.raised = self._armed and touching * below > options.transition_probability_on
            self._since = None
        elif below >= options.transition_probability_off:
            self._since = None
        elif self._since is None:
            self._since = t
        elif t - self._since >= options.transition_hold:
            self.restart()
        return self.raised
