"""The node's surroundings: parameters, diagnostics, DDS on this machine."""
