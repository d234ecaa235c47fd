"""Mutants that no test can notice, by name, and why."""

JUDGED: dict[str, str] = {}
