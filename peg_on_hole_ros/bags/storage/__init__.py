"""Files of bags: what they hold, in blocks of messages, and how these become arrays."""
