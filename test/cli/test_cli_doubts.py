"""What `replay` and `inspect` say of recordings that a cell gets wrong."""

import json

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer as McapWriter

from cli_helpers import SCHEMA, config, fails
from json_schema import check
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.simulated_bag import write_bag as write_simulated
from peg_on_hole_ros.bags.writer import BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.sim.truth import integrate
from simulated import ROOT, contact_plan
from small_bags import JOINTS, MS, WRENCH, header, joints, wrench

# Beyond what joints.delay can be.
FAR_CLOCKS = "synchronise the clocks of the drivers"
CLOCKS = "synchronise the clocks of the drivers, or state joints.delay"


def recording(path, wrench_of=wrench, joints_of=joints, count=400):
    """Write wrenches at 1 kHz and joint states at 500 Hz, each changed as asked for."""
    with BagWriter(path) as bag:
        for i in range(count):
            t_ns = 10**10 + i * MS
            bag.write("/wrench", WRENCH, wrench_of(t_ns), t_ns)
            if i % 2 == 0:
                bag.write("/joint_states", JOINTS, joints_of(t_ns), t_ns)
    return path


def named(*names):
    return lambda t_ns: joints(t_ns) | {"name": list(names)}


def shared(t_ns):
    """Two of three messages are those of a gripper."""
    return joints(t_ns) | ({"name": ["finger"], "position": [0.1]} if t_ns % (6 * MS) else {})


def stamped(make, offset_ns):
    return lambda t_ns: make(t_ns + offset_ns)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"joints_of": named("j1", "j2", "j3")},
            "no wrench of 400 could be used: joints_dropped_missing_joint 200, "
            "wrench_dropped_before_joints 400; joints.names has to name joints of the joint "
            "states: it is ['gamma', 'psi', 'phi'], the first joint state has ['j1', 'j2', 'j3']",
        ),
        (
            {"joints_of": lambda t_ns: joints(t_ns, (17.2, 0.0, 0.0))},
            "no wrench of 400 could be used: joints_dropped_out_of_range 200, "
            "wrench_dropped_before_joints 400; angles are in radians: degrees? the order of "
            "joints.names? a peg that points up: joints.hole_rpy",
        ),
        (
            {"joints_of": stamped(joints, 3600 * 10**9)},
            "the stamps of the joint states lie 3599.601 s after those of the wrench, all of "
            f"them, so that none goes with another; {FAR_CLOCKS}",
        ),
        # Near enough for one to go on without the other, and nothing to begin with.
        (
            {"joints_of": stamped(joints, 600 * MS)},
            "the stamps of the joint states lie 0.201 s after those of the wrench, all of them, "
            f"so that none goes with another; {CLOCKS}",
        ),
        (
            {"joints_of": lambda t_ns: joints(0)},
            "the stamps of the joint states lie 10.000 s before those of the wrench, all of "
            "them, so that none goes with another; those of one are all zero: its driver does "
            "not set them, and has to",
        ),
        # Each wrench had been taken for a clock that jumped, and the end was exit code 0.
        (
            {"wrench_of": stamped(wrench, 3600 * 10**9)},
            "the stamps of the joint states lie 3599.602 s before those of the wrench, all of "
            f"them, so that none goes with another; {FAR_CLOCKS}",
        ),
    ],
)
def test_what_cannot_be_used_is_refused_with_its_remedy(tmp_path, capsys, changes, message):
    path = recording(tmp_path / "a.mcap", **changes)
    out = tmp_path / "out.mcap"
    fails(capsys, 3, f"{path}: {message}", "replay", path, "--out", out)
    assert not out.exists()
    assert main(["inspect", str(path), "--json"]) == 0
    seen = json.loads(capsys.readouterr().out)["replay"]
    assert not seen["possible"]
    # The same remedy, or the same words.
    _, _, what = message.partition("wrench_dropped_before_joints 400; ")
    assert seen["reason"] == (
        f"no message on /joint_states can be used; {what}" if what else message
    )
    if not what:
        fails(capsys, 3, f"{path}: {message}", "calibrate", path, "--out", tmp_path / "c.yaml")


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"joints_of": stamped(joints, -200 * MS)},
            f"199 of 200 messages of joints were not used: {CLOCKS}",
        ),
        (
            {"joints_of": shared},
            "133 of 200 messages of joints were not used: usual where another driver shares the "
            "topic: joints.names is ['gamma', 'psi', 'phi'], the first joint state without all of "
            "them has ['finger']",
        ),
        (
            {"wrench_of": lambda t_ns: wrench(t_ns, (2e6 * (t_ns % (3 * MS) > 0), 0.0, -10.0))},
            "267 of 400 messages of wrench were not used: N and N m: a force above 1e6 N is none",
        ),
        (
            {"wrench_of": lambda _: wrench(0), "joints_of": lambda _: joints(0)},
            "399 of 400 messages of wrench were not used: the driver does not set stamps, or too "
            "coarsely (whole milliseconds), or sends twice; or two publish on one topic",
        ),
    ],
)
def test_what_was_hardly_used_is_told(tmp_path, capsys, changes, line):
    assert main(["replay", str(recording(tmp_path / "a.mcap", **changes))]) == 0
    assert line in capsys.readouterr().out.splitlines()


