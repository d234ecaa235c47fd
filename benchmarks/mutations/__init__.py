"""Mutants of the package, all compiled at once: which of them no test notices."""
