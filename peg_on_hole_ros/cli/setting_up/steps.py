"""The steps of `peg-on-hole setup` in their order."""

from collections.abc import Callable
from dataclasses import replace

from peg_on_hole_ros.bags.reader import absolute
from peg_on_hole_ros.cli.payload import found_payload
from peg_on_hole_ros.cli.presses import found_axes
from peg_on_hole_ros.cli.setting_up.bags import Opened, SetupBags, not_recorded
from peg_on_hole_ros.cli.setting_up.dialogue import Dialogue
from peg_on_hole_ros.cli.setting_up.insertion import check_by_run
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.identification.payload import still_poses
from peg_on_hole_ros.identification.presses import pressed_stretches
from peg_on_hole_ros.identification.touched_plate import touched_plate
from peg_on_hole_ros.identification.weight import weight_of
from peg_on_hole_ros.robot.described import described
from peg_on_hole_ros.robot.fixed_links import Tree
from peg_on_hole_ros.robot.urdf_source import FROM_TOPIC, awaited, description_of
from peg_on_hole_ros.safe_text import listed, shown
from peg_on_hole_ros.setup_steps.evidence import (
    compare_axes,
    compare_compensated,
    compare_zero,
    take_gravity,
    take_noise,
    take_payload,
    take_presses,
    take_weight,
    take_zero,
)
from peg_on_hole_ros.setup_steps.hole_evidence import take_plate
from peg_on_hole_ros.setup_steps.knowledge import FOLLOWS, STATED, Cell, Known
from peg_on_hole_ros.setup_steps.questions import (
    HOLE,
    PARTS,
    PEG_IN_TOOL,
    SENSOR,
    SENSOR_PLACE,
    Question,
)
from peg_on_hole_ros.setup_steps.robot_parts import RobotParts
from peg_on_hole_ros.setup_steps.tuned import COMPARED_ZERO

RECORDINGS = ("plate", "presses", "poses", "hang", "run")
_WHAT = {
    "plate": "Lower the peg onto the plate at three places and more around the hole, and press "
    "with 10 N for a second at each.",
    "presses": "Let the peg hang still. Push it with 10 N or more: up at its lower end, along its "
    "x, along its y; a second each, with a pause behind it.",
    "poses": "Let the peg hang free and still at four tilts of 20 degrees and more, about two "
    "axes, half a second each.",
    "hang": "Let the peg hang free and still above the hole for some seconds.",
    "run": "Set the peg on the hole and insert it, as the cell will.",
}


