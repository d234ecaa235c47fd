"""Errors and coverage over grids of motions, noise, pegs and wrong settings."""
