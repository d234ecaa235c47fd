"""A held peg on a hole: smooth motion as the process, the six equations as a measurement."""
