"""Time that passes along stamps of outputs, which may go back."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

# One stamp, or an array of them.
Stamps = TypeVar("Stamps", int, np.ndarray)


@dataclass
class StampRun:
    """
    Stamps from one fall to the next.

    Attributes
    ----------
    first_ns, last_ns : int
        Stamps [ns].
    before_ns : int
        Time that had passed at the first [ns].

    """

    first_ns: int
    last_ns: int
    before_ns: int

    def passed(self, t_ns: Stamps) -> Stamps:
        """Return the passed time of a stamp, or of an array of them [ns]."""
        return self.before_ns + t_ns - self.first_ns


class PassedTime:
    """
    Time since the first stamp; none passes where stamps go back.

    A stamp that goes back to between the two before it takes the last of them back: that one was
    wrong, as of a wrench that had leapt ahead.

    Attributes
    ----------
    runs : list of StampRun

    """

    def __init__(self) -> None:
        self.runs: list[StampRun] = []
        self._before_ns: int | None = None

    @property
    def first_ns(self) -> int | None:
        """The first stamp [ns]; None: there was none."""
        return self.runs[0].first_ns if self.runs else None

    @property
    def ns(self) -> int:
        """What has passed [ns]."""
        return self.runs[-1].passed(self.runs[-1].last_ns) if self.runs else 0

    def take_all(self, t_ns: np.ndarray) -> None:
        """Take stamps that rise [ns], the first after all before, as `take` would each."""
        for stamp in t_ns[:1].tolist() + t_ns[-2:].tolist():
            self.take(stamp)

    def take(self, t_ns: int) -> bool:
        """Take the next stamp [ns]; return whether the clock went back."""
        if not self.runs:
            self.runs.append(StampRun(t_ns, t_ns, 0))
            return False
        run = self.runs[-1]
        if t_ns < run.last_ns and self._before_ns is not None and t_ns > self._before_ns:
            run.last_ns = self._before_ns
        if t_ns < run.last_ns:
            self.runs.append(StampRun(t_ns, t_ns, self.ns))
            self._before_ns = None
            return True
        if t_ns > run.last_ns:
            self._before_ns, run.last_ns = run.last_ns, t_ns
        return False
