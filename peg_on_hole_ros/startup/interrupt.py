"""Ctrl-C and SIGTERM end the work by KeyboardInterrupt, where that can be raised."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

# What is raised while these load compiled code may reach C that loses it: the process would end
# by SIGABRT, or go on.
_NOT_WITHIN = ("numba", "llvmlite")
# Put off by so long [s], at most so often: compiling takes minutes.
_LATER, _OFTEN = 0.02, 50


class _Interrupt:
    """A signal handler that raises KeyboardInterrupt, a little later where it must not."""

    def __init__(self) -> None:
        self._times = 0
        self._timer: threading.Timer | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        while frame is not None and not _within(frame):
            frame = frame.f_back
        if frame is None or self._times >= _OFTEN:
            raise KeyboardInterrupt
        self._times += 1
        again = threading.main_thread().ident, number
        self._timer = threading.Timer(_LATER, signal.pthread_kill, again)
        self._timer.daemon = True
        self._timer.start()

    def cancel(self) -> None:
        """Let a signal that was put off be none."""
        if self._timer is not None:
            self._timer.cancel()


def _within(frame):
    return str(frame.f_globals.get("__name__")).partition(".")[0] in _NOT_WITHIN


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Let SIGTERM end the work as Ctrl-C does, so that files in the making are removed."""
    handler, ours = _Interrupt(), {}
    if threading.current_thread() is threading.main_thread():
        # Whoever calls this from a program may have plans of his own for the signals.
        plain = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
        ours = {n: before for n, before in plain.items() if signal.getsignal(n) is before}
    for number in ours:
        signal.signal(number, handler)
    try:
        yield
    finally:
        handler.cancel()
        for number, before in ours.items():
            signal.signal(number, before)
