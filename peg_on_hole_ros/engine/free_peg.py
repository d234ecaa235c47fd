"""Whether a peg hangs free and still, as a tare needs it, by its last outputs."""

from collections.abc import Sequence
from math import cos, hypot, sqrt

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.processor import Processor
from peg_on_hole_ros.engine.tuned import TARE
from peg_on_hole_ros.mechanics.linear_algebra import FORCE, TORQUE
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.states import MODES, Mode
from peg_on_hole_ros.number_text import number, quantity
from peg_on_hole_ros.records import WrenchSample

FREE = Mode.OPEN.name.lower()
TOUCHING = tuple(mode for mode in MODES if mode not in (FREE, Mode.UNKNOWN.name.lower()))


def why_not_free(
    outputs: OutputView | None,
    samples: Sequence[WrenchSample],
    processor: Processor,
    unsure: bool,
    payload_unknown: bool = False,
    zero_open_ns: int = 0,
) -> str:
    """
    Return why a peg is not shown to hang free and still; empty: it is.

    A free peg is shown by a contact mode that has been `open` for `TARE.least_ns`, or by a reading
    that is its weight and a plausible zero, or by one that has stayed for `TARE.untaken_ns` from
    the start on, where nobody had taken a zero; that it is still, by joint states.

    Parameters
    ----------
    outputs : OutputView or None
        The last; None: there is none.
    samples : sequence of WrenchSample
        The latest, from `TARE.least_ns` on.
    processor : Processor
        Its estimate is that after the last of them.
    unsure : bool
        Whether the wrench seems to mean something else than is stated, such as another unit.
    payload_unknown : bool
        Whether any payload may hang below the sensor. The contact mode is then no evidence of
        contact: it rests on the payload that is stated.
    zero_open_ns : int
        For how long the reading may have been a zero that nobody has taken [ns].

    """
    if outputs is None:
        return "there is no estimate at the last wrench"
    mode = outputs.contact_mode
    if mode in TOUCHING and not payload_unknown:
        return f"the peg touches, contact mode {mode}"
    moves = why_turning(outputs, processor.configuration)
    if moves:
        return moves
    lacking = _not_still(outputs, processor)
    open_ns = outputs.t_ns - processor.open_since * 1e9
    if not lacking and mode == FREE and open_ns >= TARE.least_ns:
        return ""
    if not lacking and zero_open_ns >= TARE.untaken_ns and processor.standing is None:
        return ""
    if unsure and not payload_unknown:
        return (
            f"the peg may touch, contact mode {mode}: the wrench contradicts its settings "
            "(/diagnostics)"
        )
    lacking = lacking or _not_its_weight(samples, processor, payload_unknown)
    if not lacking:
        return ""
    return f"no measurement shows a free and still peg: contact mode {mode}, and {lacking}"


def _not_still(outputs, processor):
    """Return why nothing shows that the peg is still, or nothing."""
    if processor.is_blind:
        return "joint states do not show how it hangs: they have a gap, or do not change"
    spread = rates_stddev(outputs)
    if not spread < TARE.most_rates_stddev:
        return (
            "too few joint states show that it is still: its speed is known to "
            f"{quantity(spread, 'rad/s', 2)}, and {quantity(TARE.most_rates_stddev, 'rad/s')} is "
            "needed"
        )
    return ""


def _not_its_weight(samples, processor, payload_unknown):
    """Return why the reading is not that of a weight and a plausible zero, or nothing."""
    if processor.standing is not None or processor.is_saturated:
        return "the wrench does not change, or is at the end of its range"
    rows = np.array([[*sample.force, *sample.torque] for sample in samples])
    parts = np.array_split(rows, TARE.parts)
    zeros = np.array([processor.zero_of(part.mean(axis=0)) for part in parts])
    limits = plausible_zero(processor.configuration, len(parts[-1]))
    reduction, worst, away = processor.reduction, np.inf, np.zeros(6)
    for known in (reduction.stated, reduction.tare):
        off = zeros - known
        if payload_unknown:
            off = _without_payload(off, processor)
        shares = np.abs(off / limits).max(axis=1)
        if shares.max() < worst:
            worst, away = shares.max(), reduction.sign * off[shares.argmax()]
    if worst <= 1.0:
        return ""
    force, torque = (", ".join(number(x) for x in each) for each in (away[:3], away[3:]))
    return (
        f"the sensor reads [{force}] N, [{torque}] N m beside the weight and the stated bias, and "
        f"no more than {quantity(limits[FORCE], 'N')} and {quantity(limits[TORQUE], 'N m')} are "
        "plausible (wrench.bias_force_stddev, wrench.bias_torque_stddev)"
    )


