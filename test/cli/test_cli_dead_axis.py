"""What `replay` reports of a wrench with a component that stays, or with left-handed axes."""

import json

import numpy as np
import pytest

from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.records import WrenchSample
from recorded_faults import BAGS, samples, spoilt
from small_bags import JOINTS, WRENCH, joints, wrench
from tiers import at_push

AXES = [f"{kind}'s {axis}" for kind in ("force", "torque") for axis in "xyz"]
MIRRORED = {
    **{
        f"the {axis} axis mirrored": np.diag(1.0 - 2.0 * np.eye(3)[i])
        for i, axis in enumerate("xyz")
    },
    "the axes x and y exchanged": np.eye(3)[[1, 0, 2]],
    "the axes x and z exchanged": np.eye(3)[[2, 1, 0]],
    "the axes y and z exchanged": np.eye(3)[[0, 2, 1]],
}

# Of forces and torques in the samples [N], [N m]; drivers round to a share of it.
NOISE = 0.2, 0.005
# In 0.7 s of one steady closing the exchanged forces nearly balance: the motion contradicts them.
NOT_NAMED = ("the axes x and z exchanged", "closing_without_slip")


def replayed(folder, capsys, path, change, end=99.0):
    """Replay a sample's bag with its wrenches changed; return what is printed, and the summary."""
    bag, summary = folder / "a.mcap", folder / "s.json"
    with BagWriter(bag) as writer:
        for sample in spoilt(samples(path, 0.0, end), change):
            if isinstance(sample, WrenchSample):
                message = wrench(sample.t_ns, sample.force, sample.torque)
                writer.write("/wrench", WRENCH, message, sample.t_ns)
            else:
                message = joints(sample.t_ns, sample.position)
                writer.write("/joint_states", JOINTS, message, sample.t_ns)
    assert main(["replay", str(bag), "--summary", str(summary)]) == 0
    return capsys.readouterr().out, json.loads(summary.read_text(encoding="utf-8"))


def staying(place, value, rounding=0.0):
    def change(force, torque, q):
        wrench = np.array([*force, *torque])
        if rounding:
            step = rounding * np.repeat(NOISE, 3)
            wrench = np.round(wrench / step) * step
        wrench[place] = value
        return wrench[:3], wrench[3:]

    return change


def causes(text):
    return [line for line in text.splitlines() if line.startswith(("wrench: ", "scene: "))]


@pytest.mark.parametrize("rounding", [0.0, pytest.param(0.05, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("path", at_push(BAGS[1:2], BAGS), ids=lambda path: path.stem)
@pytest.mark.parametrize("place", range(6))
def test_a_component_that_is_0_is_named_and_nothing_adopted(
    place, path, rounding, tmp_path, capsys
):
    text, content = replayed(tmp_path, capsys, path, staying(place, 0.0, rounding))
    (cause,) = causes(text)
    assert cause.startswith(f"wrench: the {AXES[place]} stays at 0 N")
    events = content["messages"]["events"]
    assert "setting_adopted" not in events
    # No contact is sure meanwhile: at 1 kHz all but 0.1 s of the wrenches, two of three messages.
    assert events["contact_doubted"] > content["messages"]["used"] / 1.5 - 100
    assert content["reactions_void"] and not content["alarms"]


def test_two_that_stay_are_named_together(tmp_path, capsys):
    def change(force, torque, q):
        return (0.0, 0.0, force[2]), torque

    text, content = replayed(tmp_path, capsys, BAGS[1], change)
    (cause,) = causes(text)
    assert cause.startswith("wrench: the force's x stays at 0 N and the force's y stays at 0 N ")


@pytest.mark.parametrize(("path", "end"), [(BAGS[1], 99.0), (BAGS[2], 2.0)])
def test_one_that_dies_on_the_way_is_named_with_its_value(path, end, tmp_path, capsys):
    """At a value well within what it had, so that it is no end of the sensor's range."""
    count = []

    def change(force, torque, q):
        count.append(1)
        return (force if len(count) < 250 else (*force[:2], -4.25)), torque

    text, content = replayed(tmp_path, capsys, path, change, end)
    (cause,) = causes(text)
    assert cause.startswith("wrench: the force's z stays at -4.25 N ")
    assert "setting_adopted" not in content["messages"]["events"]


@pytest.mark.parametrize("path", BAGS[:2], ids=lambda path: path.stem)
def test_a_coarse_rounding_is_no_dead_component(path, tmp_path, capsys):
    def change(force, torque, q):
        return np.round(force), np.round(torque, 1)

    text, _ = replayed(tmp_path, capsys, path, change)
    assert "while the others change" not in text


@pytest.mark.parametrize(
    ("name", "path"),
    [
        pytest.param(
            name, path, marks=[] if (i % 2, path) in ((0, BAGS[1]), (1, BAGS[2])) else
            pytest.mark.nightly,
        )
        for i, name in enumerate(MIRRORED)
        for path in BAGS
    ],
)  # fmt: skip
def test_left_handed_axes_are_named_and_nothing_adopted(name, path, tmp_path, capsys):
    M = MIRRORED[name]
    text, content = replayed(
        tmp_path, capsys, path, lambda force, torque, q: (M @ force, M @ torque), 2.0
    )
    if (name, path.stem) == NOT_NAMED:
        assert not causes(text) and content["messages"]["events"]["innovations_too_large"] > 100
        return
    (cause,) = causes(text)
    assert cause.startswith(
        "wrench: the wrench is in left-handed axes, which no setting mends: put the driver right, "
        f"force and torque alike: {name} ("
    )
    assert "; with it the forces balance to " in cause and "used in place" not in cause
    assert "setting_adopted" not in content["messages"]["events"] and content["reactions_void"]


def test_left_handed_axes_of_the_base_are_named_as_well(tmp_path, capsys):
    from cli_helpers import config
    from recorded_faults import in_base

    settings = config(tmp_path, "wrench: {axes: base}")
    mirror = np.diag([-1.0, 1.0, 1.0])

    def change(force, torque, q):
        return tuple(mirror @ each for each in in_base(force, torque, q))

    replayed(tmp_path, capsys, BAGS[1], change)
    assert main(["replay", str(tmp_path / "a.mcap"), "--config", str(settings)]) == 0
    (cause,) = causes(capsys.readouterr().out)
    assert "alike: the x axis mirrored (" in cause and "used in place" not in cause
