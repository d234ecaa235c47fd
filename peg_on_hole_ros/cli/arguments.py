"""Arguments of `peg-on-hole`: commands, options, help texts."""

import argparse
import re

from peg_on_hole_ros import __version__
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import cut, printable
from peg_on_hole_ros.startup.exit_codes import PROGRAM

# What begins so is a number, which argparse takes for an option where more follows it: `-3%`.
_NEGATIVE = re.compile(r"-(\.?\d|inf|nan)")
# Of what is said of an argument, before the usage [characters].
_LONGEST_MESSAGE = 300


class _Parser(argparse.ArgumentParser):
    """Tells what is wrong with arguments in one line, with the usage of the command meant."""

    def error(self, message):
        """Refuse the arguments."""
        usage = " ".join(self.format_usage().split())
        # What was given may be longer than any usage.
        raise PegOnHoleError(f"{cut(printable(message), _LONGEST_MESSAGE)}; {usage}")

    def parse_known_args(self, args=None, namespace=None):
        """Parse; a command refuses itself what it does not know, else the top would, for it."""
        parsed, rest = super().parse_known_args(args, namespace)
        if rest and self.prog not in (PROGRAM, f"{PROGRAM} node"):
            self.error(f"unrecognized arguments: {' '.join(rest)}")
        return parsed, rest


_PROGRAM_DESCRIPTION = """\
Estimate the contact state of a cylindrical peg that a robot inserts into a hole: angles, reactions
at the three contact points, transition to two-point contact and risk of jamming. Inputs are
wrench and joint states."""

