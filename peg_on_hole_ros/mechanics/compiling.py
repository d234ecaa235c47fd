"""
How functions are compiled.

With a numba that is known here, a compiled function becomes machine code as a part of the one
that Python calls (`compiled_parts`), which saves a third of the time that compiling takes: 180 for
270 s of CPU. With any other numba, the public `numba.njit` compiles the same functions.
"""

from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

import numba

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

# The first numba whose private classes `compiled_parts` has not been tested with.
FIRST_UNTESTED_NUMBA = (0, 69)
IN_PARTS = tuple(int(part) for part in numba.__version__.split(".")[:2]) < FIRST_UNTESTED_NUMBA


def compiled(
    function: Callable[Parameters, Result], **options: Any
) -> Callable[Parameters, Result]:
    """
    Return a function, compiled when it is first called with arguments of a kind.

    What divides by zero gives infinity or NaN, as numpy does: below gamma0 the equations give NaN,
    which the step rejects.
    """
    options = {"nopython": True, "error_model": "numpy", **options}
    if IN_PARTS:
        from peg_on_hole_ros.mechanics.compiled_parts import compiled_in_parts

        return compiled_in_parts(function, options)
    by_numba: Any = numba.jit(cache=True, **options)
    plain: Callable[Parameters, Result] = by_numba(function)
    return plain


def inlined(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Return a compiled function for the bodies of loops that shall become vector instructions."""
    return compiled(function, forceinline=True)