def plausible_zero(configuration: Configuration, count: int) -> np.ndarray:
    """
    Return how far a measured zero may plausibly be from the stated one, shape (6,).

    By what is stated of the zero, by the noise of the mean, and by what is no contact anywhere: a
    force below `monitor.contact_force_threshold`, at the peg's lower end.

    Parameters
    ----------
    configuration : Configuration
    count : int
        Of how many wrenches the mean is.

    """
    wrench, force = configuration.wrench, configuration.monitor.contact_force_threshold
    reach = float(np.linalg.norm(wrench.sensor_xyz)) + 0.5 * configuration.scene.peg_diameter
    spreads = (
        hypot(wrench.bias_force_stddev, wrench.force_stddev / sqrt(count)),
        hypot(wrench.bias_torque_stddev, wrench.torque_stddev / sqrt(count)),
    )
    sigmas = TARE.significance
    return np.repeat([force + sigmas * spreads[0], reach * force + sigmas * spreads[1]], 3)


def _without_payload(off, processor):
    """Return zeros (n, 6) without what a payload may be of them; none weighs less than zero."""
    gravity = processor.gravity_in_sensor
    mass = -off[:, :3] @ gravity / (gravity @ gravity)
    mass = np.maximum(mass, -processor.configuration.wrench.payload_mass)
    # Its mass centre is not known, so the torque may be anything.
    return np.hstack([off[:, :3] + mass[:, None] * gravity, np.zeros((len(off), 3))])


def why_turning(outputs: OutputView, configuration: Configuration) -> str:
    """Return what shows that the peg turns, or nothing."""
    speed, stddev = turning_speed(outputs)
    if speed - TARE.significance * stddev > configuration.monitor.rest_rate:
        return f"the peg turns at {quantity(speed, 'rad/s')}, contact mode {outputs.contact_mode}"
    return ""


def turning_speed(outputs: OutputView) -> tuple[float, float]:
    """Return how fast the peg turns about any axis, and the standard deviation of that [rad/s]."""
    rates, metric = outputs.state[3:], _metric(outputs)
    slope = metric @ rates
    speed = sqrt(max(float(rates @ slope), 0.0))
    if not speed:
        return 0.0, 0.0
    variance = float(slope @ outputs.state_covariance[3:, 3:] @ slope) / speed**2
    return speed, sqrt(max(variance, 0.0))


def rates_stddev(outputs: OutputView) -> float:
    """Return how well it is known how fast the peg turns, root mean square [rad/s]."""
    return sqrt(max(float(np.trace(_metric(outputs) @ outputs.state_covariance[3:, 3:])), 0.0))


def _metric(outputs):
    """Return what makes squares of angular velocities of rates: two axes are gamma apart."""
    apart = cos(outputs.state.item(0))
    return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, apart], [0.0, apart, 1.0]])


class FreeFor:
    """
    Whether a peg has hung free and still for long, reported once each time that it does.

    Parameters
    ----------
    configuration : Configuration
        Where `wrench.tare_automatically` is false it is never reported.

    """

    def __init__(self, configuration: Configuration) -> None:
        self._configuration = configuration
        self._since_ns: int | None = None
        self._reported = False

    @property
    def asked(self) -> bool:
        """Whether a tare of a free peg is asked for."""
        return self._configuration.wrench.tare_automatically

    def long(self, outputs: OutputView | None, zero_open_ns: int = 0) -> bool:
        """
        Process the outputs of a wrench; return whether the peg now is free for long enough.

        `zero_open_ns`: for how long its reading may have been a zero that nobody has taken [ns].
        """
        if not self.asked:
            return False
        free = outputs is not None and outputs.contact_mode == FREE
        free = free or zero_open_ns >= TARE.untaken_automatic_ns - TARE.free_ns
        if not free or outputs is None or why_turning(outputs, self._configuration):
            self._since_ns, self._reported = None, False
            return False
        if self._since_ns is None or outputs.t_ns < self._since_ns:
            self._since_ns = outputs.t_ns
        if self._reported or outputs.t_ns - self._since_ns < TARE.free_ns:
            return False
        self._reported = True
        return True
