"""
What truly happened in a scene: read off the simulated motion and loads, and off nothing else.

No label looks at a determinant, a risk, or anything that the monitor computes.
"""

import numpy as np

from benchmarks.harness.events import NEAR_STALL, Event, SceneLabels, stretches
from peg_on_hole_ros.sim.command import evaluate
from peg_on_hole_ros.sim.plan import holder_program

# The fastest contact is slower [m/s], and slower than this share of what it was: at rest. A tenth
# of what the slowest scene commands.
STILL, STILL_SHARE = 3e-4, 0.05
# Slower than this share of what it was, under a program that goes on, and yet no stop: nearly one.
SLOWED_SHARE = 0.4
# What it was: the fastest of the last so many seconds in contact.
BEFORE = 0.5
# The holder's program goes on faster [m/s], or it does not push.
PUSHING = 1.5e-3
# Shorter stops [s] are reversals of the motion.
SHORTEST_STOP = 0.01
# Shorter openings [s] are bounces of a contact that closes again.
SHORTEST_LOSS = 0.01
# A peg that stays under so many times the load at which it stopped is wedged.
HELD = 2.0


def labels_of(truth) -> SceneLabels:
    """Return the labels of a truth."""
    t = truth.t_ns * 1e-9
    gamma, gamma0 = truth.q[:, 0], truth.plan.configuration.scene.gamma0
    kind = np.where(truth.mode == "unknown", "", truth.mode).astype("U11")
    some = truth.closed.any(axis=1) & ~truth.closed.all(axis=1)
    lost = (truth.mode == "unknown") & truth.known & some
    kind[lost] = "lost"
    spans = _stops(truth, t)
    for first, last, cause in spans:
        if cause != NEAR_STALL:
            kind[first : last + 1] = "stuck"
    spans += _overloads(truth) + _losses(truth, kind)
    begins = holder_program(truth.plan)[0] - truth.plan.lead_in
    events = []
    for first, last, cause in spans:
        phase = max(int(np.searchsorted(begins, t[first])) - 1, 0)
        events.append(
            Event(cause, float(t[first]), float(t[last]), max(float(begins[phase]), 0.0))
        )
    below = gamma < gamma0
    return SceneLabels(t, kind, below, _transition(t, gamma - gamma0, kind), tuple(events))


def _transition(t, margin, kind):
    """Return when the tilt first falls below gamma0 while the peg touches [s]."""
    touching = np.isin(kind, ("three_point", "two_point"))
    passed = np.flatnonzero((margin[1:] < 0) & (margin[:-1] >= 0) & touching[1:])
    if not passed.size:
        return None
    k = passed[0]
    share = margin[k] / (margin[k] - margin[k + 1])
    return float(t[k] + share * (t[k + 1] - t[k]))


def _commanded_speed(truth, t):
    """Return how fast the holder's program turns the peg, at its surface, about [m/s]."""
    knots, coefficients = holder_program(truth.plan)
    rates = np.array([evaluate(knots, coefficients, x + truth.plan.lead_in)[1] for x in t])
    radius = truth.plan.configuration.scene.hole_diameter / 2
    return radius * np.abs(rates[:, :3]).sum(axis=1)


def _stops(truth, t):
    """Return first and last sample of every stop under a holder that pushes, and its cause."""
    wedged = (truth.mode == "unknown") & ~truth.known
    contact = (truth.mode == "three_point") | wedged
    speed = np.where(wedged, 0.0, truth.slip_speed.max(axis=1))
    before = _fastest_before(speed, contact, t)
    still = contact & ((speed < np.minimum(STILL, STILL_SHARE * before)) | wedged)
    commanded = _commanded_speed(truth, t)
    pushed = still & (commanded > PUSHING)
    load = np.linalg.norm(truth.moment, axis=1), np.linalg.norm(truth.force, axis=1)
    found = []
    for first, last in stretches(still):
        # At rest from the begin: nothing has stopped.
        if first == 0 or not contact[first - 1]:
            continue
        # When the push begins later than the rest, the peg had been put down to rest.
        if t[last] - t[first] < SHORTEST_STOP or not pushed[first : first + 5].all():
            continue
        grown = max(x[last] / max(x[first], 1e-9) for x in load)
        stays = last == len(t) - 1
        found.append((first, last, "wedge" if stays and grown >= HELD else "stall"))
    # A program that slows down itself brings the peg to rest: nothing hinders it.
    goes_on = commanded > SLOWED_SHARE * _fastest_before(commanded, contact, t)
    slowed = contact & goes_on & (commanded > PUSHING) & (speed < SLOWED_SHARE * before)
    for first, last in stretches(slowed):
        stops = any(first <= b and a <= last for a, b, _ in found)
        if t[last] - t[first] >= SHORTEST_STOP and not stops:
            found.append((first, last, NEAR_STALL))
    return found


def _fastest_before(speed, contact, t):
    """Return the fastest that the peg was lately, in the contact that it is in [m/s]."""
    fastest = np.zeros(len(t))
    for first, last in stretches(contact):
        for k in range(first, last + 1):
            begin = max(first, int(np.searchsorted(t, t[k] - BEFORE)))
            fastest[k] = speed[begin : k + 1].max()
    return fastest


def _overloads(truth):
    limits = np.asarray(truth.plan.configuration.monitor.max_normal)
    over = (truth.known[:, None] & (truth.normal > limits)).any(axis=1)
    return [(first, last, "overload") for first, last in stretches(over)]


def _losses(truth, kind):
    """Return where a contact opened elsewhere than on the way into the hole."""
    touching = np.isin(kind, ("three_point", "stuck"))
    parted = stretches(np.isin(kind, ("", "lost", "open")))
    t, last = truth.t_ns * 1e-9, len(kind) - 1
    found = [
        (a, b, "contact_loss")
        for a, b in parted
        if a and touching[a - 1] and (b == last or t[b] - t[a] >= SHORTEST_LOSS)
    ]
    if truth.ended_by.startswith("contact ") and touching[-1]:
        found.append((len(kind) - 1, len(kind) - 1, "contact_loss"))
    return found
