"""What the motion of a bag tells of the parameters, in words."""

from collections.abc import Callable
from dataclasses import replace
from math import degrees, isfinite

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.cli.calibration_text import SHOWN, WORDS
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.methods.registry import make_filter
from peg_on_hole_ros.identification.observability import (
    PARAMETER_NAMES,
    Observability,
    ObservingFilter,
)
from peg_on_hole_ros.identification.quantities import CALIBRATED_QUANTITIES
from peg_on_hole_ros.messages.stream import message_stream
from peg_on_hole_ros.number_text import number
from peg_on_hole_ros.replay.late_messages import in_order
from peg_on_hole_ros.replay.run import check_bag, hand_over, sources_of

UNITS = {quantity.name: quantity.unit for quantity in CALIBRATED_QUANTITIES}
_HANG = "hang it free for a second before it touches"
# What a motion has to be like to tell of a parameter, by the begin of its name.
REMEDIES = {
    "friction": "press the peg on three contacts while it slides and turns about its axis",
    "clearance": "close to 1.1 times gamma0 or less while it slides",
    "bias_force_z": f"press with changing forces while it slides, or {_HANG}",
    "bias_torque_z": f"turn the peg about its axis both ways, or {_HANG}",
    "bias": "turn the peg about its axis by 90 degrees and more, and lean it another way, or "
    f"{_HANG}",
    "tilt": "turn the direction in which the peg leans by 90 degrees and more",
}


def observe(
    bag: Bag, configuration: Configuration, progress: Callable[[float], None] = lambda share: None
) -> Observability:
    """
    Run the filter of a configuration over a bag, and return what its motion tells.

    Raises
    ------
    BagError
        A needed topic is missing or of another type.

    """
    needed, sources = check_bag(bag, configuration), sources_of(configuration)
    total = sum(bag.topics[topic].count for topic in needed)
    given, wrench = configuration, configuration.wrench
    runs = 2 if wrench.bias_force_stddev or wrench.bias_torque_stddev else 1

    def run(configuration, make, begun):
        stream = message_stream(configuration, 0.0, make)
        for count, item in enumerate(in_order(bag.items(needed, given.joints.names), given)):
            hand_over(stream, item, sources)
            if count % 256 == 0:
                progress((begun + count / total) / runs)
        return stream.pipeline.processor

    # What was gathered cannot be taken back for a message that comes late.
    options = replace(
        configuration.filter,
        method="mixture",
        late_window=0.0,
        wrench_bias="estimated",
    )
    joints = replace(configuration.joints, hole_tilt_stddev=0.0)
    configuration = replace(configuration, filter=options, joints=joints)
    if runs == 2:
        # Taken for none, a bias is a load on a peg that hangs free, and hides how contacts slip.
        learnt = run(configuration, make_filter, 0).bias.tolist()
        wrench = replace(
            wrench,
            bias_force=tuple(learnt[:3]),
            bias_torque=tuple(learnt[3:]),
            bias_force_stddev=0.0,
            bias_torque_stddev=0.0,
        )
    # The estimate only shows where to take the derivatives.
    configuration = replace(configuration, wrench=wrench)
    return run(configuration, ObservingFilter, runs - 1).filter.observability()


def content(found: Observability) -> dict:
    """Return it for JSON; what does not exist is null."""
    return {
        "seconds": found.seconds,
        "seconds_free": found.free,
        "turn": found.turn,
        "swing": found.swing,
        "rank": found.rank,
        "of": len(PARAMETER_NAMES),
        "condition": _finite(found.condition),
        "parameters": {
            name: {
                "unit": UNITS[name],
                "seen": bool(found.seen[i]),
                "stddev_alone": _finite(found.alone[i]),
                "stddev_together": float(found.together[i]),
                "useful": float(found.useful[i]),
                "looks_like": found.partner[i] or None,
            }
            for i, name in enumerate(PARAMETER_NAMES)
        },
    }


def _finite(value):
    return float(value) if isfinite(value) else None


def lines(found: Observability) -> list[str]:
    """Return what a cell engineer reads."""
    if not found.seconds:
        nothing = (
            "nothing: three contacts never slide together; the peg is not pressed on the rim "
            "above gamma0, or hardly moves"
        )
        if not found.seen.any():
            return [nothing]
        told = [_line(found, i) for i in range(len(PARAMETER_NAMES)) if found.seen[i]]
        return [f"{nothing}; {found.free:.2f} s in the air", *told]
    condition = f"{found.condition:.0f}" if isfinite(found.condition) else "above 1e7"
    text = [
        f"{found.rank} of {len(PARAMETER_NAMES)} combinations, over {found.seconds:.2f} s in "
        f"which all contacts slide and {found.free:.2f} s in the air; the peg turned by "
        f"{degrees(found.turn):.0f} degrees about its axis, and the direction of its lean by "
        f"{degrees(found.swing):.0f} degrees; condition number: {condition}"
    ]
    return text + [_line(found, i) for i in range(len(PARAMETER_NAMES))]


def _line(found, i):
    name = PARAMETER_NAMES[i]
    unit, factor = SHOWN.get(UNITS[name], (UNITS[name], 1.0))

    def size(value):
        return f"{number(factor * value, 2)} {unit}".strip()

    if found.seen[i]:
        return f"{WORDS[name]}: seen, to {size(found.together[i])}; it can be estimated"
    remedy = REMEDIES.get(name, REMEDIES[name.split("_")[0]])
    alone, together = found.alone[i], size(found.together[i])
    if not alone <= found.useful[i]:
        moved = "changes no measurement" if not isfinite(alone) else "changes them too little"
        return f"{WORDS[name]}: not seen ({together} at best), it {moved} here; {remedy}"
    alike = f"looks like {WORDS[found.partner[i]]}" if found.partner[i] else "looks like others"
    return (
        f"{WORDS[name]}: not determined ({together} at best, {size(alone)} if the others were "
        f"known), in this motion it {alike}; {remedy}"
    )
