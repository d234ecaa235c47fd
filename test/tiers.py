"""Which members of a family of tests run at every push, and which at night."""

import pytest


def nightly(*cases):
    """Return cases for `parametrize`, marked; a tuple is one case of several values."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.nightly)
        for case in cases
    ]


def at_push(chosen, cases):
    """Return all cases for `parametrize`: but for those chosen they are nightly."""
    return [case if case in chosen else nightly(case)[0] for case in cases]
