"""How far the contact dynamics are trusted: what the compiled filter is given of it."""

from typing import NamedTuple


class Process(NamedTuple):
    """
    How far the contact dynamics are trusted.

    Attributes
    ----------
    max_step : float
        Longest integration step [s].
    rate_density : float
        Spectral density of the random walk added to each rate [rad^2/s^3].
    slip_velocity_scale, slip_widening : float
        See `friction_scales` [m/s], [-].
    friction_density : float
        Spectral density of the random walk of the friction coefficient [1/s].
    slow_slip : float
        See `slip.slow_slip` [-].
    wrench_jump : float
        Share of what `hold_wrench` says of a jump that counts [-].
    slow_rate_noise : float
        Random walk of rates that change in `bridging.bridge`, at least [rad/s^1.5].

    """

    max_step: float
    rate_density: float
    slip_velocity_scale: float
    slip_widening: float
    friction_density: float
    slow_slip: float
    wrench_jump: float
    slow_rate_noise: float
