"""The readable model: the filter in plain numpy on filterpy, held against the kernel."""
