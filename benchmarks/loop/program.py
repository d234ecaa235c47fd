"""The program of the example, as a module; needs no MuJoCo."""

import importlib.util
from pathlib import Path
from types import ModuleType


def program_module() -> ModuleType:
    """Return examples/insert.py as a module."""
    path = Path(__file__).parents[2] / "examples" / "insert.py"
    spec = importlib.util.spec_from_file_location("insert_example", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
