"""Robot cells in MuJoCo: an arm with soft joints sets the peg on the hole and inserts it."""