_EPILOG = """\
BAG is an .mcap or .db3 file (also .zstd) or a rosbag2 folder. CONFIG is a ROS 2 parameters file.
Without one, replay, inspect and calibrate use the configuration in the bag. If the bag has none,
and in all other commands, the defaults of config/peg_on_hole.yaml are used.
exit codes: 0 done; 2 bad arguments or configuration; 3 bag unreadable or without the needed
topics (inspect needs none); 4 ended early on a cut-off or damaged bag, with what was read kept;
70 a fault of the program"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of all subcommands."""
    top = _Parser(
        prog=PROGRAM,
        description=_PROGRAM_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for add in (
        _replay, _simulate, _solve, _plan, _choose, _chart, _stability, _inspect, _setup,
        _calibrate, _compare, _node, _play, _watch,
    ):  # fmt: skip
        add(commands)
    return top


def _command(commands, name, text, example):
    return commands.add_parser(
        name,
        help=text,
        description=text[0].upper() + text[1:] + ".",
        epilog=f"example:\n{example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _config(command, **more):
    command.add_argument("--config", metavar="CONFIG", help="ROS 2 parameters file", **more)


def _bag(command, many=False):
    what = ".mcap or .db3 file (also .zstd of it), or rosbag2 folder"
    if many:
        command.add_argument(
            "bags",
            metavar="BAG",
            nargs="+",
            help=f"{what}; for many bags also folders and patterns",
        )
    else:
        command.add_argument("bag", metavar="BAG", help=what)
    for name, what in (("wrench", "wrench"), ("joints", "joint states")):
        command.add_argument(
            f"--{name}-topic",
            metavar="TOPIC",
            help=f"topic of the {what}; has precedence over the configuration",
        )
    _max_chunk(command)
    command.add_argument(
        "--bag-urdf",
        action="store_true",
        help="allow the configuration in the bag to name the file that is read as URDF",
    )


def _max_chunk(command):
    command.add_argument(
        "--max-chunk",
        metavar="MIB",
        type=float,
        default=64.0,
        help="largest size of a chunk when unpacked [MiB]; default 64",
    )


def _replay(commands):
    command = _command(
        commands,
        "replay",
        "run the estimator over a bag, as the node would have run",
        "  peg-on-hole replay bags/working_cycle.mcap --out estimate.mcap --summary summary.json\n"
        "  peg-on-hole replay recordings/ --jobs 4 --out night --report",
    )
    command.epilog += (
        "\n\nSeveral BAGs, --jobs or --dask: each bag's summary and report go into a folder of "
        "its own in DIR,\na table of all tries into bags.csv and bags.parquet, a page into "
        "index.html. A bag that is done is\nnot replayed again unless bag, settings or program "
        "change. The exit code is the worst of all bags,\nin the order 0, 4, 3, 2, 70."
    )
    _bag(command, many=True)
    _config(command)
    command.add_argument(
        "--out",
        metavar="OUT.mcap|DIR",
        help="write the node's topics: a file, or, without .mcap, a rosbag2 folder; for many bags "
        "a folder with the results of each",
    )
    command.add_argument(
        "--report",
        metavar="REPORT.html",
        nargs="?",
        const=True,
        help="write a page with plots; for many bags one page each: give no name",
    )
    command.add_argument("--summary", metavar="SUMMARY.json", help="write the figures as JSON")
    command.add_argument(
        "--cycles", metavar="CYCLES.jsonl", help="write a record of each try, a line of JSON each"
    )
    command.add_argument(
        "--smooth", action="store_true", help="add the smoothed state to OUT.mcap (offline only)"
    )
    command.add_argument(
        "--jobs", metavar="N", type=int, help="many bags: processes that replay them; default 1"
    )
    command.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="many bags: scheduler of a dask cluster that replays them",
    )
    command.add_argument(
        "--estimates", action="store_true", help="many bags: also write the node's topics of each"
    )


def _simulate(commands):
    command = _command(
        commands,
        "simulate",
        "simulate a bag with known truth: a compliant holder inserts the peg into the hole",
        "  peg-on-hole simulate --config config/working_cycle.yaml --out working_cycle.mcap",
    )
    _config(command, required=True)
    command.add_argument("--out", metavar="BAG.mcap", required=True, help="bag to write")


def _solve(commands):
    command = _command(
        commands,
        "solve",
        "solve for a motion from forces, forces for a motion, or any mix, at one state",
        "  peg-on-hole solve --state 0.2,0,0,-0.16,0,2 --wrench 0,0,-10,0,0.3,0 --json\n"
        "  peg-on-hole solve --state 0.2,0,0,-0.16,0,2 --frame auxiliary \\\n"
        "      --unknown N_K,N_B1,N_B2,M_h,M_e,M_z --known F_z=-10",
    )
    _config(command)
    command.add_argument(
        "--state",
        required=True,
        metavar="G,P,F,DG,DP,DF",
        help="gamma, psi, phi [rad] and their rates [rad/s]",
    )
    command.add_argument(
        "--wrench",
        metavar="FX,FY,FZ,MX,MY,MZ",
        help="on the peg at its mass centre, hole axes, without gravity [N], [N m]; default 0",
    )
    command.add_argument(
        "--unknown",
        metavar="NAME,...",
        help="quantities to solve for, one to six of: ddgamma, ddpsi, ddphi [rad/s^2], N_K, "
        "N_B1, N_B2 [N], F_x, F_y, F_z [N], M_x, M_y, M_z [N m] of the applied wrench at the "
        "mass centre",
    )
    command.add_argument(
        "--known",
        metavar="NAME=VALUE,...",
        action="append",
        help="with --unknown: values of the other quantities; a quantity that is not named is 0",
    )
    command.add_argument(
        "--frame",
        choices=("hole", "auxiliary", "moving", "peg"),
        help="with --unknown: axes of the wrench: hole (x, y, z; the default), auxiliary "
        "(h, e, z), moving (eps, eta, zeta) or peg (1, 2, 3)",
    )
    command.add_argument("--json", action="store_true", help="print JSON")


def _plan(commands):
    command = _command(
        commands,
        "plan",
        "find closing, slip and slide rates that keep loads and wedging under limits",
        "  peg-on-hole plan --config config/plan_cell.yaml --out plan",
    )
    command.epilog += (
        "\n\nThe groups scene, plan and monitor.max_normal of CELL.yaml describe the cell. If no "
        "motion keeps\nthe limits, the answer names the changes that would make one possible, and "
        "the exit code is 0."
    )
    command.add_argument(
        "--config", metavar="CELL.yaml", required=True, help="ROS 2 parameters file"
    )
    command.add_argument(
        "--out",
        metavar="DIR",
        help="folder for plan.json, plan.png and plan.svg; it is made if missing",
    )
    command.add_argument("--json", action="store_true", help="print JSON")


def _choose(commands):
    command = _command(
        commands,
        "choose",
        "find the cheapest method and the lowest rate of the wrench that are enough for a cell",
        "  peg-on-hole choose --config config/plan_cell.yaml --out choose\n"
        "  peg-on-hole choose --config CELL.yaml --bag recording.mcap --within 5%",
    )
    command.epilog += (
        "\n\nThe motion is that of the recording, simulated again. Without a recording it is that "
        "of a section\nsimulation: of CELL.yaml, and without this the one that peg-on-hole plan "
        "finds. Sensors have the\nnoise that CELL.yaml states. If no combination is enough, the "
        "answer names the nearest one, and the\nexit code is 0."
    )
    command.add_argument(
        "--config", metavar="CELL.yaml", required=True, help="ROS 2 parameters file"
    )
    command.add_argument("--bag", metavar="RECORDING", help="recording with the motion")
    for name, default, what in (
        ("--within", "3%", "the reactions, relative to their mean"),
        ("--rate-within", "10%", "the tilt's rate, relative to its own size"),
    ):
        command.add_argument(
            name, metavar="SHARE", default=default,
            help=f"tolerance of {what} (default {default})".replace("%", "%%"),
        )  # fmt: skip
    command.add_argument(
        "--flag-within", metavar="MS", type=float, default=10.0,
        help="tolerance of the time of the transition, early or late [ms] (default 10)",
    )  # fmt: skip
    command.add_argument(
        "--rate", metavar="HZ", type=int, default=1000,
        help="rate of the wrench if there is no recording [Hz] (default 1000)",
    )  # fmt: skip
    command.add_argument(
        "--seeds", metavar="N", type=int, default=12, help="draws of the noise (default 12)"
    )
    command.add_argument(
        "--out", metavar="DIR",
        help="folder for choose.yaml (the setting), choose.png and choose.svg; it is made if "
        "missing",
    )  # fmt: skip


def _chart(commands):
    command = _command(
        commands,
        "chart",
        "compute the error of the estimators against their computing time for a wrench",
        "  peg-on-hole chart --out chart",
    )
    _study(command)


def _stability(commands):
    command = _command(
        commands,
        "stability",
        "map where estimators keep their bounds, exceed them or diverge",
        "  peg-on-hole stability --out stability --quick",
    )
    _study(command)


def _study(command):
    command.add_argument(
        "--out",
        metavar="DIR",
        required=True,
        help="folder for PNG, SVG and CSV; it is made if missing",
    )
    command.add_argument(
        "--quick", action="store_true", help="coarser; takes less than two minutes"
    )
    _config(command)


def _inspect(commands):
    command = _command(
        commands,
        "inspect",
        "report topics, rates, gaps and clock trouble of a bag, and what a replay would use",
        "  peg-on-hole inspect recording/\n"
        "  peg-on-hole inspect recording/ --config cell.yaml --observability",
    )
    _bag(command)
    _config(command)
    command.add_argument(
        "--observability",
        action="store_true",
        help="run the filter, and list which parameters the motion determines",
    )
    command.add_argument("--json", action="store_true", help="print JSON")


def _setup(commands):
    command = _command(
        commands,
        "setup",
        "make the settings of a cell from questions and recordings, each with its origin",
        "  peg-on-hole setup --out cell.yaml\n"
        "  peg-on-hole setup --yes --from bags/setup_cell --config bags/setup_cell/stated.yaml "
        "--out cell.yaml",
    )
    command.epilog += (
        "\n\nAn answer may have a unit: 30 mm, 25 deg, 350 g. Ctrl-D or Ctrl-C ends the set-up; "
        "what was found\nis kept in OUT. Exit code 2: a recording contradicts a stated "
        "setting; OUT is written also then."
    )
    command.add_argument(
        "--out", metavar="OUT.yaml", default="cell.yaml", help="file to write; default cell.yaml"
    )
    command.add_argument("--config", metavar="START.yaml", help="settings that are stated already")
    command.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        help="state one more setting; the value may have a unit, such as 30mm",
    )
    command.add_argument("--urdf", metavar="FILE", help="the robot's description")
    for kind, what in (
        ("plate", "the peg pressing on the plate at three places and more around the hole"),
        ("presses", "three presses of a hand on the hanging peg: up, along x, along y"),
        ("poses", "the hanging peg still at four tilts"),
        ("hang", "the peg hanging still above the hole"),
        ("run", "an insertion"),
    ):
        command.add_argument(f"--{kind}", metavar="BAG", help=what)
    command.add_argument(
        "--from",
        dest="folder",
        metavar="FOLDER",
        help="folder with plate, presses, poses, hang, run and the URDF, as far as it has them",
    )
    command.add_argument(
        "--yes", action="store_true", help="ask no questions: use what is given, and defaults"
    )
    _max_chunk(command)
    # Topics are stated by --set, and no configuration in a bag is used.
    command.set_defaults(wrench_topic=None, joints_topic=None, bag_urdf=False)


