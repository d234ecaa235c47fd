"""When the next wrench is looked at."""

from peg_on_hole_ros.diagnosis.tuned import LOOK_TIMES


class Due:
    """
    When the next wrench is looked at; apart from the looks, so that none of them can stop it.

    Attributes
    ----------
    ns : int
        Stamp from which on the next wrench is wanted [ns].

    """

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin anew."""
        self.ns = self._seen = self._last_ns = 0

    def take(self, t_ns: int) -> None:
        """Process the stamp of a wrench that is looked at [ns]; one that falls begins anew."""
        if not self._last_ns < t_ns:
            self.restart()
        self._seen += 1
        many = self._seen > LOOK_TIMES.first
        self.ns = t_ns + (LOOK_TIMES.period_ns if many else LOOK_TIMES.first_ns)
        self._last_ns = t_ns
