"""Filters on one interface, and what they say of a prediction and a correction."""
