"""Drawn insertions down the hole, and another engine's."""
