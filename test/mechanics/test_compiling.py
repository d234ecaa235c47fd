"""Compiled code works with the numba that is known, and with one that is not."""

import os
import subprocess
import sys

import numba
import pytest

from cli_helpers import ROOT
from peg_on_hole_ros.mechanics.compiling import FIRST_UNKNOWN, IN_PARTS

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
    """Otherwise compiling takes half as long again: test with it, and move FIRST_UNKNOWN."""
    assert IN_PARTS, f"numba {numba.__version__} is not below {FIRST_UNKNOWN}"


@pytest.mark.parametrize("version", ["99.0.1"])
def test_a_numba_that_is_not_known_compiles_the_same(version, tmp_path):
    in_parts, expected = answer(numba.__version__, tmp_path / "known")
    plain, found = answer(version, tmp_path / "unknown")
    assert (in_parts, plain) == ("True", "False")
    assert found == expected
    assert expected.startswith("[0, 3] [0.3, 1.0, 2.0, ")
