"""
Which mutant is on: a number that compiled code reads at run time, 0 for none.

`benchmarks.mutations.copies` puts this file into a copy of the package. Compiled code reads the
number from a place in memory that each process fills from its environment. Were it a constant,
each number would be compiled anew.
"""

import ctypes
import os

import llvmlite.binding as llvm
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, overload

VARIABLE = "PEG_ON_HOLE_MUTATION"
SYMBOL = "peg_on_hole_mutation"
_number = ctypes.c_int64(int(os.environ.get(VARIABLE, "0")))
llvm.add_symbol(SYMBOL, ctypes.addressof(_number))


def mutation() -> int:
    """Return the number of the mutant that is on."""
    return _number.value


@intrinsic
def _load(typing_context):
    def generate(context, builder, signature, arguments):
        module = builder.module
        if SYMBOL in module.globals:
            place = module.get_global(SYMBOL)
        else:
            place = ir.GlobalVariable(module, ir.IntType(64), SYMBOL)
            place.linkage = "external"
        return builder.load(place)

    return types.int64(), generate


@overload(mutation)
def _mutation_in_compiled_code():
    return lambda: _load()
