"""A small peg whose contacts slip slowly, as it turns as fast as others: that is no stall."""

import pytest

from peg_on_hole_ros.config.configuration import from_parameters
from peg_on_hole_ros.engine.pipeline import Pipeline
from peg_on_hole_ros.monitor.states import AlarmLevel
from peg_on_hole_ros.sim.measure import measure
from peg_on_hole_ros.sim.plan import plan_from_tree
from peg_on_hole_ros.sim.truth import integrate
from tiers import nightly

SMALL = {
    "scene": {
        "hole_diameter": 0.006, "peg_diameter": 0.00598, "peg_height": 0.02, "peg_mass": 0.05,
        "friction": 0.2,
    },
    "wrench": {
        "sensor_xyz": [0.0, 0.0, 0.2], "force_stddev": 0.05, "torque_stddev": 0.002,
    },
}  # fmt: skip
SLOWER = {
    "scene": {
        "hole_diameter": 0.012, "peg_diameter": 0.01194, "peg_height": 0.04, "peg_mass": 0.15,
        "friction": 0.1,
    },
    "wrench": {
        "sensor_xyz": [0.0, 0.0, 0.15], "force_stddev": 0.1, "torque_stddev": 0.003,
    },
}  # fmt: skip


def flat(tree):
    return {f"{room}.{name}": value for room, of in tree.items() for name, value in of.items()}


@pytest.mark.parametrize(
    ("stated", "tilt", "rates", "offset", "stiffness"),
    [
        (SMALL, 0.17792, (-0.08, -0.08), (-3e-4, 0.0, -1e-3), (1e4, 200.0)),
        # Ever slower, and held at rest in the end.
        *nightly((SLOWER, 0.18605, (-0.1, -0.02, 0.0), (-2e-4, 0.0, -1e-3), (2e4, 2000.0))),
    ],
)
def test_a_program_that_turns_a_small_peg_slowly_is_no_stall(
    stated, tilt, rates, offset, stiffness
):
    configuration = from_parameters(flat(stated))
    first = [2.0 * rates[0] if len(rates) > 2 else rates[0], 0.0, 0.0]
    legs = {
        f"leg{i}": {"kind": "contact", "duration": 0.3, "rates": [rate, 0.0, 0.0]}
        for i, rate in enumerate(rates)
    }
    tree = {
        "lead_in": 0.05,
        "start": {"angles": [tilt, 0.0, 0.0], "rates": first, "offset": list(offset)},
        "phases": {"lead": {"kind": "contact", "duration": 0.05, "rates": first}, **legs},
        "holder": {
            "stiffness": stiffness[0], "rotational_stiffness": stiffness[1],
            "damping_ratio": 0.7, "force_limit": 600.0, "torque_limit": 60.0,
        },
    }  # fmt: skip
    truth = integrate(plan_from_tree(configuration, tree))
    for outputs in Pipeline(configuration).play(measure(truth, 1)):
        jamming = next(alarm for alarm in outputs.alarms if alarm.name == "jamming")
        assert jamming.level < AlarmLevel.ERROR, (outputs.t_ns, jamming.message)
