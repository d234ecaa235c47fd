"""The paper beside the package: its print with its mistakes, its limits, second derivations."""