def _calibrate(commands):
    command = _command(
        commands,
        "calibrate",
        "estimate friction, biases, noise, delay, hole tilt and clearance from a recording",
        "  peg-on-hole calibrate recording.mcap --out calibrated.yaml\n"
        "  peg-on-hole replay recording.mcap --config calibrated.yaml",
    )
    _bag(command)
    command.add_argument(
        "--out", metavar="CONFIG.yaml", required=True, help="configuration to write"
    )
    command.add_argument("--config", metavar="START.yaml", help="configuration to start from")
    instead = command.add_mutually_exclusive_group()
    instead.add_argument(
        "--payload",
        action="store_true",
        help="find payload and bias instead, from a peg that hangs free and still at three tilts "
        "or more",
    )
    instead.add_argument(
        "--presses",
        action="store_true",
        help="find wrench.acts_on and sensor_rpy instead, from three pushes of a hand on the "
        "still peg: up at its lower end, along its x, along its y",
    )


def _compare(commands):
    command = _command(
        commands,
        "compare",
        "report the differences of two outputs, or of one bag under two configurations",
        "  peg-on-hole compare before.mcap after.mcap\n"
        "  peg-on-hole compare low_friction.yaml high_friction.yaml --bag recording.mcap",
    )
    command.add_argument("a", metavar="A", help="output of replay or node; with --bag: CONFIG")
    command.add_argument("b", metavar="B", help="the other")
    command.add_argument(
        "--bag", metavar="BAG", help="replay this bag with A and with B, and compare the results"
    )
    command.add_argument(
        "--prefix",
        metavar="NODE",
        action="append",
        help="node to compare if a recording has several, such as /cell/peg_on_hole; twice: "
        "A's and B's",
    )
    command.add_argument(
        "--report", metavar="REPORT.html", help="write a page that draws both over each other"
    )
    command.add_argument("--json", action="store_true", help="print JSON")


