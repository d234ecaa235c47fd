"""The kernel translated to C: what the same step could cost at best."""
