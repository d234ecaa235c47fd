"""Files, names and texts that nothing stumbles over: one line, a documented exit code, no "
"escapes."""

import json
import os
import re
import shutil
import sys

import pytest
from mcap.writer import Writer

from cli_helpers import command, config, fails
from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.bags.writer import CONFIGURATION_METADATA, BagWriter
from peg_on_hole_ros.cli.main import main
from peg_on_hole_ros.cli.terminal_output import ignore_broken_pipes
from peg_on_hole_ros.messages.beside_estimates import STRING
from peg_on_hole_ros.messages.cdr import Encoder
from peg_on_hole_ros.messages.definitions import definition
from peg_on_hole_ros.startup.exit_codes import INTERNAL, TRACEBACK, exit_code
from small_bags import JOINTS, MS, WRENCH, joints, wrench, write_bag

# What a terminal obeys, but for the ends of lines.
OBEYED = re.compile(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]")
LINE = "=" * 80


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bag") / "a.mcap", count=60)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("[" * 3000, " is not YAML at line 4: groups or lists lie deeper within each other than"),
        ("!!bool maybe", ", line 4: scene.friction = 'maybe' is a string, not a double"),
        ('!!int ""', ", line 4: scene.friction = '' is a string, not a double"),
        ("!!timestamp x", ", line 4: scene.friction = 'x' is a string, not a double"),
        ("0x" + "f" * 400, ", line 4: scene.friction = '0xf"),
        ("1" * 5000, ", line 4: scene.friction = '1111"),
        ("9" * 400 + ".0", ", line 4: scene.friction = '9999"),
        ("a\0b", " is not YAML at line 4: the character #x0000 is none of a text"),
        ('"\\e[31m"', r", line 4: scene.friction = '\x1b[31m' is a string"),
        ("*a", " is not YAML at line 4: *a stands for a value elsewhere"),
        ("? [a]\n: b", " is not YAML at line 4:"),
    ],
)
def test_values_that_are_none_are_told_with_file_line_and_name(tmp_path, bag, capsys, value, told):
    path = config(tmp_path, f"scene:\n      friction: {value}")
    assert main(["replay", str(bag), "--config", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"peg-on-hole: error: {path}{told}")
    shown = re.search(r"scene\.friction = (.*?) is a", line)
    assert shown is None or len(shown[1]) <= 80


def test_a_file_without_end_is_no_parameters_file(bag, capsys):
    told = "/dev/zero is larger than 1048576 bytes, so that it is no parameters file"
    fails(capsys, 2, told, "inspect", bag, "--config", "/dev/zero")


@pytest.mark.parametrize("outer", ["/*", "/**", "/cell"])
def test_a_part_below_a_wildcard_is_for_the_node_as_for_ros(tmp_path, bag, outer):
    path = tmp_path / "c.yaml"
    path.write_text(
        f"{outer}:\n  peg_on_hole:\n    ros__parameters: {{scene: {{peg_mass: 0.75}}}}\n"
    )
    out = tmp_path / "out.mcap"
    assert main(["replay", str(bag), "--config", str(path), "--out", str(out)]) == 0
    assert Bag(out).metadata[CONFIGURATION_METADATA]["scene.peg_mass"] == "0.75"


def test_file_names_that_are_no_text_or_a_formula(tmp_path, bag, capfdbinary):
    for name, shown in ((b"M\xfc.mcap", r"M\xfc.mcap"), (rb"a$\frac{1}$b.mcap",) * 2):
        shown = shown if isinstance(shown, str) else shown.decode()
        path = os.path.join(os.fsencode(tmp_path), name)
        shutil.copy(bag, path)
        page, summary = tmp_path / "r.html", tmp_path / "s.json"
        path = os.fsdecode(path)
        assert main(["inspect", path]) == 0
        told = ["--report", str(page), "--summary", str(summary)]
        assert main(["replay", path, *told]) == 0
        out, err = capfdbinary.readouterr()
        assert err == b"" and out.decode("ascii").count(f"{tmp_path}/{shown}") == 2
        assert f"{tmp_path}/{shown}" in page.read_text(encoding="utf-8")
        assert json.loads(summary.read_text())["bag"] == f"{tmp_path}/{shown}"


def test_letters_that_a_terminal_cannot_show_are_escaped(tmp_path, bag, monkeypatch):
    shutil.copy(bag, tmp_path / "ü.mcap")
    monkeypatch.setenv("PYTHONIOENCODING", "ascii:strict")
    done = command("inspect", "ü.mcap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("\\xfc.mcap: 90 messages")


def test_names_in_a_bag_do_not_reach_the_terminal_as_orders(tmp_path, capsys):
    path = tmp_path / "topics.mcap"
    names = ["/\x1b]0;pwned\x07\x1b[31mred", "/a\nFAKE LINE: all good", "/\x9b2J\x7f"]
    with BagWriter(path) as writer:
        for topic in names:
            writer.write(topic, STRING, {"data": "x"}, 1)
    assert main(["inspect", str(path)]) == 0
    out, err = capsys.readouterr()
    assert main(["replay", str(path)]) == 3
    more = capsys.readouterr()
    for text in (out, err, more.out, more.err):
        assert not OBEYED.search(text)
        assert not any(line.startswith("FAKE LINE") for line in text.splitlines())
    rows = [line for line in out.splitlines() if line.startswith("/") and "std_msgs" in line]
    assert len(rows) == len(names)


def test_frames_in_a_bag_do_not_reach_the_terminal_as_orders(tmp_path, capsys):
    path = tmp_path / "frames.mcap"
    with BagWriter(path) as writer:
        for i in range(50):
            t_ns = 10**9 + i * MS
            message = wrench(t_ns)
            message["header"]["frame_id"] = ("\x1b[31mred", "a\nFAKE LINE: all good")[i % 2]
            writer.write("/wrench", WRENCH, message, t_ns)
            writer.write("/joint_states", JOINTS, joints(t_ns), t_ns)
    for name in ("inspect", "replay"):
        assert main([name, str(path)]) == 0
        out = capsys.readouterr().out
        assert r"\x1b[31mred" in out and r"a\nFAKE LINE" in out
        assert not OBEYED.search(out) and "\nFAKE LINE" not in out


@pytest.mark.parametrize(
    ("stated", "told"),
    [
        ({"scene.friction": "[" * 100_000}, "a value lies deeper within others than"),
        ({"scene.friction": "1" * 5000}, "Exceeds the limit (4300 digits)"),
        ({"scene.friction": "0x1"}, "Extra data"),
        ({"scene.gravity": "[[[]]]"}, "scene.gravity = [[[]]] has 1 values, not 3"),
        ({"filter.gate_reset_count": "9" * 400}, "filter.gate_reset_count = 9.22337e+18 is not"),
        ({"a\n\x1b[1m": "1"}, r"unknown parameter 'a\\n\\x1b[1m'"),
    ],
)
def test_a_configuration_in_a_bag_that_is_none(tmp_path, capsys, stated, told):
    path = tmp_path / "a.mcap"
    with BagWriter(path, metadata={CONFIGURATION_METADATA: stated}) as writer:
        writer.write("/wrench", WRENCH, wrench(MS), MS)
        writer.write("/joint_states", JOINTS, joints(MS), MS)
    assert main(["replay", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    begin = f"peg-on-hole: error: the configuration in {path} cannot be used ("
    assert line.startswith(begin + told.replace("\\\\", "\\"))
    # All else that the bag holds is told.
    assert main(["inspect", str(path)]) == 0
    assert "cannot be used (" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("urdf", "told"),
    [
        ("/dev/zero", "/dev/zero is no regular file"),
        ("~nobody_at_all/x.urdf", "there is no user for '~nobody_at_all'"),
        ("a\0b", r" = 'a\x00b' is no name of a file"),
    ],
)
def test_a_bag_cannot_have_a_device_or_nobodys_file_opened(tmp_path, capsys, urdf, told):
    path = tmp_path / "a.mcap"
    robot = {"joints.source": "robot", "joints.urdf": urdf, "joints.tip_frame": "t"}
    stated = {name: json.dumps(value) for name, value in robot.items()}
    with BagWriter(path, metadata={CONFIGURATION_METADATA: stated}) as writer:
        writer.write("/wrench", WRENCH, wrench(MS), MS)
        writer.write("/joint_states", JOINTS, joints(MS), MS)
    assert main(["replay", str(path)]) == 2
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith("peg-on-hole: error: the configuration in ") and told in line


def write_raw(path, texts, more=()):
    """Write a bag whose definitions are as given, and other topics with bytes of their own."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile="ros2", library="test")
        channels = {}
        rows = [("/wrench", WRENCH), ("/joint_states", JOINTS), *((t, k) for t, k, _ in more)]
        for topic, kind in rows:
            text = texts.get(topic) or definition(kind)
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channels[topic] = writer.register_channel(topic, "cdr", schema)
        for i in range(50):
            t_ns = 10**9 + i * MS
            data = [(topic, payload) for topic, _, payload in more]
            data += [("/wrench", Encoder(WRENCH)(wrench(t_ns)))]
            data += [("/joint_states", Encoder(JOINTS)(joints(t_ns)))]
            for topic, payload in data:
                writer.add_message(channels[topic], t_ns, payload, t_ns)
        writer.finish()
    return path


@pytest.mark.parametrize(
    "text",
    [
        f"WrenchStamped a\n{LINE}\nMSG: geometry_msgs/WrenchStamped\nWrenchStamped a\n",
        f"A a\n{LINE}\nMSG: geometry_msgs/A\nB b\n{LINE}\nMSG: geometry_msgs/B\nA a\n",
    ],
)
def test_a_definition_that_contains_itself_makes_its_messages_unreadable(tmp_path, capsys, text):
    path = write_raw(tmp_path / "a.mcap", {"/wrench": text})
    assert main(["inspect", str(path)]) == 0
    assert "dropped, /wrench: unreadable: 50" in capsys.readouterr().out
    assert main(["replay", str(path)]) == 3
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("peg-on-hole: error: ") and "no wrench of 50 could be used" in line


def test_truth_without_headers_is_no_truth_and_no_reason_to_refuse_the_estimate(tmp_path, capsys):
    text = Encoder(STRING)({"data": "three_point"})
    more = [(f"/truth/{name}", JOINTS, text) for name in ("state", "contacts")]
    more += [("/truth/contact_mode", STRING, text)]
    texts = dict.fromkeys(("/truth/state", "/truth/contacts"), "string a")
    path = write_raw(tmp_path / "a.mcap", texts, more)
    assert main(["replay", str(path)]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"no comparison with the truth: {path}: the definition of /truth/state")


def test_a_fault_of_the_program_is_one_line_and_its_traceback_on_request(capsys, monkeypatch):
    def fault():
        raise KeyError("a\x1b[31m\nb")

    assert exit_code(fault) == INTERNAL
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "peg-on-hole: error: a fault of the program, please report it: KeyError: "
        r"'a\x1b[31m\nb' at test_cli_hostile.py:"
    )
    monkeypatch.setenv(TRACEBACK, "1")
    assert exit_code(fault) == INTERNAL
    assert "Traceback" in capsys.readouterr().err


def test_a_library_that_keeps_the_stream_resets_the_terminal_at_exit(capsys):
    """As colorama does, which numba loads: its escape is for the terminal, and no text."""
    with ignore_broken_pipes():
        kept = sys.stdout
        kept.write("\x1b[0m within")
    kept.write("\x1b[0m")
    assert capsys.readouterr().out == "\\x1b[0m within\x1b[0m"