@pytest.fixture(scope="module")
def sliding(tmp_path_factory):
    plan = contact_plan([0.2, 0.0, 0.0], [-0.1, 0.2, 1.0], [0.0, 0.0, -1e-3], 0.6)
    path = tmp_path_factory.mktemp("sliding") / "a.mcap"
    write_simulated(path, integrate(plan))
    return path


def test_a_right_recording_is_not_doubted(sliding, capsys):
    assert main(["replay", str(sliding)]) == 0
    told = capsys.readouterr().out
    words = ("not used", "not believed", "unknown throughout", "do not fit each other")
    assert not [word for word in words if word in told]
    assert not [line for line in told.splitlines() if line.startswith(("wrench:", "joints:"))]
    assert main(["inspect", str(sliding), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["oddities"] == {"/joint_states": [], "/wrench": []}


def changed(sliding, path, wrench_of=lambda t_ns, force, torque: [wrench(t_ns, force, torque)],
            joints_of=lambda t_ns, q: [joints(t_ns, q)]):  # fmt: skip
    """Write the recording with what is made of each message in its place."""
    with BagWriter(path) as bag:
        for topic, log_ns, message in Bag(sliding).messages(["/wrench", "/joint_states"]):
            stamp = message.header.stamp
            t_ns = stamp.sec * 10**9 + stamp.nanosec
            if topic == "/wrench":
                force, torque = message.wrench.force, message.wrench.torque
                vectors = ((v.x, v.y, v.z) for v in (force, torque))
                for content in wrench_of(t_ns, *vectors):
                    bag.write(topic, WRENCH, content, log_ns)
            else:
                for content in joints_of(t_ns, message.position):
                    bag.write(topic, JOINTS, content, log_ns)
    return path


def of_two(t_ns, force, torque):
    other = wrench(t_ns + MS // 3) | {"header": header(t_ns + MS // 3, "right")}
    return [wrench(t_ns, force, torque), other]


@pytest.mark.parametrize(
    ("changes", "source", "line"),
    [
        (
            {"joints_of": lambda t_ns, q: [joints(t_ns, q), joints(t_ns + MS // 3)]},
            "joints",
            "positions jump ",
        ),
        ({"joints_of": lambda t_ns, q: [joints(t_ns, q), joints(t_ns)]}, "joints", "positions ju"),
        (
            {"wrench_of": of_two},
            "wrench",
            "frame_id is 'right' (581) in messages between those of 'sensor': two publish on one "
            "topic, and the first alone is used; give each a topic of its own",
        ),
        (
            {"wrench_of": lambda t_ns, force, _: [wrench(t_ns, force)]},
            "wrench",
            "torque is (0, 0, 0) in all 581 messages: a sensor's noise changes it, so the driver "
            "does not fill it or repeats an old one",
        ),
        (
            {"joints_of": lambda t_ns, _: [joints(t_ns, (0.15, 0.0, 0.0))]},
            "joints",
            "position is (0.15, 0, 0) in all 291 messages: the peg rests throughout, or the "
            "driver repeats an old one",
        ),
    ],
)
def test_what_is_odd_in_the_messages_is_told(sliding, tmp_path, capsys, changes, source, line):
    path = changed(sliding, tmp_path / "a.mcap", **changes)
    assert main(["replay", str(path)]) == 0
    begun = f"{source}: {line}"
    # Wrenches of two sensors are rougher than any noise.
    rough = " from message to message: is it in N m, of one sensor? "
    told = [at for at in capsys.readouterr().out.splitlines() if rough not in at]
    assert (
        [at for at in told if at.startswith(("wrench:", "joints:"))]
        == [at for at in told if at.startswith(begun)]
        != []
    )
    assert main(["inspect", str(path)]) == 0
    topic = {"joints": "/joint_states", "wrench": "/wrench"}[source]
    told = capsys.readouterr().out.splitlines()
    assert [at for at in told if at.startswith(f"{topic}: {line}")]


@pytest.mark.parametrize("source", ["wrench", "joints"])
@pytest.mark.parametrize("text", ["float64 a", "int32 header\nint32 name\nint32 position"])
def test_messages_of_another_definition_are_counted(tmp_path, capsys, source, text):
    path, types = tmp_path / "a.mcap", {"/wrench": WRENCH, "/joint_states": JOINTS}
    odd = {"wrench": "/wrench", "joints": "/joint_states"}[source]
    with open(recording(tmp_path / "whole.mcap"), "rb") as whole, path.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros2")
        channels = {}
        for topic, name in types.items():
            content = text if topic == odd else definition(name)
            schema = writer.register_schema(name, "ros2msg", content.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for _, channel, message in make_reader(whole).iter_messages(list(types)):
            data = bytes([0, 1, 0, 0, *range(12)]) if channel.topic == odd else message.data
            writer.add_message(channels[channel.topic], message.log_time, data, message.log_time)
        writer.finish()
    assert main(["replay", str(path)]) == 3
    said = capsys.readouterr().err
    assert f"{source}_dropped_malformed_unreadable" in said
    assert "two types on one topic, or a definition in the bag that is another's" in said
    assert main(["inspect", str(path), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["replay"]
    assert found["reason"] == (
        f"no message on {odd} can be used; two types on one topic, or a definition in the bag "
        "that is another's"
    )
    assert list(found["dropped"]) == [f"{odd}: unreadable"]


@pytest.mark.parametrize(("offset", "where"), [(300, "ahead of"), (-80, "behind")])
def test_stamps_of_two_clocks_are_told_by_when_messages_were_recorded(
    sliding, tmp_path, capsys, offset, where
):
    def other_clock(t_ns, q):
        return [joints(t_ns + offset * MS, q)]

    def inspected(delay):
        given = config(tmp_path, f"joints: {{delay: {delay}}}")
        assert main(["inspect", str(path), "--config", str(given)]) == 0
        return [line for line in capsys.readouterr().out.splitlines() if "stamps lie" in line]

    path = changed(sliding, tmp_path / "a.mcap", joints_of=other_clock)
    told = f"/joint_states: stamps lie {abs(offset) / 1000:.3f} s {where} those of wrenches that "
    assert inspected(0.0) == [f"{told}were recorded at the same time; {CLOCKS}"]
    # Stated, and stated with the wrong sign.
    assert inspected(offset / 1000) == []
    assert inspected(-offset / 1000) == [
        f"{told}were recorded at the same time (joints.delay is {-offset / 1000:g} s); {CLOCKS}"
    ]


def test_joint_states_beyond_the_wrench_have_a_remedy(sliding, tmp_path, capsys):
    def other_clock(t_ns, q):
        return [joints(t_ns + 300 * MS, q)]

    path = changed(sliding, tmp_path / "a.mcap", joints_of=other_clock)
    assert main(["replay", str(path)]) == 0
    assert (
        f"150 of 291 messages of joints were not used: the wrench ended before them; {CLOCKS}"
    ) in capsys.readouterr().out.splitlines()


def test_a_peg_that_never_was_on_three_contacts_is_told(sliding, tmp_path, capsys):
    narrow = config(tmp_path, "scene: {peg_diameter: 0.0489}")
    assert main(["replay", str(sliding), "--config", str(narrow)]) == 0
    assert (
        "contact mode: two_point, and never three_point before, as gamma stayed below gamma0 = "
        "0.2101 rad: if the peg rested on the rim, check hole_diameter - peg_diameter (of "
        "bore and shank, not of chamfers) and joints.hole_rpy"
    ) in capsys.readouterr().out.splitlines()


def test_wrench_and_joints_of_two_robots_are_told(tmp_path, capsys):
    path = tmp_path / "a.mcap"
    with BagWriter(path) as bag:
        for t_ns in range(10**9, 10**9 + 50 * MS, MS):
            for side in ("left", "right"):
                bag.write(f"/{side}/joint_states", JOINTS, joints(t_ns), t_ns)
                bag.write(f"/{side}/wrench", WRENCH, wrench(t_ns), t_ns)
    mixed = config(tmp_path, "topics: {wrench: /left/wrench, joint_states: /right/joint_states}")
    line = (
        "topics: /left/wrench and /right/joint_states are read, of two namespaces, though there "
        "is /right/wrench and /left/joint_states: wrench and joint states have to be of one robot "
        "(topics.wrench, topics.joint_states)"
    )
    right = config(tmp_path, "topics: {wrench: left/wrench, joint_states: left/joint_states}", "r")
    for command in ("replay", "inspect"):
        assert main([command, str(path), "--config", str(mixed)]) == 0
        begun = "" if command == "replay" else "/left/wrench: "
        assert f"{begun}{line}" in capsys.readouterr().out.splitlines()
        assert main([command, str(path), "--config", str(right)]) == 0
        assert "topics:" not in capsys.readouterr().out


def test_stamps_in_microseconds_are_told(sliding, tmp_path, capsys):
    def micro(t_ns, force, torque):
        content = wrench(t_ns, force, torque)
        content["header"]["stamp"]["nanosec"] //= 1000
        return [content]

    path = changed(sliding, tmp_path / "a.mcap", wrench_of=micro)
    assert main(["inspect", str(path)]) == 0
    assert (
        "  trouble: stamps advance by 0.00058 s while 0.58 s were recorded: the driver's clock "
        "counts in another unit (a stamp has seconds and nanoseconds), or jumps"
    ) in capsys.readouterr().out.splitlines()


def test_a_gripper_on_the_topic_is_nothing_odd(sliding, tmp_path, capsys):
    def gripper(t_ns):
        return {"header": header(t_ns, "hand"), "name": ["finger"], "position": [t_ns * 1e-9]}

    both = {"joints_of": lambda t_ns, q: [joints(t_ns, q), gripper(t_ns)]}
    path = changed(sliding, tmp_path / "a.mcap", **both)
    assert main(["replay", str(path)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert not [line for line in told if line.startswith("joints:") or "not used" in line]


def test_a_few_that_are_not_used_are_told_where_none_should_be(sliding, tmp_path, capsys):
    def some(t_ns, force, torque):
        bad = t_ns // MS % 5 == 0
        return [wrench(t_ns, (float("nan"),) * 3 if bad else force, torque)]

    path = changed(sliding, tmp_path / "a.mcap", wrench_of=some)
    assert main(["replay", str(path)]) == 0
    told = capsys.readouterr().out.splitlines()
    assert "117 of 581 messages of wrench were not used: the driver sends NaN or infinity" in told


def test_forces_in_kilonewtons_are_told(sliding, tmp_path, capsys):
    told = replayed_in_units(sliding, tmp_path, capsys, 1e-3, 1.0)
    # By its noise, before any wrench of it is weighed.
    assert (
        "\nwrench: the wrench seems to come in kN: the driver has to send N and N m; with" in told
    )
    assert "with unit of the force read as kN the noise is as stated" in told


def replayed_in_units(sliding, folder, capsys, force_unit, torque_unit, *options):
    """Return what a replay prints of the recording with force and torque so many times theirs."""

    def slipped(t_ns, force, torque):
        return [wrench(t_ns, [force_unit * x for x in force], [torque_unit * x for x in torque])]

    path = changed(sliding, folder / "units.mcap", wrench_of=slipped)
    assert main(["replay", str(path), *map(str, options)]) == 0
    return capsys.readouterr().out


def reactions_in(told):
    return [line for line in told.splitlines() if line.startswith(("reactions:", "largest reac"))]


NOT_TOLD = "reactions: not told, as they would rest on what the data contradict (above)"


@pytest.mark.parametrize(
    ("force", "torque"), [(1e-3, 1.0), (1.0, 1e-3), (1.0, 1e3), (1e-3, 1e3), (1e-3, 1e-3)]
)
def test_of_a_wrench_in_another_unit_no_reaction_is_told(sliding, tmp_path, capsys, force, torque):
    summary, report = tmp_path / "s.json", tmp_path / "r.html"
    to = "--summary", summary, "--report", report
    told = replayed_in_units(sliding, tmp_path, capsys, force, torque, *to)
    assert reactions_in(told) == [NOT_TOLD]
    assert "settings that this motion cannot determine" not in told
    content, nothing = json.loads(summary.read_text()), dict.fromkeys(("K", "B1", "B2"))
    check(content, SCHEMA)
    assert content["reactions_void"] and content["max_normal"] == nothing
    for cycle in content["cycles"]:
        assert cycle["peak_normal"] == cycle["mean_normal"] == nothing
    page = report.read_text(encoding="utf-8")
    assert "Reactions are withheld: they would rest on what the data contradict" in page
    assert "Worst load:" not in page and "of limit" not in page


def test_reactions_are_told_once_the_right_setting_is_used(sliding, tmp_path, capsys):
    """The sign that is found is taken, unless that is not wanted: then nothing is right."""
    for adopt, begun in (("true", "largest reaction [N]"), ("false", NOT_TOLD)):
        wrong = config(tmp_path, f"wrench: {{acts_on: robot, adopt_found: {adopt}}}")
        told = replayed_in_units(sliding, tmp_path, capsys, 1.0, 1.0, "--config", wrong)
        (line,) = reactions_in(told)
        assert line.startswith(begun)


def test_a_wrong_sign_is_told(sliding, tmp_path, capsys):
    wrong = config(tmp_path, "wrench: {acts_on: robot}")
    assert main(["replay", str(sliding), "--config", str(wrong)]) == 0
    told = capsys.readouterr().out
    assert (
        "\nwrench: the sign of the wrench is reversed: set wrench.acts_on: peg; with it the"
        in told
    )
    assert "the forces balance to 0.2" in told
    # Guesses are for where nothing is found.
    assert "check wrench.acts_on" not in told and "check sensor_xyz" not in told


def test_a_lever_arm_that_is_wrong_is_told_in_words(sliding, tmp_path, capsys):
    wrong = config(tmp_path, "wrench: {sensor_xyz: [0.002, 0.0, 0.07]}")
    assert main(["replay", str(sliding), "--config", str(wrong)]) == 0
    told = capsys.readouterr().out
    assert "innovations_too_large: wrench and motion do not fit each other: check" in told


def test_torques_in_newton_millimetres_are_told(sliding, tmp_path, capsys):
    def slipped(t_ns, force, torque):
        return [wrench(t_ns, force, [1000 * x for x in torque])]

    wrong = changed(sliding, tmp_path / "b.mcap", wrench_of=slipped)
    assert main(["replay", str(wrong)]) == 0
    told = capsys.readouterr().out
    assert "\nwrench: the torque does not come in N m: the driver has to send N and N m; " in told
    assert "unit of the torque read as N mm fits; with it the forces balance to 0.2" in told
    assert "check sensor_xyz" not in told


@pytest.mark.parametrize(
    ("changes", "counts"),
    [
        ({"count": 6}, "6 wrenches and 3 joint states"),
        (
            {"wrench_of": lambda _: wrench(0), "joints_of": lambda _: joints(0)},
            "1 wrenches and 1 joint states",
        ),
    ],
)
def test_a_recording_too_short_to_calibrate_is_told(tmp_path, capsys, changes, counts):
    path = recording(tmp_path / "a.mcap", **changes)
    message = (
        f"{path}: {counts} with stamps of their own can be used, and a calibration needs at least "
        "250 joint states of steady sliding; record longer, or at a higher rate, if `peg-on-hole "
        "inspect` reports no other reason"
    )
    fails(capsys, 3, message, "calibrate", path, "--out", tmp_path / "c.yaml")


def test_configurations_are_compared_over_a_bag(tmp_path, capsys):
    path = config(tmp_path, "scene: {friction: 0.3}")
    message = (
        f"{path} is a configuration; to compare two of them, name the bag to replay: compare "
        "A.yaml B.yaml --bag BAG"
    )
    fails(capsys, 2, message, "compare", path, path)


@pytest.mark.parametrize("name", ["chart", "stability"])
def test_an_empty_folder_is_not_the_current_one(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    message = "the path of the folder is empty; name one, such as --out results"
    fails(capsys, 2, message, name, "--out", "", "--quick")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("option", "value", "what"),
    [
        ("--state", "0.1,0,0,1e300,0,2", "1e+300 rad/s is not within -10000 to 10000 rad/s"),
        ("--wrench", "0,0,1e30,0,0,0", "1e+30 N is not within -1e+06 to 1e+06 N"),
    ],
)
def test_solve_refuses_what_no_peg_has(capsys, option, value, what):
    state = [] if option == "--state" else ["--state", "0.2,0,0,-0.1,0,2"]
    message = f"{option} = {value}: {what}; all six are in SI units"
    fails(capsys, 2, message, "solve", *state, option, value)


@pytest.mark.parametrize(
    ("force", "torque", "told"),
    [(1.0, 1.0, []), (1e-3, 1.0, ["force"]), (1e-3, 1e-3, ["force", "torque"])],
)
def test_a_wrench_in_another_unit_is_told_by_its_noise(tmp_path, capsys, force, torque, told):
    rng = np.random.default_rng(1)

    def noisy(t_ns):
        values = (-10.0 + rng.normal(0, 0.2, 3)) * force, rng.normal(0, 0.005, 3) * torque
        return wrench(t_ns, *(value.tolist() for value in values))

    assert main(["replay", str(recording(tmp_path / "a.mcap", noisy))]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "the noise of the" in line]
    assert [line.split("the noise of the ")[1].split()[0] for line in lines] == told
    for line in lines:
        assert "seems to come in kN" in line and "and reactions mean nothing" in line


def upright(i):
    """An orientation near upright, given as encoders of the peg do: psi + phi alone is known."""
    gamma, turn = 1e-4 * abs(np.sin(0.3 * i)), 0.002 * i
    psi = np.angle(np.exp(1j * 2.5 * i))
    return gamma, psi, np.angle(np.exp(1j * (turn - psi)))


@pytest.mark.parametrize(
    ("angles", "jumps"),
    [
        # Trade places near upright, and wrap; then the tilt, the heading and the peg's own turn.
        (upright, False),
        (lambda i: (0.3, np.angle(np.exp(0.01j * i + 3.1j)), np.angle(np.exp(-0.02j * i))), False),
        (lambda i: (0.3 + 0.3 * (i % 2), 0.0, 0.0), True),
        (lambda i: (0.3, 1.5 * (i % 2), 0.0), True),
        (lambda i: (1e-4, 0.0, 0.4 * (i % 2)), True),
    ],
)
def test_the_pegs_own_joints_jump_as_an_orientation_does(angles, jumps, tmp_path, capsys):
    def joints_of(t_ns):
        return joints(t_ns, tuple(map(float, angles((t_ns - 10**10) // (2 * MS)))))

    path = recording(tmp_path / "a.mcap", joints_of=joints_of)
    assert main(["inspect", str(path), "--json"]) in (0, 3)
    lines = json.loads(capsys.readouterr().out)["oddities"]["/joint_states"]
    assert any("positions jump" in line for line in lines) == jumps
    assert main(["replay", str(path)]) in (0, 3)
    assert ("positions jump" in capsys.readouterr().out) == jumps


@pytest.mark.nightly
def test_nothing_jumps_in_the_samples_own_insertion(tmp_path, capsys):
    path, settings = str(tmp_path / "a.mcap"), str(ROOT / "config" / "insertion.yaml")
    assert main(["simulate", "--config", settings, "--out", path]) == 0
    for command in ("inspect", "replay"):
        capsys.readouterr()
        assert main([command, path]) == 0
        assert "jump" not in capsys.readouterr().out