def _node(commands):
    command = _command(
        commands,
        "node",
        "start the ROS 2 node; the same as `ros2 run peg_on_hole_ros peg_on_hole`",
        "  peg-on-hole node --config config/peg_on_hole.yaml\n"
        "  peg-on-hole node --config cell.yaml --ros-args -r __ns:=/cell -p scene.friction:=0.3",
    )
    _config(command)
    # For the help alone: _parsed keeps what is for ROS from argparse.
    command.add_argument("--ros-args", nargs="...", metavar="...", help="all arguments for ROS 2")


def _play(commands):
    command = _command(
        commands,
        "play",
        "publish a bag's wrench and joint states for a running node, as a robot would",
        "  peg-on-hole play bags/working_cycle.mcap\n"
        "  peg-on-hole play recording/ --config cell.yaml --start 12 --rate 0.5 --loop",
    )
    _bag(command)
    _config(command)
    command.add_argument(
        "--rate", metavar="R", type=float, default=1.0,
        help="pace relative to the recording, 0.01 to 10; default 1",
    )  # fmt: skip
    command.add_argument(
        "--start", metavar="S", type=float, default=0.0,
        help="time of the recording at which to start [s]; default 0",
    )  # fmt: skip
    command.add_argument(
        "--loop", action="store_true", help="begin again at the end, until Ctrl-C"
    )


def _watch(commands):
    command = _command(
        commands,
        "watch",
        "serve a live page of a running node, to this machine only unless --host is given",
        "  peg-on-hole watch\n  peg-on-hole watch --node /cell/peg_on_hole --port 9000\n"
        "  peg-on-hole watch --foxglove",
    )
    command.add_argument(
        "--node",
        metavar="NAME",
        default="/peg_on_hole",
        help="full name of the node; default /peg_on_hole",
    )
    command.add_argument(
        "--port",
        metavar="P",
        type=int,
        help="port to listen on; default 8470, for Foxglove 8765; 0: any free port",
    )
    command.add_argument(
        "--foxglove",
        action="store_true",
        help="serve the node's topics to the Foxglove app in place of a page",
    )
    command.add_argument(
        "--host",
        metavar="ADDRESS",
        default="127.0.0.1",
        help="address to listen on; default 127.0.0.1. With another one, all who reach it see "
        "the page",
    )


def parsed(arguments: list[str]) -> argparse.Namespace:
    """
    Return what is asked for, its `command` among it.

    Raises
    ------
    PegOnHoleError
        The arguments cannot be used; with the usage of the command that is meant.

    """
    if arguments[:1] != ["node"]:
        return parser().parse_args(_joined(arguments))
    own, ros = _apart(arguments)
    node, others = parser().parse_known_args(own)
    # The node refuses the others: it is started by `ros2 run` as well.
    return argparse.Namespace(command="node", config=node.config, others=others, ros=ros)


def _apart(arguments):
    """Return own arguments, and those of ROS: from `--ros-args` to `--` or the end."""
    own, ros, inside = [], [], False
    for word in arguments:
        inside |= word == "--ros-args"
        (ros if inside else own).append(word)
        inside &= word != "--"
    return own, ros


def _joined(arguments):
    """Return arguments in which a number below zero is one with the option before it."""
    joined: list[str] = []
    for word in arguments:
        before = joined[-1] if joined else ""
        option = before.startswith("--") and before != "--" and "=" not in before
        if option and _NEGATIVE.match(word):
            joined[-1] = f"{before}={word}"
        else:
            joined.append(word)
    return joined
