"""From a recording: what its parameters are, and which of them it tells."""
