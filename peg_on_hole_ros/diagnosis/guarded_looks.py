"""Keeps a side look that fails from ending the run: it is switched off, counted and reported."""

from collections import Counter
from collections.abc import Callable
from typing import Generic, TypeVar

# Begins the name of a count; and characters of an error's own text that are reported.
_COUNT, _MOST = "look_failed_", 200
Look = TypeVar("Look")
Answer = TypeVar("Answer")


class Failures:
    """
    The side looks that failed in a run, by name.

    Parameters
    ----------
    counts : Counter
        Counted up: `look_failed_` and the name, once for each.

    Attributes
    ----------
    errors : dict of str to Exception
        What each of them raised.

    """

    def __init__(self, counts: Counter[str]) -> None:
        self._counts = counts
        self.errors: dict[str, Exception] = {}

    def note(self, name: str, error: Exception) -> None:
        """Switch a look off for the rest of the run."""
        self.errors[name] = error
        self._counts[_COUNT + name] += 1

    @property
    def names(self) -> list[str]:
        """The counts of those that failed, by their names."""
        return [_COUNT + name for name in self.errors]

    @property
    def lines(self) -> list[str]:
        """Which look failed, and by what error, a line each."""
        return [
            f"{_COUNT}{name}: {_described(error)}; this look is switched off for the rest of "
            "the run, and the estimate does not depend on it: a fault of the program, please "
            "report it"
            for name, error in self.errors.items()
        ]


class GuardedLook(Generic[Look]):
    """
    Switches off, counts and reports a look that raises, so that it never ends the run.

    Any `Exception` is caught, as a wrong key or type within a look is no reason to end a run
    either. What ends a process (KeyboardInterrupt, SystemExit) is none.

    Parameters
    ----------
    name : str
        Looks of one name are switched off together.
    make : callable
        Returns the look; it may fail as well.
    failures : Failures

    Attributes
    ----------
    look : object or None
        The look as it was left by the last call; None: it could not be made.

    """

    def __init__(self, name: str, make: Callable[[], Look], failures: Failures) -> None:
        self._name, self._failures = name, failures
        self.look: Look | None = None
        if not self.failed:
            try:
                self.look = make()
            except Exception as error:
                failures.note(name, error)

    @property
    def failed(self) -> bool:
        """Whether it is switched off."""
        return self._name in self._failures.errors

    def __call__(self, use: Callable[[Look], Answer], otherwise: Answer) -> Answer:
        """Return what `use` returns of the look; `otherwise` once it has failed."""
        if self.look is None or self.failed:
            return otherwise
        try:
            return use(self.look)
        except Exception as error:
            self._failures.note(self._name, error)
            return otherwise


def _described(error):
    """Return an error as a text, with the place where it was raised."""
    text, place = " ".join(str(error).split()), error.__traceback__
    while place is not None and place.tb_next is not None:
        place = place.tb_next
    at = ""
    if place is not None:
        file = place.tb_frame.f_code.co_filename.replace("\\", "/").rpartition("/")[2]
        at = f" at {file}:{place.tb_lineno}"
    return f"{type(error).__name__}{': ' if text else ''}{text[:_MOST]}{at}"
