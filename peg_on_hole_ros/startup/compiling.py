"""How far compiling is: the first start of a version compiles what later ones find kept."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from numba.core import event
from numba.core.dispatcher import Dispatcher

# On two cores of 2020 to slower ones that others share; once for each state of the sources.
COMPILING = "compiling, for the first start of this version only: one to four minutes"
_PACKAGE = __name__.partition(".")[0] + "."


@contextmanager
def watched(progress: Callable[[float], None]) -> Iterator[None]:
    """
    Call `progress` with the share that is compiled, once a function is begun and as each is done.

    Parameters
    ----------
    progress : callable
        Is given 0 at first, and never where all is kept from an earlier start. Some of the
        package's functions may not be needed, so the share need not come to 1.

    """
    listener = _Listener(progress)
    event.register("numba:compile", listener)
    try:
        yield
    finally:
        event.unregister("numba:compile", listener)


def log_quarters(log: Callable[[str], None]) -> Callable[[float], None]:
    """Return what takes the share that is done, and logs the beginning and each quarter."""
    logged = [-1]

    def log_share(share):
        if (quarter := int(4 * share)) > logged[0]:
            logged[0] = quarter
            log(f"compiling: {25 * quarter} %" if quarter else COMPILING)

    return log_share


class _Listener(event.Listener):
    def __init__(self, progress):
        self._progress, self._done = progress, set()
        self._total = 0

    def on_start(self, event):
        if not self._total and _own(event.data["dispatcher"]):
            self._total = max(len(_functions()), 1)
            self._progress(0.0)

    def on_end(self, event):
        function = event.data["dispatcher"]
        if self._total and _own(function):
            # One that is compiled for other types again is not another one.
            self._done.add(id(function))
            self._progress(min(len(self._done) / self._total, 1.0))


def _own(function):
    return function.py_func.__module__.startswith(_PACKAGE)


def _functions():
    """Return the identities of all functions of the package that are there to be compiled."""
    modules = [module for name, module in sys.modules.items() if name.startswith(_PACKAGE)]
    values = (value for module in modules for value in vars(module).values())
    return {id(value) for value in values if isinstance(value, Dispatcher)}
