"""`peg-on-hole calibrate --presses`: sensor_rpy and acts_on from three presses of a hand."""

from collections import Counter

from peg_on_hole_ros.bags.reader import Bag, absolute
from peg_on_hole_ros.cli.progress import ProgressBar
from peg_on_hole_ros.cli.sound_samples import sound_wrenches, take_wrench
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.presses import find_axes
from peg_on_hole_ros.messages.decode import WRENCH_TYPE
from peg_on_hole_ros.records import WrenchSample


def found_axes(bag: Bag, configuration: Configuration, left_out: Counter[str]) -> tuple[dict, str]:
    """
    Return the parameters that three presses tell, and the text to print.

    Parameters
    ----------
    bag : Bag
    configuration : Configuration
    left_out : Counter
        Counted up: wrenches that are left out, by reason.

    Raises
    ------
    BagError
        There is no wrench.
    PegOnHoleError
        As `find_axes`.

    """
    types = {absolute(configuration.topics.wrench): WRENCH_TYPE}
    bag.require(types)
    total = sum(bag.topics[topic].count for topic in types)
    samples: list[WrenchSample] = []
    with ProgressBar("decoding") as progress:
        for count, item in enumerate(bag.items(types)):
            progress(count / total)
            take_wrench(item.sample, samples, left_out)
    found = find_axes(sound_wrenches(samples, left_out))
    rpy = [round(angle, 6) + 0.0 for angle in found.rpy]
    lines = [
        f"three presses of {', '.join(f'{force:.0f}' for force in found.forces)} N: up, x, y",
        f"wrench.acts_on: {found.acts_on}",
        f"wrench.sensor_rpy: {rpy}",
        f"the hand missed its directions by {found.missed:.0f} degrees"
        + (f", and the nearest quarter turn by {found.turned:.0f}" if found.turned else ""),
    ]
    return {"wrench.acts_on": found.acts_on, "wrench.sensor_rpy": rpy}, "\n".join(lines)
