"""Ctrl-C where compiled code is loaded: C that would lose it is left first."""

import signal
import time

import pytest

from peg_on_hole_ros.startup.exit_codes import INTERRUPTED, exit_code
from peg_on_hole_ros.startup.interrupt import SIGNALS, ended_by_signals, note_signals

NUMBA = {"__name__": "numba.core.made_up"}
exec("def call(act):\n    act()", NUMBA)  # noqa: S102


@pytest.mark.parametrize("number", SIGNALS)
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


@pytest.mark.parametrize("number", SIGNALS)
def test_what_was_ignored_at_the_start_ends_it_too(number):
    """A script ignores SIGINT for what it starts in the background."""
    before = signal.signal(number, signal.SIG_IGN)
    try:
        with pytest.raises(KeyboardInterrupt), ended_by_signals():
            signal.raise_signal(number)
            pytest.fail("nothing was raised")
        assert signal.getsignal(number) is signal.SIG_IGN
        with ended_by_signals():
            noted = note_signals()
            signal.raise_signal(number)
            assert noted == [number]
        assert signal.getsignal(number) is signal.SIG_IGN
    finally:
        signal.signal(number, before)


@pytest.mark.parametrize("number", SIGNALS)
def test_a_program_that_calls_keeps_its_handler(number):
    came = []
    before = signal.signal(number, lambda *_: came.append(number))
    try:
        with ended_by_signals():
            noted = note_signals()
            signal.raise_signal(number)
        assert came == [number] and noted == []
    finally:
        signal.signal(number, before)


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