class Steps:
    """The steps in their order; each takes what it finds into the cell."""

    def __init__(
        self, cell: Cell, dialogue: Dialogue, bags: SetupBags, given: dict[str, str]
    ) -> None:
        self._cell, self._dialogue, self._bags, self._given = cell, dialogue, bags, given
        self._root, self._fixed = "", {}

    def settings(self) -> Configuration:
        """Return the settings as they are used, with what follows from the robot."""
        configuration = self._cell.configuration()
        return configuration if awaited(configuration.joints) else described(configuration)

    def lead_through(self) -> None:
        """Do all steps."""
        self._robot()
        self._parts()
        self._hole()
        self._presses()
        self._poses_and_hang()
        self._run()

    def _robot(self):
        cell, dialogue = self._cell, self._dialogue
        dialogue.heading("Robot")
        if cell.value("joints.source") == "peg" and cell.is_given("joints.source"):
            dialogue.say("joints.source: peg: the peg's own angles, no robot")
            return
        if not cell.is_given("joints.urdf"):
            self._ask_urdf()
        if cell.value("joints.urdf") == FROM_TOPIC:
            self._by_topic()
        else:
            self._described(description_of(self._described_by()))
        for question in PEG_IN_TOOL:
            self._ask_of_robot(question)

    def _ask_urdf(self):
        if not self._dialogue.asks:
            raise PegOnHoleError(
                "no robot: name its description with --urdf FILE (or topic, where a recording "
                "has /robot_description), or state --set joints.source=peg for a peg that has "
                "joint states of its own"
            )

        def take(text):
            self._cell.put("joints.urdf", text, Known(STATED, "by an answer"))
            try:
                if text != FROM_TOPIC:
                    RobotParts.of(description_of(self._described_by()), text)
            except PegOnHoleError:
                del self._cell.values["joints.urdf"]
                raise

        self._dialogue.say(
            "\njoints.urdf: the robot's description, a file without xacro, or the word topic "
            "where the recordings have /robot_description"
        )
        self._dialogue.repeat("joints.urdf: ", take)

    def _described_by(self):
        """Return where the description is, before the tip is known."""
        values = {"joints.urdf": self._cell.value("joints.urdf"), "joints.tip_frame": "-"}
        return Cell(values | {"joints.source": "robot"}, "").configuration().joints

    def _by_topic(self):
        if not self._cell.is_given("joints.tip_frame") or not self._given:
            raise PegOnHoleError(
                "joints.urdf: topic needs a recording with /robot_description, and "
                "--set joints.tip_frame=LINK --set joints.names=JOINT,...; or name a file"
            )
        self._cell.put("joints.source", "robot", Known(FOLLOWS, "a description is stated"))

    def _described(self, text):
        cell, dialogue = self._cell, self._dialogue
        robot = RobotParts.of(text, str(cell.value("joints.urdf")))
        cell.put("joints.source", "robot", Known(FOLLOWS, "a description is stated"))
        likely = robot.likely_tip()

        def check():
            tip = cell.value("joints.tip_frame")
            if tip not in robot.links:
                raise PegOnHoleError(
                    f"joints.tip_frame = {shown(tip)} is no link; there are: {listed(robot.links)}"
                )

        dialogue.say("\n".join(robot.lines(likely)))
        if not cell.is_given("joints.tip_frame"):
            cell.put(
                "joints.tip_frame", likely, Known(FOLLOWS, "the last link of the longest chain")
            )
            dialogue.ask(Question("joints.tip_frame", "The link that carries the peg."), check)
        check()
        tip = cell.value("joints.tip_frame")
        if not cell.is_given("joints.names"):
            cell.put("joints.names", list(robot.names(tip)), Known(FOLLOWS, f"they move {tip}"))
        # Errors name what is wrong with tip and joints.
        described(cell.configuration())
        self._root = robot.root(tip)
        tree = Tree(*robot)
        fixed = {link: tree.fixed(link) for link in robot.links}
        self._fixed = {link: at.R for link, at in fixed.items() if at.link == self._root}

    def _ask_of_robot(self, question):
        """Ask of the peg in the tool, unless a recording tells it."""
        recorded = question.name == "joints.peg_rpy" and self._given
        if not recorded or self._dialogue.asks:
            self._dialogue.ask(question)

    def _parts(self):
        dialogue = self._dialogue
        dialogue.heading("Peg and hole")
        for question in PARTS:
            dialogue.ask(question)
        self._cell.configuration()

    def _hole(self):
        self._dialogue.heading("Hole and gravity")
        if self._cell.value("joints.source") == "robot":
            for question in HOLE:
                self._dialogue.ask(question)
            known = self._cell.is_given("joints.hole_rpy")
            if self._dialogue.asks or not known or "plate" in self._given:
                self._recorded("plate", (), self._take_plate)
        self._take_gravity()

    def _take_plate(self, opened: Opened) -> None:
        presses = pressed_stretches(opened.wrenches())
        plate = touched_plate(presses, opened.orientations(), opened.configuration.scene)
        take_plate(self._cell, plate, opened.configuration, opened.name)
        self._dialogue.say(f"joints.hole_rpy: {self._cell.how('joints.hole_rpy')}")

    def _take_gravity(self):
        configuration = self.settings()
        take_gravity(self._cell, configuration, self._root)
        if configuration.joints.robot_gravity is not None:
            self._dialogue.say(f"gravity: {self._cell.how('scene.gravity')}")

    def _presses(self):
        self._dialogue.heading("Sign and axes of the wrench")
        for question in SENSOR:
            self._dialogue.ask(question)

        def take(opened: Opened) -> None:
            found = found_axes(opened.bag, opened.configuration, opened.left_out)
            follows = self._cell.how("wrench.sensor_xyz").kind == FOLLOWS
            link_rpy = opened.configuration.wrench.sensor_rpy if follows else None
            values, pressed, axes = found.values, found.pressed, found.axes
            take_presses(self._cell, values, pressed, axes, opened.name, link_rpy)
            self._dialogue.say(found.text)

        self._recorded("presses", ("wrench.acts_on", "wrench.axes"), take)
        if self._cell.how("wrench.sensor_xyz").kind != FOLLOWS:
            for question in SENSOR_PLACE:
                self._dialogue.ask(question)

    def _poses_and_hang(self):
        cell, dialogue = self._cell, self._dialogue
        dialogue.heading("Noise, payload and zero")
        weighs = cell.value("wrench.gravity") == "measured"
        zero = ("wrench.bias_force", "wrench.bias_torque")
        payload = ("wrench.payload_mass", *zero)
        self._recorded("poses", payload if weighs else (), self._take_poses)
        self._recorded("hang", zero, self._take_hang)

    def _take_poses(self, opened: Opened) -> None:
        cell, record = self._cell, opened.record()
        take_noise(cell, record, opened.name)
        if cell.value("wrench.gravity") != "measured":
            compare_compensated(cell, still_poses(record, opened.configuration), opened.name)
            return
        opened = self._bags.open(str(opened.bag.path))
        configuration = opened.configuration
        found = found_payload(record, configuration)
        poses = still_poses(record, configuration)
        self._compare_axes(record, configuration, opened.name)
        take_weight(cell, poses, configuration, self._fixed, opened.name)
        take_payload(cell, found.values, found.payload, opened.name)
        self._dialogue.say(found.text)

    def _compare_axes(self, record, configuration, source):
        """Compare the axes of the wrench with others, by what still poses leave unexplained."""
        wrench = configuration.wrench
        left = {}
        for axes in ("sensor", *(link.name for link in wrench.base_links)):
            other = replace(configuration, wrench=replace(wrench, axes=axes))
            weight = weight_of(still_poses(record, other), other)
            if weight is not None:
                left[axes] = weight.left
        if wrench.axes in left:
            compare_axes(self._cell, left.pop(wrench.axes), left, source)

    def _take_hang(self, opened: Opened) -> None:
        cell, record = self._cell, opened.record()
        take_noise(cell, record, opened.name)
        configuration = self._bags.open(str(opened.bag.path)).configuration
        poses = still_poses(record, configuration)
        if "poses" not in self._given:
            take_zero(cell, poses, configuration, opened.name)
            return
        noise = configuration.wrench.force_stddev
        compare_zero(cell, poses, configuration, opened.name, max(COMPARED_ZERO.most_moved, noise))

    def _run(self):
        self._dialogue.heading("An insertion")

        def take(opened: Opened) -> None:
            for line in check_by_run(self._cell, self._bags, opened):
                self._dialogue.say(line)

        self._recorded("run", ("joints.delay",), take)

    def _recorded(self, kind: str, names: tuple[str, ...], take: Callable[[Opened], None]) -> None:
        """Take a recording into the cell; without one say how to make it."""
        topics = [
            absolute(self._cell.value(f"topics.{name}")) for name in ("wrench", "joint_states")
        ]
        command = f"ros2 bag record -s mcap -o {kind} {' '.join(topics)}"
        if kind in self._given:
            self._take(self._given[kind], take)
            return
        if self._dialogue.asks:
            self._dialogue.say(f"\n{_WHAT[kind]}\n    {command}")

            def take_path(text):
                if not text:
                    return
                self._given[kind] = text
                try:
                    self._take(text, take)
                except PegOnHoleError:
                    del self._given[kind]
                    raise

            self._dialogue.repeat(f"recording {kind} (Enter: none): ", take_path)
        if kind not in self._given:
            if not self._dialogue.asks:
                self._dialogue.say(f"no recording --{kind}. {_WHAT[kind]}\n    {command}")
            not_recorded(self._cell, names, f"record it and give --{kind}: {command}")

    def _take(self, path, take):
        """Take a recording; an error names it."""
        opened = self._bags.open(path)
        try:
            take(opened)
        except PegOnHoleError as error:
            if path in str(error):
                raise
            raise type(error)(f"{path}: {error}") from None
