"""The recordings of `peg-on-hole setup`: opened with the settings found so far, and read once."""

from collections import Counter
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.cli.bag_and_configuration import open_bag
from peg_on_hole_ros.cli.recordings import measured_orientations, read_recording, usable_wrenches
from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import BagError, PegOnHoleError
from peg_on_hole_ros.identification.recording import Recording
from peg_on_hole_ros.measurements.rotations import quarter_turns, rpy_of
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.stream import orientation_of
from peg_on_hole_ros.records import AngleMeasurement, JointSample, WrenchSample
from peg_on_hole_ros.replay.bag_settings import completed_settings
from peg_on_hole_ros.safe_text import listed
from peg_on_hole_ros.setup_steps.knowledge import FOLLOWS, MEASURED, UNKNOWN, Cell, Known

# The hole's place that is used until one is known, so that the peg has one in its axes [m].
_SOMEWHERE = [1e-9, 0.0, 0.0]


class Opened(NamedTuple):
    """
    A recording, and the settings with what it adds to them.

    Attributes
    ----------
    bag : Bag
    configuration : Configuration
    left_out : Counter
        Messages that are left out, by reason.

    """

    bag: Bag
    configuration: Configuration
    left_out: Counter[str]

    @property
    def name(self) -> str:
        """What it is called in comments."""
        return self.bag.path.name

    def record(self) -> Recording:
        """Return wrenches and orientations; raises as `read_recording`."""
        return read_recording(self.bag, self.configuration, self.left_out)

    def wrenches(self) -> list[WrenchSample]:
        """Return the wrenches that can be used."""
        return usable_wrenches(self.bag, self.configuration, self.left_out)

    def orientations(self) -> list[AngleMeasurement]:
        """Return the orientations and places that can be used."""
        return measured_orientations(self.bag, self.configuration)


