"""How many messages of a bag a replay would use, and why not the others."""

from collections.abc import Callable

import numpy as np

from peg_on_hole_ros.bags.batch import Batch
from peg_on_hole_ros.bags.stamps import StampStatistics
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.messages.decode import Malformed
from peg_on_hole_ros.records import AngleMeasurement
from peg_on_hole_ros.replay.rehearsal import rehearsal
from peg_on_hole_ros.replay.run import fates, hand_over

# What messages are dropped for that another topic, or the order of them, decides.
_OF_ORDER = (
    "before_joints", "after_last_wrench", "without_wrench", "without_orientation", "late",
    "ahead", "restart", "repeated_stamp",
)  # fmt: skip


class WouldUse:
    """
    What a replay would take of a bag, and how many messages are well-formed, with their stamps.

    Parameters
    ----------
    configuration : Configuration
    orientation : callable
        From a JointSample to its orientation, or to the reason why there is none.
    sources : dict of str to str
        Topics that are there, as of `sources_of`.

    Attributes
    ----------
    statistics : dict of str to StampStatistics
    usable : dict of str to int
        Well-formed messages by source.
    stream : MessageStream

    """

    def __init__(
        self,
        configuration: Configuration,
        orientation: Callable,
        sources: dict[str, str],
    ) -> None:
        self._orientation, self._sources = orientation, sources
        self._names = configuration.joints.names
        max_gap = configuration.filter.max_gap
        self.statistics = {topic: StampStatistics(max_gap) for topic in sources}
        self.usable = dict.fromkeys(sources.values(), 0)
        self._oriented = False
        self.stream = rehearsal(configuration, self._measured)

    def _measured(self, sample):
        measurement = self._orientation(sample)
        self._oriented = not isinstance(measurement, str)
        if self._oriented and not isinstance(measurement, AngleMeasurement):
            # Of a robot whose description is not to be had there are only positions.
            measurement = AngleMeasurement(sample.t_ns, np.zeros(3), np.eye(3))
        return measurement

    def add(self, batch: Batch) -> None:
        """Take a batch."""
        kept = {topic: [] for topic in self.statistics}
        for item in batch.items(self._names):
            sample, self._oriented = item.sample, True
            hand_over(self.stream, item, self._sources)
            if item.topic not in kept or isinstance(sample, Malformed) or not self._oriented:
                continue
            self.usable[self._sources[item.topic]] += 1
            kept[item.topic].append((sample.t_ns, item.log_ns))
        for topic, times in kept.items():
            if times:
                self.statistics[topic].add(*np.array(times).T)

    def span(self, topic: str) -> tuple[int, int] | None:
        """Return the least and the greatest stamp of what is well-formed [ns]."""
        return self.statistics[topic].span

    def fates(self, read: dict[str, int]) -> tuple[dict[str, int], dict[str, int]]:
        """Return how many messages a replay uses, and those dropped, by source and by reason."""
        return fates(self.stream.counts, read)[:2]

    def alone(self, read: dict[str, int]) -> tuple[dict[str, int], dict[str, int]]:
        """Return the same where there is no order between the topics to keep to."""
        used, dropped = dict(self.usable), fates(self.stream.counts, read)[1]
        dropped = {name: n for name, n in dropped.items() if not name.endswith(_OF_ORDER)}
        for topic, found in self.statistics.items():
            source = self._sources[topic]
            used[source] -= found.repeated
            if found.repeated:
                dropped[f"{source}_dropped_repeated_stamp"] = found.repeated
        return used, dropped
