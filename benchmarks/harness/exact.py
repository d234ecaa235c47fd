"""Cells in which everything is as it is stated, as in most simulations."""

from dataclasses import replace

from peg_on_hole_ros.config.options import Accuracy, Configuration


def exactly(configuration: Configuration) -> Configuration:
    """Return what an estimator is told of a cell whose sensors, payload and sizes are exact."""
    return replace(configuration, accuracy=Accuracy.exact())
