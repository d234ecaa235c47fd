"""Logarithmic axes with numbers as one writes them."""

from matplotlib.axes import Axes
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter


def write_plain_numbers(axis: Axes) -> None:
    """Mark 1, 2 and 5 of each decade of two logarithmic axes, as plain numbers, with a grid."""
    for part in (axis.xaxis, axis.yaxis):
        part.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
        part.set_major_formatter(FormatStrFormatter("%g"))
        part.set_minor_formatter(NullFormatter())
    axis.tick_params(labelsize=8)
    axis.grid(alpha=0.2)
