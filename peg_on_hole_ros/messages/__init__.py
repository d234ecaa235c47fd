"""Messages: what is decoded, and what is made of an estimate."""
