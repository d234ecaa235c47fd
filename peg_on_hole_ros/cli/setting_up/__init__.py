"""What `peg-on-hole setup` does: its steps, questions, recordings and file."""
