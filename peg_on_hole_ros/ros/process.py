"""Start, loop and exit of the node's process."""

import os
import re
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from peg_on_hole_ros.config.configuration import check
from peg_on_hole_ros.config.parameters_file import NoPart, check_no_pipe, read_parameters
from peg_on_hole_ros.config.ros_yaml import load
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.startup.library_output import held_back

# Messages worked off, at up to some ms each, before what has come meanwhile is taken.
MOST_WORK = 8
_FILE_ERROR = re.compile(r"'--params-file (.+)'\. Error: ", re.DOTALL)
_RULE_ERROR = re.compile(r"'-p (.*)'\. Error: ", re.DOTALL)
_NAMED_RULE = re.compile(r"(?:[^:]*:(?!=))?([^:]+):=(.*)", re.DOTALL)
# For what lies outside this node's part of a file.
_REMEDY_BY_MESSAGE = {
    "Sequence should be of same type": "a list holds doubles or integers, not both: write 1.0 "
    "for 1; y, n, yes, no, on and off are bools, unless within quotes",
    "No value at": "a name has no value: give it one, or take the line out",
    "Cannot have a value before ros__parameters": "below the name of each node there is "
    "ros__parameters:, and below that its parameters",
    "Will not support aliasing": "ROS 2 reads no anchors: write the value out",
}


def init(arguments: list[str]) -> None:
    """
    Start ROS 2.

    Parameters
    ----------
    arguments : list of str
        Of the process, without its name.

    Raises
    ------
    PegOnHoleError
        Arguments that ROS 2 cannot read, or that it would pass over.

    """
    for word, value in zip(arguments, arguments[1:]):
        if word == "--params-file":
            check_no_pipe(Path(value))
    try:
        # ROS 2 logs what it cannot read before it raises.
        with held_back():
            rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        # Parameters that ROS 2 itself cannot read; its traceback would hide which.
        text = str(error).removeprefix("failed to initialize rcl: ").split(", at ")[0]
        raise PegOnHoleError(explained(text)) from None
    others = remove_ros_args(arguments)
    if others:
        # ROS 2 leaves them to the program: a parameters file among them would have no effect.
        raise PegOnHoleError(
            f"unknown arguments: {' '.join(others)}; what is for ROS stands behind --ros-args, as "
            "in --ros-args --params-file CONFIG -p scene.friction:=0.3; `peg-on-hole node` takes "
            "--config CONFIG too"
        )


def leave(code: int) -> NoReturn:
    """
    End the process with this exit code, by what has been closed and destroyed so far.

    The end of Python destroys what is left of ROS 2 in an order of its own, at which DDS has been
    seen to wait for a thread forever: behind the line of an error, a launch would never end.
    """
    for stream in (sys.stdout, sys.stderr):
        # Whoever read them may be gone.
        with suppress(OSError):
            stream.flush()
    os._exit(code)


def spin(node: Any, stopping: list[int]) -> None:
    """
    Let a node take messages and work them off, until ROS ends or a signal is noted.

    A turn of the executor takes one message, or serves one call, in the order in which they came.
    So all that is there is taken before any of it is worked off, and again after a few: behind
    the messages of a node that is too slow no service would ever be answered, and nothing told.

    Parameters
    ----------
    node : Node
        With `arrivals`, which its subscriptions fill, `take_waiting`, which fills it with what
        they hold, and `process`, which works off so many.
    stopping : list of int
        Of `note_signals`.

    """
    executor = _executor()
    executor.add_node(node)
    while rclpy.ok() and not stopping:
        executor.spin_once(timeout_sec=0.0 if len(node.arrivals) else 0.1)
        # Whether more waits is asked of DDS: a turn that finds nothing takes 0.1 ms to say so.
        # Each message that is taken so leaves its turn behind, with calls between them.
        for _ in range(node.take_waiting()):
            executor.spin_once(timeout_sec=0.0)
        node.process(MOST_WORK)
    executor.remove_node(node)


def _executor():
    try:
        from rclpy.experimental import EventsExecutor  # a third of the other's CPU time
    except ImportError:
        return SingleThreadedExecutor()  # Jazzy has no other for Python
    return EventsExecutor()


def explained(text: str) -> str:
    """
    Return in one line why parameters are refused.

    Parameters
    ----------
    text : str
        What ROS 2 said: it has the file or the rule, but not what is wrong with which parameter.

    """
    file, rule = _FILE_ERROR.search(text), _RULE_ERROR.search(text)
    try:
        if file:
            read_parameters(file[1])
        elif rule:
            named = _NAMED_RULE.fullmatch(rule[1])
            if not named:
                return f"-p {rule[1]} is no rule for a parameter; write -p NAME:=VALUE"
            check({named[1]: load(named[2])})
    except NoPart:
        pass  # It is another program's file that ROS 2 does not read
    except PegOnHoleError as error:
        return f"-p {rule[1]}: {error}" if rule else str(error)
    remedies = [remedy for words, remedy in _REMEDY_BY_MESSAGE.items() if words in text]
    return "; ".join([text.strip(), *remedies])
