"""A bag and the configuration that goes with it, as commands take them."""

import argparse
import sys
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.storage.bag_files import bag_files
from peg_on_hole_ros.bags.storage.unpacking import MOST_CHUNK
from peg_on_hole_ros.bags.truth import RecordedTruth, read_truth
from peg_on_hole_ros.cli.output_paths import check_output_paths
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.settings import load, remark
from peg_on_hole_ros.config.configuration import BY_NAME, check_topics, checked
from peg_on_hole_ros.config.options import Configuration, NodeOptions
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.replay.run import stored_configuration, stored_options
from peg_on_hole_ros.robot.urdf_source import FROM_TOPIC, urdf_path
from peg_on_hole_ros.safe_text import printable

# Of --max-chunk [MiB].
_LEAST_CHUNK, _GREATEST_CHUNK = 0.001, 4096.0


class ConfiguredBag(NamedTuple):
    """
    A bag that has been read through, and how it is to be understood.

    Attributes
    ----------
    bag : Bag
    configuration : Configuration
        Of the file that was given, else that in the bag, else the defaults.
    node : NodeOptions
    stored : bool
        Whether the configuration is that in the bag.

    """

    bag: Bag
    configuration: Configuration
    node: NodeOptions
    stored: bool


class Reading(NamedTuple):
    """
    How a bag is to be read, by options of a command.

    Attributes
    ----------
    wrench_topic, joints_topic : str or None
        In place of those of the configuration.
    most_chunk : int
        Bytes that a chunk may take unpacked.
    any_urdf : bool
        Whether the configuration in the bag may choose which file is read as URDF.

    """

    wrench_topic: str | None = None
    joints_topic: str | None = None
    most_chunk: int = MOST_CHUNK
    any_urdf: bool = False

    @classmethod
    def of(cls, arguments: argparse.Namespace) -> "Reading":
        """Return what the arguments of a command say."""
        mebibytes = arguments.max_chunk
        if not _LEAST_CHUNK <= mebibytes <= _GREATEST_CHUNK:
            raise PegOnHoleError(
                f"--max-chunk = {mebibytes:g} MiB is not within {_LEAST_CHUNK:g} to "
                f"{_GREATEST_CHUNK:g} MiB"
            )
        most = round(mebibytes * 2**20)
        return cls(arguments.wrench_topic, arguments.joints_topic, most, arguments.bag_urdf)

    def of_topics(self, configuration: Configuration) -> Configuration:
        """Return a configuration with the topics that were given."""
        given = {"wrench": self.wrench_topic, "joint_states": self.joints_topic}
        given = {
            name: checked(BY_NAME[f"topics.{name}"], topic)
            for name, topic in given.items()
            if topic is not None
        }
        topics = replace(configuration.topics, **given)  # type: ignore[arg-type]
        check_topics(topics)
        return replace(configuration, topics=topics)


AS_IT_IS = Reading()


def open_bag(path: str | Path, most_chunk: int = MOST_CHUNK) -> Bag:
    """Read a bag through, with progress, and name files beside it that are not part of it."""
    with ProgressBar(f"reading {path}") as progress:
        bag = Bag(path, progress, most_chunk)
    if bag.unnamed:
        names = ", ".join(file.name for file in bag.unnamed)
        print_line(
            f"{bag.path}: not read, as metadata.yaml does not name it: {names}; if it is a part "
            f"of the recording: ros2 bag reindex -s mcap {bag.path}"
        )
    return bag


def open_recording(
    path: str,
    config: str | None,
    bags: Iterable[str | None] = (),
    texts: Iterable[str | None] = (),
    reading: Reading = AS_IT_IS,
) -> ConfiguredBag:
    """
    Read a bag and its configuration, once every place to write has been checked.

    Parameters
    ----------
    path : str
        Of the bag.
    config : str or None
        ROS 2 parameters file; None: what the bag carries, or the defaults.
    bags, texts : iterable of str or None
        Outputs, see `check_output_paths`.
    reading : Reading

    Raises
    ------
    PegOnHoleError
        A bag, a configuration or a place that cannot be used.

    """
    bags, texts = list(bags), list(texts)
    configuration, node = load(config)
    given = [] if config is None else [config]
    read = [*bag_files(path).read(), *given, *_described_by(configuration)]
    check_output_paths(read, bags, texts)
    bag = open_bag(path, reading.most_chunk)
    stored = None if given else configuration_in(bag, reading.any_urdf)
    if stored is not None:
        configuration, node = stored, stored_options(bag) or node
        check_output_paths(_described_by(configuration), bags, texts)
    configuration, line = completed_settings(bag, reading.of_topics(configuration))
    if line:
        print_line(line)
    return ConfiguredBag(bag, configuration, node, stored is not None)


def configuration_in(bag: Bag, any_urdf: bool = False) -> Configuration | None:
    """Return the configuration that a bag carries and say so, or None."""
    stored = stored_configuration(bag, any_urdf)
    if stored is not None:
        print_line(f"configuration: that in {bag.path}")
        remark(stored)
    return stored


def print_line(text: str) -> None:
    """Print one line on stderr, whatever names are in it."""
    print(printable(text), file=sys.stderr)


def truth_in(bag: Bag) -> RecordedTruth | None:
    """Return the truth that a bag carries, or None; say so where it has one of no use."""
    try:
        with ProgressBar(f"reading the truth in {bag.path}") as progress:
            return read_truth(bag, progress)
    except BagError as error:
        # Truth that cannot be used is no reason to refuse the estimate.
        print_line(f"no comparison with the truth: {error}")
        return None


def _described_by(configuration):
    """Return the URDF of a robot as a list, which is empty without one."""
    joints = configuration.joints
    file = joints.source == "robot" and joints.urdf != FROM_TOPIC and not joints.description
    return [urdf_path(joints)] if file else []
