"""What ROS 2 cannot read of its parameters, in the words that every command has for it."""

import re

from peg_on_hole_ros.config.configuration import check
from peg_on_hole_ros.config.parameters_file import NoPart, read_parameters
from peg_on_hole_ros.config.ros_yaml import load
from peg_on_hole_ros.errors import PegOnHoleError

_FILE = re.compile(r"'--params-file (.+)'\. Error: ", re.DOTALL)
_RULE = re.compile(r"'-p (.*)'\. Error: ", re.DOTALL)
_NAMED = re.compile(r"(?:[^:]*:(?!=))?([^:]+):=(.*)", re.DOTALL)
# For what lies outside this node's part of a file.
_REMEDY_BY_MESSAGE = {
    "Sequence should be of same type": "a list holds doubles or integers, not both: write 1.0 "
    "for 1; y, n, yes, no, on and off are bools, unless within quotes",
    "No value at": "a name has no value: give it one, or take the line out",
    "Cannot have a value before ros__parameters": "below the name of each node there is "
    "ros__parameters:, and below that its parameters",
    "Will not support aliasing": "ROS 2 knows no anchors: write the value out",
}


def explained(text: str) -> str:
    """
    Return in one line why parameters are refused.

    Parameters
    ----------
    text : str
        What ROS 2 said: it has the file or the rule, but not what is wrong with which parameter.

    """
    file, rule = _FILE.search(text), _RULE.search(text)
    try:
        if file:
            read_parameters(file[1])
        elif rule:
            named = _NAMED.fullmatch(rule[1])
            if not named:
                return f"-p {rule[1]} is no rule for a parameter; write -p NAME:=VALUE"
            check({named[1]: load(named[2])})
    except NoPart:
        pass  # It is another program's file that ROS 2 does not read
    except PegOnHoleError as error:
        return f"-p {rule[1]}: {error}" if rule else str(error)
    remedies = [remedy for words, remedy in _REMEDY_BY_MESSAGE.items() if words in text]
    return "; ".join([text.strip(), *remedies])
