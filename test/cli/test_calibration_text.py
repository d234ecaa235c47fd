"""What a calibration says of what it did not see: true of the recording, and no more asked for."""

from peg_on_hole_ros.cli.calibration_text import not_seen
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.calibration import CalibratedParameter, Calibration

UNSEEN = CalibratedParameter("clearance", "m", 1e-4, 1e-4, 7e-5, 1.5e-4, 1e-4, False, "")


def said(least_tilt, both_ways):
    found = Calibration(
        Configuration(), (UNSEEN,), 3.0, 3.0, 0.0, 0.0, 300, 0.6, least_tilt, 1.15, both_ways
    )
    (line,) = not_seen(found)
    return line
