"""What a bag itself adds to a configuration: the robot's description, and the sensor's frame."""

from dataclasses import replace
from typing import NamedTuple

from peg_on_hole_ros.bags.batch import stretches
from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.decode import WRENCH_TYPE
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.robot.described import described, with_description
from peg_on_hole_ros.robot.sensor_frame import mounting
from peg_on_hole_ros.robot.urdf_source import awaited

_AS_A_FILE = "name the robot's description as a file in joints.urdf"


class CompletedSettings(NamedTuple):
    """
    A configuration that is whole.

    Attributes
    ----------
    configuration : Configuration
    line : str
        What there is to say of the sensor's frame; empty: nothing.

    """

    configuration: Configuration
    line: str


def completed_settings(bag: Bag, configuration: Configuration) -> CompletedSettings:
    """
    Return a configuration with what the bag tells of the robot; one that is settled stays.

    Raises
    ------
    BagError
        The description is to come by a topic that the bag does not have.
    PegOnHoleError
        None that it brings can be used, or it contradicts what is stated of the sensor.

    """
    joints = configuration.joints
    if joints.source != "robot":
        return CompletedSettings(configuration, "")
    if awaited(joints):
        configuration = _with_topic(bag, configuration)
    configuration = described(configuration)
    frame = _frame(bag, absolute(configuration.topics.wrench))
    if frame is None:
        return CompletedSettings(configuration, "")
    wrench, line = mounting(configuration, frame)
    return CompletedSettings(replace(configuration, wrench=wrench), line)


def _with_topic(bag, configuration):
    """Return settings with the first description of a bag that is this robot's, as the node."""
    topic = absolute(configuration.topics.robot_description)
    bag.require({topic: STRING}, _AS_A_FILE)
    refused: dict[str, str] = {}
    for row in bag.messages([topic]):
        text = row.message.data
        if text in refused:
            continue
        try:
            found = with_description(configuration, text)
            orientation_of(found)
            return found
        except PegOnHoleError as error:
            refused[text] = str(error)
    if not refused:
        raise BagError(f"{bag.path}: no message on {topic} can be read as {STRING}")
    first, *others = dict.fromkeys(refused.values())
    more = f" (and {len(others)} more)" if others else ""
    raise PegOnHoleError(
        f"{bag.path}: no description on {topic} can be used: {first}{more}; {_AS_A_FILE}"
    )


def _frame(bag, topic):
    """Return the frame_id of the first wrench, or None where there is none to be read."""
    info = bag.topics.get(topic)
    if info is None or info.types not in ([WRENCH_TYPE], [""]):
        return None
    # What cannot be decoded is counted by whoever reads it all.
    counted = bag.undecodable.copy()
    first = next(bag.batches({topic: WRENCH_TYPE}), None)
    bag.undecodable = counted
    found = [] if first is None else [(at[0], s.frame_id) for at, s in stretches(first, topic)]
    return min(found)[1] if found else None
