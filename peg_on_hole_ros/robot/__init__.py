"""The robot's description: joints, links, and where the sensor sits."""
