"""The compiled filter and filterpy's on the numpy model, step by step over one bag."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np
from peg_on_hole_ros.estimation.filters.contact import ContactFilter, Prediction
from peg_on_hole_ros.estimation.filters.methods import make_filter
from peg_on_hole_ros.estimation.filters.offset import OffsetFilter
from peg_on_hole_ros.estimation.kernel.memory import part
from peg_on_hole_ros.estimation.reference.kalman import ReferenceFilter
from peg_on_hole_ros.estimation.reference.offsets import OffsetReference

from peg_on_hole_ros.edges.bags.reader import Bag
from peg_on_hole_ros.edges.messages.decode import joint_sample, wrench_sample
from peg_on_hole_ros.estimation.measurement import PegJoints, WrenchReduction
from peg_on_hole_ros.options import Configuration
from peg_on_hole_ros.records import JointSample


class Step(NamedTuple):
    """
    One wrench of a bag, reduced, and the orientation of the same stamp.

    Attributes
    ----------
    dt : float
        Since the wrench before [s].
    u : ndarray, shape (6,)
        Wrench on the peg about its mass centre, peg axes [N], [N m].
    q : ndarray, shape (3,), or None
        gamma, psi, phi [rad].
    R : ndarray, shape (3, 3), or None
        Covariance of q [rad^2].

    """

    dt: float
    u: np.ndarray
    q: np.ndarray | None
    R: np.ndarray | None


class Difference(NamedTuple):
    """
    What separates the two filters after one step; all without unit.

    Attributes
    ----------
    mean : float
        Largest difference in state and what is learnt, whitened by the reference.
    covariance : float
        Largest entry of L^-1 (P - P_ref) L^-T, P_ref = L L^T.
    reactions : float
        Largest difference of a reaction over its standard deviation.
    reactions_covariance : float
        Largest relative difference of a reaction's standard deviation.
    unbalance : float
        Largest difference of a whitened unbalance of forces; 1 where only one was weighed.
    seconds, reference_seconds : float
        What the step took.
    prediction : Prediction

    """

    mean: float
    covariance: float
    reactions: float
    reactions_covariance: float
    unbalance: float
    seconds: float
    reference_seconds: float
    prediction: Prediction


def bag_samples(path: str | Path, configuration: Configuration):
    """Yield the joint and wrench samples of a bag."""
    topics = configuration.topics
    for item in Bag(path).messages([topics.wrench, topics.joint_states]):
        decode = wrench_sample if item.topic == topics.wrench else joint_sample
        yield decode(item.message)


def bag_steps(path: str | Path, configuration: Configuration) -> list[Step]:
    """Return the steps of a bag whose joint states carry the stamps of wrenches."""
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    orientation = PegJoints(configuration.joints)
    waiting, steps, last = None, [], None
    for sample in bag_samples(path, configuration):
        if isinstance(sample, JointSample):
            waiting = orientation(sample)
            continue
        q = R = None
        if waiting is not None and waiting.t_ns == sample.t_ns:
            q, R = waiting.q, waiting.covariance
        u = reduction.on_peg(sample.force, sample.torque, q)
        steps.append(Step((sample.t_ns - (last or sample.t_ns)) * 1e-9, u, q, R))
        last = sample.t_ns
    return steps


def unguarded(configuration: Configuration) -> Configuration:
    """Return the configuration without gate and widening, which are no part of the comparison."""
    options = replace(configuration.filter, inflation_threshold=inf, gate_threshold=inf)
    return replace(configuration, filter=options)


def filters(configuration: Configuration, first: Step) -> tuple[ContactFilter, ReferenceFilter]:
    """Return both filters, started alike."""
    reduction = WrenchReduction(configuration.wrench, configuration.scene)
    scene, noise = configuration.scene, reduction.covariance
    offsets = reduction.offsets(configuration)
    kalman = make_filter(scene, configuration.filter, noise, offsets)
    kalman.start(first.q, first.R)
    if offsets.variance.any():
        reference = OffsetReference(scene, kalman.process, noise, offsets)
    else:
        reference = ReferenceFilter(scene, kalman.process, noise)
    reference.x[:12] = np.concatenate([kalman.x, kalman.u])
    carried = carried_states(kalman)
    reference.P[np.ix_(carried, carried)] = kalman.joint_covariance()
    known = np.setdiff1d(np.arange(reference.dim_x), carried)
    reference.P[known, known] = 0.0
    reference.begin_beside()
    return kalman, reference


def carried_states(kalman: ContactFilter) -> list[int]:
    """Return which states of the reference the filter carries."""
    offsets = range(kalman.active.start, kalman.active.stop) if _offset(kalman) else ()
    return [*range(14), *(14 + i for i in offsets)]


def in_hole_axes(kalman, step: Step):
    """Return the orientation of a step in the axes of the hole as a filter takes it to lie."""
    turn = getattr(kalman, "in_hole_axes", None)
    return turn(step.q, step.R) if turn else (step.q, step.R)


def _offset(kalman):
    return isinstance(kalman, OffsetFilter)


def compared(configuration: Configuration, steps: list[Step]) -> Iterator[Difference]:
    """Yield the difference of the two filters after each step but the first."""
    configuration = unguarded(configuration)
    kalman, reference = filters(configuration, steps[0])
    spread = configuration.filter.acceleration_stddev
    for step in steps[1:]:
        begun = perf_counter()
        kalman.hold(step.u)
        prediction = kalman.predict(step.dt, in_contact=True)
        unbalance = kalman.unbalance
        if step.q is not None:
            kalman.correct(*in_hole_axes(kalman, step))
        found = kalman.reactions()
        between = perf_counter()
        reference.hold(step.u)
        reference.learn_from_balance(step.dt, spread)
        if prediction is Prediction.CONTACT:
            reference.ramp_shares = part(kalman._memory, "RAMP")[6:]
            reference.predict_contact(step.dt, kalman.pieces)
        elif prediction in (Prediction.SLOW, Prediction.DOUBTED):
            reference.predict_slow(step.dt)
        elif prediction is Prediction.RUNAWAY:
            reference.predict_runaway(step.dt)
        elif prediction is Prediction.LIMITED:
            reference.predict_limited(step.dt, configuration.filter.free_rate_noise)
        else:
            reference.predict_without_step(step.dt, configuration.filter.free_rate_noise)
        if step.q is not None:
            reference.correct(*in_hole_axes(reference, step))
        normal, covariance = reference.reactions(spread)
        ended = perf_counter()
        yield Difference(
            *state_difference(kalman, reference),
            *reactions_difference(found, normal, covariance),
            unbalance_difference(unbalance, reference.unbalance),
            between - begun,
            ended - between,
            prediction,
        )


def state_difference(kalman: ContactFilter, reference: ReferenceFilter) -> tuple[float, float]:
    """Return `mean` and `covariance` of a Difference."""
    uncertain = [i for i in carried_states(kalman)[12:] if reference.P[i, i] > 0]
    learnt = [*range(6), *uncertain]
    found = np.zeros(reference.dim_x)
    found[:14] = *kalman.x, *kalman.u, kalman.friction[0], kalman.peg_diameter[0]
    joint = np.zeros_like(reference.P)
    if _offset(kalman):
        found[14:] = kalman.offset
    joint[np.ix_(carried_states(kalman), carried_states(kalman))] = kalman.joint_covariance()
    P = reference.P[np.ix_(learnt, learnt)]
    L = np.linalg.cholesky(P)
    mean = np.linalg.solve(L, (found - reference.x)[learnt])
    difference = joint[np.ix_(learnt, learnt)] - P
    covariance = np.linalg.solve(L, np.linalg.solve(L, difference).T)
    return float(np.abs(mean).max()), float(np.abs(covariance).max())


def reactions_difference(found, normal, covariance) -> tuple[float, float]:
    """Return `reactions` and `reactions_covariance` of a Difference."""
    stddev = np.sqrt(np.diagonal(covariance))
    return (
        float(np.abs((np.array(found.normal) - normal) / stddev).max()),
        float(np.abs(np.array(found.normal_stddev) / stddev - 1).max()),
    )


def unbalance_difference(found, expected) -> float:
    """Return `unbalance` of a Difference; either may be None, for not weighed."""
    if found is None or expected is None:
        return float(found is not expected)
    return float(np.abs(np.array(found) - expected).max())
