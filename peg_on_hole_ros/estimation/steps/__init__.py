"""Integration steps of the six equations."""
