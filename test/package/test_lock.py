"""The lock file holds all that setup.py asks for, each release by its hashes."""

import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
TOOL = runpy.run_path(str(ROOT / "tools" / "oldest.py"))
ENTRY = re.compile(
    r"([\w.-]+)==([^\s;]+)(?:\s*;[^\\]*)?((?:\s*\\\n\s+--hash=sha256:[0-9a-f]{64})+)"
)


def locked():
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    found = ENTRY.findall(text)
    left = ENTRY.sub("", text).strip()
    assert left == "", left[:200]
    return {canonicalize_name(name): version for name, version, _ in found}


def test_every_requirement_is_held_within_its_bounds():
    versions = locked()
    assert len(versions) > 60
    for names in TOOL["stated"](ROOT / "setup.py").values():
        for requirement in map(Requirement, names):
            version = versions[canonicalize_name(requirement.name)]
            assert requirement.specifier.contains(version, prereleases=True), requirement


# Stands in for pip-audit, of which nothing is installed: passes over what it cannot audit unless
# it is strict, and takes one release of a package, as that does.
AUDIT = f"""#!{sys.executable}
import pathlib, re, sys
pins = re.findall(r"^([^ ;]+)==([^ ;]+)(.*)", pathlib.Path(sys.argv[-1]).read_text(), re.M)
assert len(dict(pin[:2] for pin in pins)) == len(pins)
assert not any(";" in pin[2] for pin in pins)
with open("audited.txt", "a") as log:
    log.writelines(f"{{name}}=={{release}}\\n" for name, release, _ in pins)
unknown = any(name == "unknown" for name, _, _ in pins)
sys.exit("--strict" in sys.argv and unknown or "vulnerable" in dict(pin[:2] for pin in pins))
"""


@pytest.mark.parametrize(
    ("added", "code"),
    [
        ("", 0),
        ("unknown==1.0 ; sys_platform == 'win32'", 2),
        ("numpy==0.1", 0),
        ("vulnerable==1", 2),
    ],
)
def test_what_is_not_audited_is_an_error(tmp_path, added, code):
    programs = tmp_path / ".venv" / "bin"
    programs.mkdir(parents=True)
    for name, text in (("pip-audit", AUDIT), ("python", "#!/bin/sh\n")):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    for name in ("Makefile", "setup.py"):
        shutil.copy(ROOT / name, tmp_path)
    (tmp_path / ".venv" / ".installed").touch()
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    if added:
        text += f"{added} \\\n    --hash=sha256:{'0' * 64}\n"
    (tmp_path / "requirements.lock").write_text(text, encoding="utf-8")
    done = subprocess.run(["make", "audit"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == code, done.stdout + done.stderr
    audited = (tmp_path / "audited.txt").read_text().split()
    assert sorted(audited) == sorted(re.findall(r"^[^ ;]+==[^ ;]+", text, re.M))
