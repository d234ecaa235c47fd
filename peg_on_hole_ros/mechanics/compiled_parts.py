"""
Machine code of those functions alone that Python calls, by private classes of numba.

Nothing but `compiling` imports this, and only with a numba that it is known to work with.

numba makes machine code of every function by itself, and once more within each that calls it;
of some three hundred functions that takes most of the time that compiling does. Here a function
that another compiled one calls is handed on as it is, and becomes machine code as a part of the
one that Python calls.
"""

import fcntl
from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import NativeLowering

from peg_on_hole_ros.mechanics.compiling import Parameters, Result


class _Part(JITCodeLibrary):
    """Code that is linked into that of a caller, and is not run by itself."""

    def finalize(self):
        """Gather the code of all that it calls."""
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalize_dynamic_globals()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(NativeLowering):
    _name = "peg_on_hole_lower_part"

    def run_pass(self, state):
        codegen = state.targetctx.codegen()
        state.library = _Part(codegen, state.func_id.func_qualname)
        super().run_pass(state)
        # There is no address to know it by.
        key = object()
        state.targetctx.insert_user_function(key, state.cr.fndesc, [state.library])
        state["cr"] = state.cr._replace(cfunc=key)
        return True


class _PartCompiler(CompilerBase):
    def define_pipelines(self):
        flags = self.state.flags
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (_LowerPart if each is NativeLowering else each, said) for each, said in passes.passes
        ]
        passes.finalize()
        return [passes]


class _PartDispatcher(CPUDispatcher):
    def get_call_template(self, args, kws):
        # One for all numbers: else each literal would be a kind of its own.
        args = tuple(types.unliteral(each) for each in args)
        kws = {name: types.unliteral(each) for name, each in kws.items()}
        return super().get_call_template(args, kws)

    def add_overload(self, cres):
        self.overloads[tuple(cres.signature.args)] = cres


class _LockedCache(FunctionCache):
    """
    Kept machine code, to which one process at a time adds.

    numba numbers its files by an index that it reads first and writes afterwards: two processes
    that add kinds of arguments of one function at once choose the same file, and the code of one
    is then run with the arguments of the other.
    """

    def save_overload(self, sig, data):
        self._impl.locator.ensure_cache_path()
        with open(f"{self.cache_path}/lock", "w") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            super().save_overload(sig, data)


class _Dispatcher(CPUDispatcher):
    """Called by Python it is a function like any of numba's; compiled code calls its part."""

    part: Any
    _cache: FunctionCache

    def get_call_template(self, args, kws):
        return self.part.get_call_template(args, kws)

    def get_overload(self, sig):
        return self.part.get_overload(sig)


def compiled_in_parts(
    function: Callable[Parameters, Result], options: dict[str, Any]
) -> Callable[Parameters, Result]:
    """Return a function that is compiled with all that it calls, by numba's options."""
    dispatcher = _Dispatcher(function, targetoptions=options | {"no_cfunc_wrapper": True})
    dispatcher.part = _PartDispatcher(
        function, targetoptions=options, pipeline_class=_PartCompiler
    )
    dispatcher._cache = _LockedCache(function)
    return dispatcher
