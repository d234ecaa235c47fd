"""Cells of one's own, drawn: arm, sensor, peg and hole, and what may be stated wrongly."""
