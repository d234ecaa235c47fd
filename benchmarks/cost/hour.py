"""
Whether an hour of working leaves memory, covariance and counts as they were after a minute.

    python -m benchmarks.cost.hour [--seconds 3600]

The working cycle's recording is played again and again, a second apart, through the stream of node
and replay, with new stamps and without files. Ends with 1 where memory grows, a covariance is no
longer positive definite, a number is not finite, or a message has no fate.
"""

import argparse
import resource
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.cost.long_run import check
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.records import WrenchSample
from peg_on_hole_ros.replay.run import stored_configuration

BAG = Path(__file__).parents[2] / "bags" / "working_cycle.mcap"
PAUSE_NS, CHECK_EVERY = 1_000_000_000, 97
# Of memory, after the first rounds have filled what is bounded [MB].
MOST_GROWTH, FILLED = 8.0, 3


class Found(NamedTuple):
    """Rounds, growth [MB], smallest pivot, how many are not finite, or have no fate."""

    rounds: int
    growth: float
    pivot: float
    not_finite: int
    lost: int

    @property
    def sound(self) -> bool:
        """Whether all is as it was."""
        return self.growth < MOST_GROWTH and self.pivot > 0 and not (self.not_finite or self.lost)


def hour(seconds: float) -> Found:
    """Play so much of stamp time, in whole rounds."""
    bag = Bag(BAG)
    takes = {"/wrench": wrench_sample, "/joint_states": joint_sample}
    samples = [takes[topic](message) for topic, _, message in bag.messages(list(takes))]
    round_ns = samples[-1].t_ns - samples[0].t_ns + PAUSE_NS
    stream = message_stream(stored_configuration(bag))
    rounds = max(round(seconds * 1e9 / round_ns), FILLED + 1)
    pivot, not_finite, filled, count = np.inf, 0, 0.0, 0
    for k in range(rounds):
        if k == FILLED:
            filled = memory()
        for sample in samples:
            later = sample._replace(t_ns=sample.t_ns + k * round_ns)
            if not isinstance(sample, WrenchSample):
                stream.take_joints(later)
                continue
            columns = stream.take_wrench(later)
            count += 1
            if count % CHECK_EVERY == 0 and columns is not None:
                finite = np.isfinite(columns["state"]).all()
                least, _ = check(stream.pipeline.filter.P[None])
                pivot, not_finite = min(pivot, least), not_finite + (not finite)
    growth = memory() - filled
    stream.on_event("reset")
    fates = sum(
        number
        for name, number in stream.counts.items()
        if "_dropped_" in name or name in ("wrench_used", "joints_used", "joints_gated")
    )
    return Found(rounds, growth, pivot, not_finite, abs(rounds * len(samples) - fates))


def memory() -> float:
    """Return the largest memory that this process has had [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def main(arguments=None) -> int:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--seconds", type=float, default=3600.0, help="of stamps (3600)")
    found = hour(parser.parse_args(arguments).seconds)
    print(
        f"{found.rounds} rounds: memory grew by {found.growth:.1f} MB after {FILLED}, smallest "
        f"pivot {found.pivot:.2g}, not finite {found.not_finite} times, messages without a fate "
        f"{found.lost}"
    )
    return int(not found.sound)


if __name__ == "__main__":
    sys.exit(main())
