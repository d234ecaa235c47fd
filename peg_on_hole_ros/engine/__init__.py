"""The engine: what a wrench and its orientations make of the state, as one compiled function."""
