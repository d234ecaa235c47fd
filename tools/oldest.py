"""
Print requirements for pip that hold every dependency at the oldest release that setup.py allows.

`make test-oldest` installs them, beside the wheels of ROS 2 Jazzy in place of Kilted, so that what
setup.py promises is tested and not hoped for. Run it from the root of the checkout.
"""

import re
import sys
from pathlib import Path

import setuptools

# Tests need the newest of these, users none.
UNBOUND = ("test", "dev")
# The URDF library's one version that is stated is not for the oldest numpy; of a table and a
# cluster only what has not changed in years is used.
WITHOUT = ("urdf", "parquet", "cluster", "docs")


def stated(setup_py: Path) -> dict[str, list[str]]:
    """Return the requirements that a setup.py states, by extra; "" has those of all users."""
    told = {}
    setup, setuptools.setup = setuptools.setup, told.update
    try:
        exec(compile(setup_py.read_text(), str(setup_py), "exec"), {"__name__": "__main__"})
    finally:
        setuptools.setup = setup
    return {"": told["install_requires"], **told["extras_require"]}


def oldest(requirement: str) -> str:
    """Return a requirement held at its lower bound, the newest release for repairs of that."""
    name, bound = re.fullmatch(r"([\w-]+)>=([\d.]+)", requirement).groups()
    minor = bound if "." in bound else f"{bound}.0"
    return f"{name}=={minor}" if minor.count(".") > 1 else f"{name}=={minor}.*"


def requirements(setup_py: Path) -> list[str]:
    """Return the lines for pip."""
    lines = []
    for extra, names in stated(setup_py).items():
        if extra == "ros":
            lines += [name.split("==")[0].replace("kilted", "jazzy") for name in names]
        elif extra in UNBOUND:
            lines += names
        elif extra not in WITHOUT:
            lines += [oldest(name) for name in names]
    return lines


if __name__ == "__main__":
    sys.stdout.write("\n".join(requirements(Path("setup.py"))) + "\n")