class SetupBags:
    """
    Opens recordings, each once.

    Parameters
    ----------
    cell : Cell
    most_chunk : int
        Bytes that a chunk may take unpacked.

    """

    def __init__(self, cell: Cell, most_chunk: int) -> None:
        self._cell, self._most_chunk = cell, most_chunk
        self._bags: dict[str, Bag] = {}

    @property
    def damage(self) -> str:
        """What is damaged in one of them; empty: nothing."""
        return next((bag.damage for bag in self._bags.values() if bag.damage), "")

    def open(self, path: str) -> Opened:
        """
        Return a recording with the settings of now; its topics are found where none is stated.

        Raises
        ------
        PegOnHoleError
            It cannot be read, has not the topics, or contradicts what is stated of the sensor.

        """
        cell = self._cell
        if path not in self._bags:
            self._bags[path] = open_bag(path, self._most_chunk)
        bag = self._bags[path]
        self._find_topics(bag)
        if cell.value("joints.source") == "robot":
            self._check_peg(bag)
        settings = completed_settings(bag, from_parameters(_placed(cell)))
        found, wrench = settings.configuration, cell.configuration().wrench
        if found.wrench.sensor_xyz != wrench.sensor_xyz:
            by = Known(FOLLOWS, f"{list(found.wrench.sensor_xyz)}, {settings.line}")
            cell.tell("wrench.sensor_xyz", by)
            if not cell.is_given("wrench.sensor_rpy"):
                cell.tell("wrench.sensor_rpy", Known(FOLLOWS, settings.line))
        return Opened(bag, found, Counter())

    def _find_topics(self, bag: Bag) -> None:
        """Take the one topic of a type where that of the settings is not there."""
        for name, ros_type in (
            ("topics.wrench", WRENCH_TYPE),
            ("topics.joint_states", JOINTS_TYPE),
        ):
            info = bag.topics.get(absolute(self._cell.value(name)))
            if self._cell.is_given(name) or info is not None and info.count:
                continue
            found = [
                topic.name
                for topic in bag.topics.values()
                if topic.types == [ros_type] and topic.count and self._is_input(bag, topic.name)
            ]
            if len(found) == 1:
                by = Known(MEASURED, f"the only one of its type in {bag.path.name}")
                self._cell.put(name, found[0], by)
            elif found:
                raise BagError(
                    f"{bag.path} has {listed(found)} of type {ros_type}: state {name}, as by "
                    f"--set {name}={found[0]}"
                )

    def _is_input(self, bag: Bag, topic: str) -> bool:
        """Return whether a topic has the joints that are needed; every wrench may be the one."""
        if bag.topics[topic].types != [JOINTS_TYPE]:
            return True
        needed = set(self._cell.value("joints.names"))
        sample = _first(bag, topic)
        return sample is not None and needed <= set(sample.names)

    def _check_peg(self, bag: Bag) -> None:
        """Take the axis of the tip that points up out of the hole for the peg's, if none is."""
        cell, name = self._cell, "joints.peg_rpy"
        topic = absolute(cell.value("topics.joint_states"))
        sample = _first(bag, topic) if topic in bag.topics else None
        if sample is None:
            return
        given = cell.is_given(name)
        if given and self._tilt(bag, sample, cell.value(name)) is not None:
            return
        tilts = []
        for turn in quarter_turns():
            if any(np.allclose(turn[:, 2], axis) for _, axis, _ in tilts):
                continue
            rpy = [float(f"{angle:.9g}") + 0.0 for angle in rpy_of(turn)]
            tilt = self._tilt(bag, sample, rpy)
            if tilt is not None:
                tilts.append((tilt, turn[:, 2], rpy))
        if not tilts:
            return
        tilt, axis, rpy = min(tilts, key=lambda each: each[0])
        which = "xyz"[int(np.argmax(np.abs(axis)))]
        sign = "-" if axis.sum() < 0.0 else ""
        of = "the hole's axis" if cell.is_given("joints.hole_rpy") else "the root link's z"
        text = (
            f"the tip's {sign}{which} is nearest to {of} in {bag.path.name}, off by "
            f"{np.degrees(tilt):.0f} degrees"
        )
        if given:
            raise PegOnHoleError(
                f"joints.peg_rpy = {list(cell.value(name))}: in {bag.path} the peg points away "
                f"from the hole; {text}: {rpy} would fit, unless joints.hole_rpy is wrong"
            )
        text += (
            "; a peg held at another angle, and how it is turned about its axis, is yours to state"
        )
        cell.put(name, rpy, Known(MEASURED, text))

    def _tilt(self, bag: Bag, sample: JointSample, rpy: list[float]) -> float | None:
        """Return the tilt of the peg with peg axes in the tip [rad], None of one that is none."""
        values = _placed(self._cell) | {"joints.peg_rpy": rpy}
        settings = completed_settings(bag, from_parameters(values)).configuration
        found = orientation_of(settings)(sample)
        # A joint that is missing or beyond its limits is told where all are read.
        pointing_away = found == "pointing_away"
        return None if pointing_away else 0.0 if isinstance(found, str) else float(found.q[0])


def _placed(cell: Cell) -> dict[str, object]:
    """Return settings in which the hole has a place."""
    values = dict(cell.values)
    if cell.value("joints.source") == "robot" and not any(cell.value("joints.hole_xyz")):
        values["joints.hole_xyz"] = _SOMEWHERE
    return values


def _first(bag: Bag, topic: str) -> JointSample | None:
    """Return the first joint state of a topic that can be read."""
    samples = (item.sample for item in bag.items({topic: JOINTS_TYPE}))
    return next((each for each in samples if isinstance(each, JointSample)), None)


def not_recorded(cell: Cell, names: tuple[str, ...], how: str) -> None:
    """Say of settings that no recording tells them, and how to record one."""
    for name in names:
        if not cell.is_given(name):
            cell.tell(name, Known(UNKNOWN, how))
