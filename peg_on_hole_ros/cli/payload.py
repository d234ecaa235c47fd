"""`peg-on-hole calibrate --payload`: what hangs below the sensor, and the sensor's zero."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from peg_on_hole_ros.cli.table import table
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.identification.payload import Payload, find_payload
from peg_on_hole_ros.identification.recording import Recording
from peg_on_hole_ros.number_text import number, quantity

# Of a normal distribution, 95 % on both sides.
INTERVAL_STDDEVS = 1.96


class FoundPayload(NamedTuple):
    """
    What still poses tell.

    Attributes
    ----------
    values : dict of str to object
        Parameters.
    text : str
        To print.
    payload : Payload

    """

    values: dict[str, object]
    text: str
    payload: Payload


def found_payload(record: Recording, configuration: Configuration) -> FoundPayload:
    """
    Return the parameters that a recording of still poses tells, and the text to print.

    Raises
    ------
    PegOnHoleError
        As `find_payload`.

    """
    # A zero or a payload that is stated is found anew, whole.
    wrench = replace(configuration.wrench, payload_mass=0.0)
    found = find_payload(record, replace(configuration, wrench=wrench))
    return FoundPayload(_parameters(found), _payload_text(found), found)


def _parameters(found: Payload):
    force, torque = found.bias[:3], found.bias[3:]
    values = {
        "wrench.bias_force": _list(force),
        "wrench.bias_torque": _list(torque),
        "wrench.bias_force_stddev": float(f"{_rms(found.bias_stddev[:3]):.2g}"),
        "wrench.bias_torque_stddev": float(f"{_rms(found.bias_stddev[3:]):.2g}"),
    }
    if np.isfinite(found.com).all():
        values["wrench.payload_mass"] = float(f"{found.mass:.5g}")
        values["wrench.payload_com"] = _list(found.com)
    else:
        values["wrench.payload_mass"] = 0.0
    return values


def _list(values):
    return [float(f"{value:.5g}") for value in values]


def _rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def _payload_text(found: Payload):
    rows = [("payload_mass", number(found.mass, 4), _spread(found.mass_stddev), "kg")]
    for name, values, spreads, unit in (
        ("payload_com", found.com, found.com_stddev, "m"),
        ("bias_force", found.bias[:3], found.bias_stddev[:3], "N"),
        ("bias_torque", found.bias[3:], found.bias_stddev[3:], "N m"),
    ):
        for axis, value, spread in zip("xyz", values, spreads):
            if np.isfinite(value):
                rows.append((f"{name} {axis}", number(value, 4), _spread(spread), unit))
    lines = [
        table(("", "likeliest", "95 % interval", "unit"), rows),
        "",
        f"{found.poses} still poses; residual of the forces {quantity(found.left, 'N', 2)} (root "
        "mean square)",
    ]
    if not np.isfinite(found.com).all():
        lines.append("no payload beside the peg is found")
    return "\n".join([*lines, *(f"missing: {line}" for line in found.missing)])


def _spread(stddev):
    return f"+- {number(INTERVAL_STDDEVS * stddev, 2)}"
