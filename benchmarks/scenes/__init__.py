"""Drawn insertion scenes, and how transition, modes and alarms are scored over them."""
