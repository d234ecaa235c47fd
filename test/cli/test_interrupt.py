"""Ctrl-C where compiled code is loaded: C that would lose it is left first."""

import signal
import time

import pytest

from peg_on_hole_ros.startup.interrupt import ended_by_signals
from peg_on_hole_ros.startup.one_line import INTERRUPTED, exit_code

NUMBA = {"__name__": "numba.core.made_up"}
exec("def call(act):\n    act()", NUMBA)  # noqa: S102


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_comes_once_numba_is_left(number):
    left = False
    with pytest.raises(KeyboardInterrupt), ended_by_signals():
        NUMBA["call"](lambda: signal.raise_signal(number))
        left = True
        time.sleep(10.0)
    assert left


def test_elsewhere_it_comes_at_once():
    with pytest.raises(KeyboardInterrupt), ended_by_signals():
        signal.raise_signal(signal.SIGTERM)
        pytest.fail("nothing was raised")
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_compiling_that_lasts_is_ended_all_the_same():
    def lasts():
        signal.raise_signal(signal.SIGINT)
        end = time.monotonic() + 60.0
        while time.monotonic() < end:
            time.sleep(0.01)
        pytest.fail("nothing was raised")

    with pytest.raises(KeyboardInterrupt), ended_by_signals():
        NUMBA["call"](lasts)


def test_what_c_went_on_with_is_no_fault_of_the_program():
    def act():
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    assert exit_code(act) == INTERRUPTED
