"""Compiled code is kept where the present sources' is, and never taken from others."""

import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from peg_on_hole_ros import numba_cache
from simulated import ROOT

SAY = "import peg_on_hole_ros, os; print(os.environ['NUMBA_CACHE_DIR'])"


def chosen(source=ROOT, code=SAY, **environment):
    kept = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**kept, "PYTHONPATH": str(source), **environment},
        cwd="/",
        capture_output=True,
        text=True,
        check=True,
    )
    return Path(done.stdout.strip())


def test_users_cache_is_the_place_outside_make(tmp_path):
    key = numba_cache.source_key()
    found = chosen(XDG_CACHE_HOME=str(tmp_path))
    assert found == tmp_path / "peg_on_hole_ros" / key
    assert found.is_dir()
    assert chosen(HOME=str(tmp_path)) == tmp_path / ".cache" / "peg_on_hole_ros" / key


def test_numba_is_given_the_place_and_uses_it(tmp_path):
    code = (
        "import numba, peg_on_hole_ros\n"
        "from peg_on_hole_ros.mechanics.kernel import determinant_at\n"
        "print(determinant_at.stats.cache_path)"
    )
    found = chosen(code=code, XDG_CACHE_HOME=str(tmp_path))
    assert found.is_relative_to(tmp_path / "peg_on_hole_ros" / numba_cache.source_key())


def test_what_the_environment_says_comes_first_and_a_child_agrees(tmp_path):
    found = chosen(NUMBA_CACHE_DIR=str(tmp_path / "here"))
    assert found == tmp_path / "here" / numba_cache.source_key()
    assert chosen(NUMBA_CACHE_DIR=str(found)) == found


def test_without_a_writable_home_a_private_temporary_folder_is_taken(tmp_path):
    (tmp_path / "file").write_text("")
    tmp = tmp_path / "tmp"
    tmp.mkdir()
    environment = {"XDG_CACHE_HOME": str(tmp_path / "file"), "TMPDIR": str(tmp)}
    found = chosen(**environment)
    assert found.parent.parent == tmp
    assert stat.S_IMODE(found.parent.stat().st_mode) == 0o700
    assert chosen(**environment) == found


def test_a_temporary_folder_that_is_a_link_is_not_trusted(tmp_path):
    (tmp_path / "file").write_text("")
    tmp, elsewhere = tmp_path / "tmp", tmp_path / "elsewhere"
    tmp.mkdir()
    elsewhere.mkdir()
    (tmp / f"peg_on_hole_ros_{os.getuid()}").symlink_to(elsewhere)
    found = chosen(XDG_CACHE_HOME=str(tmp_path / "file"), TMPDIR=str(tmp))
    assert found.parent == tmp and list(elsewhere.iterdir()) == []


@pytest.mark.parametrize("edited", ["mechanics/generated.py", "estimator/wrench_update.py"])
def test_an_edit_of_any_source_moves_the_cache(tmp_path, edited):
    copy = tmp_path / "copy"
    shutil.copytree(
        ROOT / "peg_on_hole_ros",
        copy / "peg_on_hole_ros",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    cache = {"XDG_CACHE_HOME": str(tmp_path)}
    assert chosen(copy, **cache) == chosen(**cache)
    with (copy / "peg_on_hole_ros" / edited).open("a") as file:
        file.write("# edited\n")
    assert chosen(copy, **cache) != chosen(**cache)
