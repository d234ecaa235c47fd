"""How commands and node start and end: compiling, first use, errors on one line."""
