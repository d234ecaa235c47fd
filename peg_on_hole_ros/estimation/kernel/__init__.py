"""The compiled kernel: scalar code that works in one flat memory."""
