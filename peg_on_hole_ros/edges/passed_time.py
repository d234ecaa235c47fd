"""Time that passes along stamps of outputs, which may go back."""


class PassedTime:
    """
    Time since the first stamp; none passes where stamps go back.

    A stamp that goes back to between the two before it takes the last of them back: that one was
    wrong, as of a wrench that had leapt ahead.

    Attributes
    ----------
    first_ns : int or None
        The first stamp [ns].
    ns : int
        What has passed [ns].

    """

    def __init__(self):
        self.first_ns: int | None = None
        self.ns = 0
        self._last_ns = 0
        self._before: tuple[int, int] | None = None

    def take(self, t_ns: int) -> bool:
        """Take the next stamp [ns]; return whether the clock went back."""
        if self.first_ns is None:
            self.first_ns = self._last_ns = t_ns
        if t_ns < self._last_ns and self._before and t_ns > self._before[0]:
            self._last_ns, self.ns = self._before
        back = t_ns < self._last_ns
        self._before = None if back else (self._last_ns, self.ns)
        self.ns += max(t_ns - self._last_ns, 0)
        self._last_ns = t_ns
        return back
