"""From samples of the sensors to measurements: axes, noise, repeats, innovations."""
