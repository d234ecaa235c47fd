"""What the monitor goes by: its options, and what of scene and sensor it needs, as a record."""

from math import sqrt

import numpy as np

from peg_on_hole_ros.config.options import MonitorOptions
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.tuned import PLACE_CHECK, TRANSITION_FLAG
from peg_on_hole_ros.typed_record import Floats, Record, Vector3, dtype_of, new


class MonitorSettings(Record):
    """
    The options of `MonitorOptions` that compiled code needs, by their names, and a few more.

    Attributes
    ----------
    forecast_clearance_stddev : float
        The least standard deviation of the clearance in a forecast [m].
    force_stddev : float
        Standard deviation of a force that the rim carries, by the noise of a wrench [N].
    peg_diameter, hole_diameter, peg_height : float
        As stated [m].
    around : float
        What stands around the hole may be higher than the throat by so much, with the peg's
        chamfer below its shoulder [m].

    """

    contact_force_threshold: float
    mode_change_rate: float
    evidence_time: float
    rest_rate: float
    free_acceleration: float
    forecast_acceleration_stddev: float
    forecast_acceleration_time: float
    singular_band: float
    inserted_depth: float
    jamming_horizon: float
    load_horizon: float
    max_normal: Vector3
    mode_dwell: float
    mode_probability_on: float
    mode_probability_off: float
    transition_probability_on: float
    transition_probability_off: float
    transition_hold: float
    jamming_warn: float
    jamming_error: float
    alarm_hysteresis: float
    alarm_dwell: float
    alarm_hold: float
    forecast_clearance_stddev: float
    force_stddev: float
    peg_diameter: float
    hole_diameter: float
    peg_height: float
    around: float


def monitor_settings(
    options: MonitorOptions, scene: Scene, force_stddev: float
) -> MonitorSettings:
    """Return the settings for compiled code, with the noise of a carried force [N]."""
    settings = new(MonitorSettings)
    for name in dtype_of(MonitorSettings).names or ():
        if hasattr(options, name):
            setattr(settings, name, getattr(options, name))
    settings.forecast_clearance_stddev = TRANSITION_FLAG.clearance_share * scene.clearance_stddev
    settings.force_stddev = force_stddev
    settings.peg_diameter, settings.hole_diameter = scene.peg_diameter, scene.hole_diameter
    settings.peg_height = scene.peg_height
    settings.around = PLACE_CHECK.around + scene.hole_chamfer + scene.peg_chamfer
    return settings


def force_noise(scene: Scene, wrench_covariance: Floats) -> float:
    """Return the standard deviation of a force that the rim carries, by the wrench's noise [N]."""
    noise = np.diagonal(wrench_covariance)
    over_radius = 2 / scene.peg_diameter
    return sqrt(noise[:3].max() + noise[3:].max() * over_radius**2)
