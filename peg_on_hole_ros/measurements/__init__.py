"""What sensors say, as measurements: axes, noise, repeats, innovations."""
