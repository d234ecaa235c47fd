"""Which messages a replay uses, by the pipeline's own rules of order, without an estimate."""

from collections import Counter
from collections.abc import Callable

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.engine.processing import LOST
from peg_on_hole_ros.messages.stream import MessageStream

_STATE = ("t_ns", "_oriented_ns", "_lost")


def rehearsal(configuration: Configuration, orientation: Callable) -> MessageStream:
    """
    Return a stream that counts what becomes of messages, and gives nothing out.

    It takes every orientation for usable: what a replay gates (`joints_gated`) it counts as used.

    Parameters
    ----------
    configuration : Configuration
    orientation : callable
        From a JointSample to an AngleMeasurement, or to the reason why there is none.

    """
    pipeline = Pipeline(configuration, orientation)
    pipeline.processor = _OrderOnly(configuration)  # type: ignore[assignment]
    return MessageStream(configuration, pipeline, 0.0)


class _OrderOnly:
    """Stands where the processor does, and keeps of it how far the stamps have come."""

    wrench_stands_still = False

    def __init__(self, configuration):
        delay_ns = max(round(configuration.joints.delay * 1e9), 0)
        lost = max(LOST, configuration.filter.max_joint_gap)
        self._lost_ns = round(lost * 1e9) + delay_ns
        self.counts: Counter[str] = Counter()
        self.restart()

    def restart(self):
        self.t_ns = self._oriented_ns = None
        self._lost = False

    def forget(self):
        pass

    @property
    def oriented(self):
        return self.t_ns is not None and not self._lost

    def tare(self, samples):
        return []

    def start(self, measurement):
        self.t_ns = measurement.t_ns
        self.correct(measurement)

    def correct(self, measurement, lateness=0.0):
        self._oriented_ns, self._lost = self.t_ns, False
        self.counts["joints_used"] += 1

    def process(self, unit):
        for measurement in unit.joints:
            self._advance(measurement.t_ns)
            self.correct(measurement)
        self._advance(unit.wrench.t_ns)
        self.counts["wrench_dropped_without_orientation" if self._lost else "wrench_used"] += 1
        for measurement in unit.after:
            self.correct(measurement)

    def _advance(self, t_ns):
        self.t_ns = t_ns
        self._lost |= t_ns - self._oriented_ns > self._lost_ns

    def snapshot(self):
        return [getattr(self, name) for name in _STATE], Counter(self.counts)

    def restore(self, snapshot):
        state, counts = snapshot
        vars(self).update(zip(_STATE, state))
        self.counts = Counter(counts)
