"""What all benchmarks share: how members run, are played and scored, and what is written."""
