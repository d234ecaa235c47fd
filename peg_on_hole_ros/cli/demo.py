"""
The demonstration behind `make run`: a bag is played into the real node over DDS.

It stays on this machine, in a DDS domain of its own. What the node publishes is kept as MCAP,
drawn as PNG and compared with the truth that the bag carries.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from peg_on_hole_ros.bags.estimates import estimates
from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.bags.score import Score, flag_lines, score_lines, score_table
from peg_on_hole_ros.bags.storage.bag_files import bag_files
from peg_on_hole_ros.bags.writer import configuration_metadata
from peg_on_hole_ros.cli.bag_and_configuration import open_bag, truth_in
from peg_on_hole_ros.cli.output_paths import check_output_paths, out_folder
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.config.configuration import to_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.config.parameters_file import write_parameters
from peg_on_hole_ros.errors import BagDamaged, BagError, PegOnHoleError
from peg_on_hole_ros.plots.series import Series
from peg_on_hole_ros.replay.run import check_bag, stored_configuration
from peg_on_hole_ros.ros.local_dds import environment, free_domain

BAG = "bags/working_cycle.mcap"
ANGLES_AND_REACTIONS = [0, 1, 2, 6, 7, 8]


def main(arguments: list[str] | None = None) -> int:
    """Play, compare, write; return the exit code."""
    parser = argparse.ArgumentParser(prog="make run", description=__doc__)
    parser.add_argument("bag", nargs="?", default=BAG, help=f"default {BAG}")
    parser.add_argument("--rate", type=float, default=1.0, help="pace; default 1, as recorded")
    parser.add_argument("--out", default="out", help="folder; default out")
    parsed = parser.parse_args(arguments)
    try:
        if not 0.01 <= parsed.rate <= 10:
            raise PegOnHoleError(f"--rate = {parsed.rate:g} is not within 0.01 to 10")
        run(parsed.bag, parsed.rate, parsed.out)
    except PegOnHoleError as error:
        print(f"make run: error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        return 130
    return 0


def run(path: str, rate: float, out: str) -> None:
    """
    Play the bag into a node that this starts; write MCAP, PNG and the node's log; print a table.

    Raises
    ------
    PegOnHoleError
        A bag that cannot be used, an empty path, a node that does not start.
    BagDamaged
        The bag is cut off or damaged; what lies before has been played.

    """
    bag = open_bag(path)
    configuration = stored_configuration(bag) or Configuration()
    check_bag(bag, configuration)
    folder, name = out_folder(out), bag.path.stem
    recorded, picture = folder / f"{name}.mcap", folder / f"{name}.png"
    places = [str(picture), str(folder / "node.log")]
    check_output_paths(bag_files(path).read(), [str(recorded)], places)
    wrenches, seconds = _play(bag, rate, folder, recorded, configuration)
    print(f"played {wrenches} wrenches in {seconds:.1f} s into the node over DDS")
    unfit = ", ".join(f"{count} on {topic}" for topic, count in bag.undecodable.items())
    if unfit:
        print(f"not played, as they do not fit their definition: {unfit}")
    _compare(bag, recorded, picture, configuration, wrenches)
    if bag.damage:
        raise BagDamaged(bag.damage)


def _with_urdf(configuration, path):
    """Return a configuration that names a file with the description that a bag brings."""
    joints = configuration.joints
    if not joints.description:
        return configuration
    path.write_text(joints.description, encoding="utf-8")
    return replace(configuration, joints=replace(joints, urdf=str(path)))


def _play(bag, rate, out, recorded, configuration):
    # Before rclpy is loaded: it reads these when it starts.
    os.environ.update(environment(free_domain()))
    from peg_on_hole_ros.ros.player import Player

    with tempfile.TemporaryDirectory() as folder, (out / "node.log").open("w") as log:
        configuration = _with_urdf(configuration, Path(folder) / "robot.urdf")
        parameters = Path(folder) / "parameters.yaml"
        parameters.write_text(write_parameters(to_parameters(configuration)), encoding="utf-8")
        command = [sys.executable, "-m", "peg_on_hole_ros.ros.node"]
        command += ["--ros-args", "--params-file", str(parameters)]
        node = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        topics = configuration.topics
        player = Player(absolute(topics.wrench), absolute(topics.joint_states), node)
        try:
            print("starting the node (its first start compiles the kernel)", flush=True)
            player.wait_for_node()
            print(f"playing {bag.path} at {rate:g} times its pace", flush=True)
            with ProgressBar("playing") as progress:
                played = player.play(bag, rate, progress)
            player.write(recorded, configuration_metadata(configuration))
        except BagError:
            raise
        except PegOnHoleError as error:
            raise PegOnHoleError(f"{error}; its log is {log.name}") from None
        finally:
            player.close()
            _stop(node)
    return played


def _stop(node):
    if node.poll() is None:
        node.send_signal(signal.SIGINT)
        try:
            node.wait(timeout=20)
        except subprocess.TimeoutExpired:
            node.kill()
            node.wait()


def _compare(bag, recorded, picture, configuration, wrenches):
    from peg_on_hole_ros.plots.replay import figure, png  # matplotlib loads slowly

    series, count = Series(), 0
    truth = truth_in(bag)
    score = Score(truth) if truth is not None else None
    for estimate in estimates(Bag(recorded)):
        count += 1
        values = estimate.values[ANGLES_AND_REACTIONS]
        stddev = estimate.stddev[ANGLES_AND_REACTIONS]
        series.row(estimate.t_ns, values, stddev, estimate.monitor)
        series.declared(estimate.t_ns, estimate.mode, estimate.transition)
        if score is not None:
            determined = estimate.monitor.get("reactions_determined") == 1.0
            declared = estimate.mode, estimate.transition
            score.row(estimate.t_ns, values, stddev, *declared, determined)
    if not count:
        raise PegOnHoleError(
            f"the node published no estimate; its log is {picture.parent}/node.log"
        )
    print(f"received {count} whole estimates for {wrenches} wrenches")
    if score is not None:
        head, *rows = score_table(score)
        print("\n" + table(head, rows, 2))
        print("\n".join([*score_lines(score), "", *flag_lines(score)]))
    title = f"{bag.path.name}, by the node over DDS"
    picture.write_bytes(png(figure(series, title, configuration.scene.gamma0, truth)))
    print(f"\nwrote {recorded} and {picture}")


if __name__ == "__main__":
    sys.exit(main())
