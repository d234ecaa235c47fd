"""Contact-state estimation for a cylindrical peg being set on a hole."""

__version__ = "0.1.0"
