"""MCAP bags: reading, writing, and what is read back from them."""
