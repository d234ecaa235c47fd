"""The motion that does not jam: rates of closing, slip and slide that keep loads under limits."""
