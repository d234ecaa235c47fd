"""Rigid-body mechanics of a peg on the rim of a hole: geometry, contacts, equations of motion."""
