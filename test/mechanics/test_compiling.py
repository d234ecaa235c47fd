"""Compiled code works with the numba that is known, and with one that is not."""

import os
import subprocess
import sys

import numba
import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.mechanics.compiling import FIRST_UNTESTED_NUMBA, IN_PARTS

# Orientations of two peg joints, through functions that call one another; one is refused.
SCRIPT = """
import numba
numba.__version__ = {version!r}
import numpy as np
from peg_on_hole_ros.config.options import JointInput
from peg_on_hole_ros.measurements.orientation import PegJoints
from peg_on_hole_ros.mechanics.compiling import IN_PARTS
angles = np.array([[0.3, 1.0, 2.0], [2.0, 0.0, 0.0]])
found = PegJoints(JointInput()).rows(("gamma", "psi", "phi"), angles)
print(IN_PARTS, found.outcome.tolist(), found.rows[0, :5].tolist())
"""


def answer(version, cache):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-c", SCRIPT.format(version=version)],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    ).stdout.split(" ", 1)


def test_the_numba_that_is_installed_is_one_that_is_known():
    """Compiling takes half as long again: test with it, and move FIRST_UNTESTED_NUMBA."""
    assert IN_PARTS, f"numba {numba.__version__} is not below {FIRST_UNTESTED_NUMBA}"


@pytest.mark.parametrize("version", ["99.0.1"])
def test_a_numba_that_is_not_known_compiles_the_same(version, tmp_path):
    in_parts, expected = answer(numba.__version__, tmp_path / "known")
    plain, found = answer(version, tmp_path / "unknown")
    assert (in_parts, plain) == ("True", "False")
    assert found == expected
    assert expected.startswith("[0, 3] [0.3, 1.0, 2.0, ")


# A process that keeps the code of a function: what it writes is delayed as a busy machine does.
ADDING = """
import sys, time
from numba.core.caching import IndexDataCacheFile
def after(seconds, function):
    def delayed(*args):
        time.sleep(seconds)
        return function(*args)
    return delayed
kind, by_index, by_data = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
IndexDataCacheFile._save_index = after(by_index, IndexDataCacheFile._save_index)
IndexDataCacheFile._save_data = after(by_data, IndexDataCacheFile._save_data)
sys.path.insert(0, {folder!r})
from halved import halved
kinds = dict(int=[7], float=[7.5], both=[7, 7.5])[kind]
print([halved(x) for x in kinds])
"""


def test_processes_that_keep_compiled_code_at_once_leave_each_its_own(tmp_path):
    """Without a lock both write the file that the index names first."""
    (tmp_path / "halved.py").write_text(
        "from peg_on_hole_ros.mechanics.compiling import compiled\n\n\n"
        "@compiled\ndef halved(x):\n    return x / 2 if x > 8 else x * 3\n"
    )
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    script = ADDING.format(folder=str(tmp_path))

    def start(*arguments):
        command = [sys.executable, "-c", script, *arguments]
        return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)

    # Both see an empty index; the code of the first is written last.
    for process in [start("int", "3", "6"), start("float", "5", "0")]:
        process.communicate()
    found = start("both", "0", "0")
    assert found.communicate()[0].strip() == "[21.0, 22.5]"
    assert found.returncode == 0
