"""The lock file holds all that setup.py asks for, each release by its hashes."""

import re
import runpy
from pathlib import Path

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
