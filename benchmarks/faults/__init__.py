"""Faults put into recordings, and what comes of them."""
