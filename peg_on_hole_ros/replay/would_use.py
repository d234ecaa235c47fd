"""How many messages of a bag a replay would use, and why not the others."""

import numpy as np

from peg_on_hole_ros.bags.batch import Batch, arrivals_of
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.measurements.orientation import JointOrientation
from peg_on_hole_ros.messages.decode import Malformed
from peg_on_hole_ros.messages.stream import MessageStream
from peg_on_hole_ros.replay.run import fates, played
from peg_on_hole_ros.replay.stamp_statistics import StampStatistics

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
    orientation : JointOrientation
        From a JointSample to an AngleMeasurement, or to the reason why there is none.
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
        orientation: JointOrientation,
        sources: dict[str, str],
    ) -> None:
        self._configuration, self._sources = configuration, sources
        max_gap = configuration.filter.max_gap
        self.statistics = {topic: StampStatistics(max_gap) for topic in sources}
        self.usable = dict.fromkeys(sources.values(), 0)
        self.stream = MessageStream(configuration, Pipeline(configuration, orientation), 0.0)

    def add(self, batch: Batch) -> None:
        """Take a batch."""
        joints, orientation = self._configuration.joints, self.stream.pipeline.orientation
        frames = self.stream.frames
        arrivals = arrivals_of(batch, self._sources, joints, orientation, frames)
        usable, t_ns = arrivals.sound.copy(), batch.t_ns.copy()
        for i in np.flatnonzero(~usable).tolist():
            _, _, sample, frame = batch.item(i, joints.names)
            other = arrivals.of_wrench[i] and frames.is_other(frame)
            if not other and not isinstance(sample, Malformed) and hasattr(sample, "t_ns"):
                of_wrench = arrivals.of_wrench[i]
                usable[i] = of_wrench or not isinstance(orientation(sample), str)
                t_ns[i] = sample.t_ns
        for number, topic in enumerate(batch.types):
            at = np.flatnonzero(usable & (batch.topic == number))
            if topic in self.statistics and len(at):
                self.usable[self._sources[topic]] += len(at)
                self.statistics[topic].add(t_ns[at], batch.log_ns[at])
        for _ in played(self.stream, batch, self._configuration, self._sources):
            pass

    def span(self, topic: str) -> tuple[int, int] | None:
        """Return the least and the greatest stamp of what is well-formed [ns]."""
        return self.statistics[topic].span

    def fates(self, read: dict[str, int]) -> tuple[dict[str, int], dict[str, int]]:
        """Return how many messages a replay uses, and those dropped, by source and by reason."""
        return fates(self.stream.counts, read)[:2]

    def alone(self, read: dict[str, int]) -> tuple[dict[str, int], dict[str, int]]:
        """Return the same by topic, whatever the order between topics."""
        used, dropped = dict(self.usable), fates(self.stream.counts, read)[1]
        dropped = {name: n for name, n in dropped.items() if not name.endswith(_OF_ORDER)}
        for topic, found in self.statistics.items():
            source = self._sources[topic]
            used[source] -= found.repeated
            if found.repeated:
                dropped[f"{source}_dropped_repeated_stamp"] = found.repeated
        return used, dropped
