"""Truth to test estimators against: a compliant holder sets the peg on the hole."""
