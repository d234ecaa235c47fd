"""First guess of the parameters: the estimator with friction, clearance and bias open."""

from dataclasses import replace
from math import inf, log

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.contact_filter import ContactFilter
from peg_on_hole_ros.estimator.contact_set import ContactSet
from peg_on_hole_ros.identification.accumulate import BEGIN, WRENCH
from peg_on_hole_ros.identification.likelihood import Likelihood
from peg_on_hole_ros.identification.quantities import (
    BIAS_AT,
    CLEARANCE_AT,
    FRICTION_AT,
    configured,
)
from peg_on_hole_ros.identification.tuned import FIRST_GUESS
from peg_on_hole_ros.measurements.wrench_reduction import WrenchReduction


def guess(likelihood: Likelihood, start: Configuration, x: np.ndarray, bias: float) -> np.ndarray:
    """
    Return coordinates nearer to what a recording shows, shape (14,); tilt and delay stay.

    Parameters
    ----------
    likelihood : Likelihood
        Of the parts to run over.
    start : Configuration
    x : ndarray, shape (14,)
        Where to begin.
    bias : float
        How far off that of the force may be [N]; that of the couple by as much at the rim.

    """
    x = x.copy()
    for _ in range(FIRST_GUESS.passes):
        configuration = configured(start, x)
        peg = _open(configuration, bias)
        events, now = likelihood.events(x, configuration), 0.0
        for t, kind, value, R, _ in zip(*events):
            if kind == BEGIN:
                peg.end_estimate()
                peg.start(value[:3], R)
                now = t
                continue
            if t > now:
                peg.predict(t - now)
                now = t
            if kind == WRENCH:
                peg.weigh(value, ContactSet.THREE)
            else:
                peg.correct(value[:3], R)
        x[FRICTION_AT] = max(peg.friction[0], 0.0)
        x[CLEARANCE_AT] = log(peg.clearance[0])
        x[BIAS_AT] += peg.bias
    return x


def _open(configuration: Configuration, bias: float) -> ContactFilter:
    scene, wrench = configuration.scene, configuration.wrench
    clearance = scene.hole_diameter - scene.peg_diameter
    scene = replace(
        scene,
        friction_stddev=FIRST_GUESS.friction_stddev,
        clearance_stddev=FIRST_GUESS.clearance_share * clearance,
    )
    wrench = replace(
        wrench,
        bias_force_stddev=bias,
        bias_torque_stddev=bias * scene.hole_diameter,
    )
    joints = replace(configuration.joints, hole_tilt_stddev=0.0, delay_stddev=0.0)
    options = replace(
        configuration.filter, friction="estimated", clearance="estimated",
        wrench_bias="estimated", gate_threshold=inf,
    )  # fmt: skip
    configuration = replace(configuration, scene=scene, wrench=wrench, joints=joints)
    configuration = replace(configuration, filter=options)
    reduction = WrenchReduction(wrench, scene)
    return ContactFilter(scene, options, reduction.covariance, reduction.offsets(configuration))
