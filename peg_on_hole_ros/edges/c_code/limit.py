"""The filter step as C, compiled by the machine's own compiler: the fastest that it could be."""

import ctypes
import platform
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from peg_on_hole_ros.edges.c_code.translation import (
    D,
    I,
    Matrix,
    P,
    Translation,
    TranslationError,
)
from peg_on_hole_ros.mechanics.kernel import WIDTH
from peg_on_hole_ros.study.step_loop import run_steps

COMPILER = "gcc"
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-std=gnu11", "-shared", "-fPIC")
_DOUBLES = np.ctypeslib.ndpointer(dtype=float, flags="C_CONTIGUOUS")


def source() -> str:
    """Return the C source of `study.step_loop.run_steps`, entry point `run`."""
    translation = Translation()
    kinds = [P, Matrix(WIDTH), Matrix(WIDTH), D, I, P, P, P, D, D]
    name, _ = translation.add(run_steps, kinds)
    listed = ", ".join(f"{translation.c_type(kind)} a{i}" for i, kind in enumerate(kinds))
    passed = ", ".join(f"a{i}" for i in range(len(kinds)))
    return f"{translation.text()}\nlong run({listed})\n{{\n    return {name}({passed});\n}}\n"


def compiler() -> str | None:
    """Return why there is no C limit on this machine, or None if there is."""
    if shutil.which(COMPILER) is None:
        return f"no {COMPILER} on this machine"
    if platform.system() != "Linux":
        return f"shared libraries are built on Linux only, and this is {platform.system()}"
    return None


def build(flags=FLAGS):
    """
    Compile the step and return it as a function with the arguments of `run_steps`.

    Returns
    -------
    callable or None
    text : str
        The command, or why there is none.

    """
    missing = compiler()
    if missing:
        return None, missing
    try:
        text = source()
    except TranslationError as error:
        return None, f"the step is not translated: {error}"
    with tempfile.TemporaryDirectory(prefix="peg_on_hole_c_") as folder:
        path, library = Path(folder) / "step.c", Path(folder) / "step.so"
        path.write_text(text, encoding="utf-8")
        command = [COMPILER, *flags, str(path), "-o", str(library), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return None, f"{COMPILER} failed: {done.stderr.splitlines()[0]}"
        # The library stays mapped when its file goes.
        run = ctypes.CDLL(str(library)).run
    run.restype = ctypes.c_long
    counted = [ctypes.c_double, ctypes.c_long]
    run.argtypes = [*[_DOUBLES] * 3, *counted, *[_DOUBLES] * 3, *[ctypes.c_double] * 2]
    return run, " ".join([COMPILER, *flags])
