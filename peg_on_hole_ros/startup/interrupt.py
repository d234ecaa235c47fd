"""
Signals that raise KeyboardInterrupt, or set a note that a loop looks at.

A shell that ignores SIGINT, as a script does for what it starts in the background, passes that
on, and Python then installs no handler: the command could only be killed. So an ignored signal is
replaced as a default one is; a handler that a calling program has installed stays.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
_PLAIN = (signal.default_int_handler, signal.SIG_DFL, signal.SIG_IGN)
# What is raised while these load compiled code may reach C that loses it: the process would end
# by SIGABRT, or go on.
_NOT_WITHIN = ("numba", "llvmlite")
# Put off by so long [s], at most so often: compiling takes minutes.
_RETRY_AFTER, _MOST_RETRIES = 0.02, 50


class _Interrupt:
    """A signal handler that raises KeyboardInterrupt, a little later where it must not."""

    def __init__(self) -> None:
        self._times = 0
        self._timer: threading.Timer | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        while frame is not None and not _within(frame):
            frame = frame.f_back
        if frame is None or self._times >= _MOST_RETRIES:
            raise KeyboardInterrupt
        self._times += 1
        again = threading.main_thread().ident, number
        self._timer = threading.Timer(_RETRY_AFTER, signal.pthread_kill, again)
        self._timer.daemon = True
        self._timer.start()

    def cancel(self) -> None:
        """Let a signal that was put off be none."""
        if self._timer is not None:
            self._timer.cancel()


def _within(frame):
    return str(frame.f_globals.get("__name__")).partition(".")[0] in _NOT_WITHIN


def _replaceable() -> dict:
    """Return the handlers that no calling program has installed, by signal."""
    if threading.current_thread() is not threading.main_thread():
        return {}  # Python lets the main thread alone install a handler
    found = {number: signal.getsignal(number) for number in SIGNALS}
    return {n: was for n, was in found.items() if was in _PLAIN or isinstance(was, _Interrupt)}


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Let SIGINT and SIGTERM raise KeyboardInterrupt: files in the making are removed."""
    handler, before = _Interrupt(), _replaceable()
    for number in before:
        signal.signal(number, handler)
    try:
        yield
    finally:
        handler.cancel()
        for number, was in before.items():
            signal.signal(number, was)


def note_signals() -> list[int]:
    """
    Return a list that SIGINT and SIGTERM fill, for a loop that looks at it in each of its turns.

    An exception would break into asyncio or ROS at any moment: half of an estimate would be
    published. rclpy's own handlers shut ROS down in the middle of a callback, and
    EventsExecutor.spin() ignores them. Within `ended_by_signals` the handlers end with that.
    """
    noted: list[int] = []
    for number in _replaceable():
        signal.signal(number, lambda number, frame: noted.append(number))
    return noted
