"""When the next wrench is looked at."""

# Between two wrenches that are looked at, and between the first so many: before a contact is told.
PERIOD_NS, FIRST_NS, FIRST = 20_000_000, 4_000_000, 10


class Due:
    """
    Counts wrenches that are looked at; apart from the looks, so that none of them can stop it.

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
        """Take the stamp of a wrench that is looked at [ns]; one that falls begins anew."""
        if not self._last_ns < t_ns:
            self.restart()
        self._seen += 1
        self.ns = t_ns + (PERIOD_NS if self._seen > FIRST else FIRST_NS)
        self._last_ns = t_ns
