"""Contact-state estimation for a cylindrical peg being set on a hole."""

from peg_on_hole_ros.numba_cache import choose_folder

__version__ = "0.1.0"

# Here, because it must be known before anything imports numba.
choose_folder()
