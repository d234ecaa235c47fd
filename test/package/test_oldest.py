"""What `make test-oldest` installs is the oldest that setup.py allows."""

import runpy
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[2]
TOOL = runpy.run_path(str(ROOT / "tools" / "oldest.py"))


def test_each_dependency_of_users_is_held_at_its_bound():
    stated = TOOL["stated"](ROOT / "setup.py")
    held = {line.name: line for line in map(Requirement, TOOL["requirements"](ROOT / "setup.py"))}
    users = [Requirement(line) for line in stated[""] + stated["report"]]
    assert len(users) >= 8
    for requirement in users:
        (bound,) = requirement.specifier
        lowest = Version(bound.version)
        newer = Version(f"{lowest.major}.{lowest.minor + 1}")
        allowed = held[requirement.name].specifier
        assert bound.operator == ">=" and lowest in allowed and newer not in allowed


def test_ros_is_jazzy_s_and_of_kilted_nothing_is_left():
    names = [Requirement(line).name for line in TOOL["requirements"](ROOT / "setup.py")]
    stated = TOOL["stated"](ROOT / "setup.py")["ros"]
    assert sum(name.startswith("ros-jazzy-") for name in names) == len(stated) > 0
    assert not any("kilted" in name for name in names)
