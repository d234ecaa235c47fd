"""A bag run through the stream that the node runs, and what is said of it."""
