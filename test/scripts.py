"""Scripts beside the package, as modules."""

import importlib.util


def loaded(path):
    """Return a module that is no part of the package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
