"""Put the phases of a plan together: guided, on three contacts, wedged, on two contacts."""

from collections.abc import Callable, Iterable

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.records import CONTACTS
from peg_on_hole_ros.sim.blocks import (
    contact_block,
    guided_block,
    parted_block,
    wedged_block,
)
from peg_on_hole_ros.sim.command import evaluate, quintic
from peg_on_hole_ros.sim.contact_run import Model, Start, contact_samples, run_contact
from peg_on_hole_ros.sim.dynamics import scene_numbers
from peg_on_hole_ros.sim.guided import Guidance, guided_state
from peg_on_hole_ros.sim.holder import holder_numbers
from peg_on_hole_ros.sim.insertion_phases import insert
from peg_on_hole_ros.sim.parted import parted_state, run_parted
from peg_on_hole_ros.sim.plan import PHASE_KINDS, Plan, holder_program

# B1 or B2 lets go this near gamma0 [rad]: that is the way into two-point contact.
NEAR_TRANSITION = 2e-3
PARTED_ENDS = {
    "end": "the program is over",
    "gap": "a gap of 0.5 mm is reached, and the simulation ends",
    "transition": "gamma0 is reached, and the simulation ends",
    "force limit": "the holder's force limit is reached",
    "torque limit": "the holder's torque limit is reached",
}
# Where it stands among the scene's numbers.
FRICTION_INDEX = 6
# How far a guided peg may cut into the rim [m]: what a newton makes the holder give way.
OVERLAP = 5e-5


class Run:
    """The simulation under way: where it is, and the blocks of samples so far."""

    def __init__(self, plan: Plan, progress: Callable[[float], None] | None) -> None:
        scene, holder = plan.configuration.scene, plan.holder
        self.plan = plan
        self.progress = progress
        self.knots, self.coefficients = holder_program(plan)
        self.model = Model(
            scene_numbers(scene),
            holder_numbers(
                scene,
                plan.configuration.wrench.sensor_xyz,
                holder.stiffness,
                holder.rotational_stiffness,
                holder.damping_ratio,
            ),
            self.knots,
            self.coefficients,
            plan.slip_velocity_scale,
        )
        count = int(round(self.knots[-1] * plan.wrench_rate))
        self.grid = np.arange(count + 1) / plan.wrench_rate
        self.t = 0.0
        self.taken = 0
        self.blocks: list[dict] = []
        self.events: list[tuple[float, str]] = []
        self.ended_by = ""
        self.guidance: Guidance | None = None
        self.load: tuple | None = None
        self.state: np.ndarray | None = None

    def phase_index(self, t: float) -> int:
        """Return the phase that a time lies in; at a border the later."""
        last = len(self.plan.phases) - 1
        return min(int(np.searchsorted(self.knots, t + 1e-9, side="right")) - 1, last)

    def until(self, t: float) -> np.ndarray:
        """Take the samples before a time (and at it, if it is the end)."""
        stop = np.searchsorted(self.grid, t - 1e-9 if t < self.knots[-1] - 1e-9 else t + 1e-9)
        samples = self.grid[self.taken : stop]
        self.taken = max(self.taken, stop)  # type: ignore[assignment]
        return samples

    def event(self, text: str) -> None:
        """Note what happens now."""
        self.events.append((self.t, text))

    def stretch_end(self, kinds: Iterable[str]) -> float:
        """
        Return where the phases of the given kinds that follow each other from now on end.

        A phase with a friction of its own begins another stretch.

        """
        phases, k = self.plan.phases, self.phase_index(self.t)
        first = k
        while k < len(phases) and phases[k].kind in kinds:
            if k > first and phases[k].friction is not None:
                break
            k += 1
        return float(self.knots[k])

    def take_friction(self) -> None:
        """Let the friction of the phase that is entered hold from now on."""
        friction = self.plan.phases[self.phase_index(self.t)].friction
        if friction is not None:
            p = self.model.p.copy()
            p[FRICTION_INDEX] = friction
            self.model = self.model._replace(p=p)

    def done(self) -> bool:
        """Return whether the program is over or the simulation has ended by itself."""
        return bool(self.ended_by) or self.t >= self.knots[-1] - 1e-9


def run_phases(plan: Plan, progress: Callable[[float], None] | None = None) -> Run:
    """Simulate all phases, or as many as the contacts allow; raises like `truth.integrate`."""
    run = Run(plan, progress)
    while not run.done():
        if plan.phases[run.phase_index(run.t)].kind == "free":
            _free(run)
        elif plan.phases[run.phase_index(run.t)].kind == "insert":
            insert(run)
        else:
            _contact(run)
    run.ended_by = run.ended_by or "end"
    return run


def _free(run):
    begin = run.t
    run.t = run.stretch_end(("free",))
    _guide(run, begin, run.until(run.t), "open")
    _touch_down(run)


def _touch_down(run):
    """Hand the guided peg over to three-point contact, if the program goes on."""
    x = guided_state(run.knots, run.coefficients, run.guidance, run.t)
    if run.t < run.knots[-1] and np.abs(x[:2, 3:]).max() > 1e-9:
        name = run.plan.phases[run.phase_index(run.t)].name
        raise PegOnHoleError(
            f"simulation.phases.{name} begins in contact, but the peg is {x[0, 3:]} m from the "
            f"touching pose and moves at {x[1, 3:]} m/s; end the free phase before with offset "
            "[0, 0, 0]"
        )
    run.state, run.guidance, run.load = np.concatenate([x[0, :3], x[1, :3]]), None, None
    if run.t < run.knots[-1]:
        run.event("touch-down on three contacts")


def _guide(run, begin, samples, mode):
    block = guided_block(run.model, samples, run.guidance, run.load, mode, run.plan.settle, begin)
    if mode != "two_point":
        _check_clear(run, block)
    run.blocks.append(block)
    if run.progress:
        run.progress(run.t / run.knots[-1])


def _check_clear(run, block):
    gaps = block["gap"]
    if len(gaps) and gaps.min() < -OVERLAP:
        i, k = np.unravel_index(np.argmin(gaps), gaps.shape)
        name = run.plan.phases[run.phase_index(block["t"][i])].name
        raise PegOnHoleError(
            f"simulation.phases.{name}: the guided peg would cut {-gaps[i, k] * 1e3:.3g} mm "
            f"into the hole at {CONTACTS[k]}; lead it away along z first, with no offset along h "
            "and e"
        )


def _contact(run):
    run.take_friction()
    plan, model = run.plan, run.model
    limits = plan.holder.force_limit, plan.holder.torque_limit
    if run.state is None:
        x = evaluate(run.knots, run.coefficients, run.t)
        run.state = np.concatenate([x[0, :3], x[1, :3]])
    end = run.stretch_end(("contact", "parted", "lift_off", "two_point"))
    samples = run.grid[run.taken :]
    total = run.knots[-1]
    result = run_contact(
        model,
        Start(run.t, run.state, plan.lead_in),
        samples[samples <= end + 1e-9],
        end,
        limits,
        plan.rtol,
        (lambda t: run.progress(t / total)) if run.progress else None,
    )
    run.blocks.append(contact_block(model, result.t, result.states))
    run.taken += len(result.t)
    run.t, run.state = result.t_end, result.state_end
    _contact_ended(run, result.ended_by)


def _contact_ended(run, what):
    """Go on from what ended the motion on three contacts."""
    gamma, gamma0 = run.state[0], run.model.p[7]
    kind = run.plan.phases[run.phase_index(run.t - 2e-9)].kind
    if what == "end":
        if run.t < run.knots[-1] - 1e-9:
            phase = run.plan.phases[run.phase_index(run.t)]
            if phase.kind != "free":
                return
            name = phase.name
            raise PegOnHoleError(
                f"simulation.phases.{name} is free, but the contacts still carry load at its "
                "begin; put a lift_off before it that raises the offset above 0"
            )
        run.ended_by = "end"
    elif what == "transition" or (what[:4] == "open" and gamma < gamma0 + NEAR_TRANSITION):
        how = "gamma0 reached" if what == "transition" else f"contact {what[5:]} opened"
        run.event(f"transition to two-point contact: {how} at gamma = {gamma:.6f} rad")
        if kind == "two_point":
            _two_point(run)
        else:
            run.ended_by = "transition"
    elif what[:4] == "open" and kind == "lift_off":
        run.event(f"lift-off: contact {what[5:]} opened first at gamma = {gamma:.6f} rad")
        _let_go(run)
    elif what == "wedged":
        run.event(f"wedged at gamma = {gamma:.6f} rad: rigid sliding has no solution any more")
        _stuck(run)
    elif what[:4] == "open":
        run.event(f"contact {what[5:]} opened at gamma = {gamma:.6f} rad")
        run.ended_by = f"contact {what[5:]} opened"
        if kind == "parted":
            _parted(run)
    else:
        run.event(f"{what} of the holder reached at gamma = {gamma:.6f} rad")
        run.ended_by = what


def _take_over(run, touching):
    """Let guidance begin from the state that the contact run left."""
    y = contact_samples(run.model, np.array([run.t]), run.state[None])
    command = evaluate(run.knots, run.coefficients, run.t)
    true = np.zeros((3, 6))
    true[0, :3], true[1, :3], true[2, :3] = run.state[:3], run.state[3:], y[0][0]
    if touching:
        command[:, 3:] = 0
    settle = run.plan.settle
    fade = quintic(true - command, np.zeros((3, 6)), settle)
    run.guidance = Guidance(run.t, fade, settle, touching)
    run.load = (np.maximum(y[1][0], 0.0), 0, None)


def _let_go(run):
    """Guide the peg away; what the other contacts still carry fades meanwhile."""
    _take_over(run, touching=False)
    end = run.stretch_end(("lift_off", "free"))
    for t, mode in ((min(run.t + run.plan.settle, end), "unknown"), (end, "open")):
        begin, run.t = run.t, t
        _guide(run, begin, run.until(t), mode)
        run.load = None
    _touch_down(run)


def _parted(run):
    """Go on with the contacts that are left, as far as that is known."""
    plan, limits = run.plan, (run.plan.holder.force_limit, run.plan.holder.torque_limit)
    normal = contact_samples(run.model, np.array([run.t]), run.state[None])[1][0]
    begin, end = run.t, run.knots[-1]
    stiffness = plan.contact_stiffness
    state = parted_state(run.model, run.state, normal, stiffness)
    result = run_parted(run.model, begin, state, run.until(end), end, limits, plan.rtol, stiffness)
    run.blocks.append(parted_block(run.model, result.t, result.states, stiffness))
    run.t = float(result.t[-1]) if len(result.t) else begin
    run.event(f"with that contact open: {PARTED_ENDS[result.ended_by]}")


def _two_point(run):
    _take_over(run, touching=True)
    normal = run.load[0]
    loaded = 1 if normal[1] >= normal[2] else 2
    at_K, at_wall = normal[0], normal[1] + normal[2]
    while not run.done():
        phase = run.plan.phases[run.phase_index(run.t)]
        begin, end = run.t, float(run.knots[run.phase_index(run.t) + 1])
        run.take_friction()
        target = phase.load or (at_K, at_wall)
        pieces = quintic([[at_K, at_wall], [0, 0], [0, 0]], [target, [0, 0], [0, 0]], end - begin)
        run.load = (None, loaded, pieces)
        run.t = end
        _guide(run, begin, run.until(end), "two_point")
        at_K, at_wall = target
        _end_outside_two_points(run, loaded)
    run.ended_by = run.ended_by or "end"


def _end_outside_two_points(run, loaded):
    """End the run before the first sample of a motion in the hole that two points cannot have."""
    block, height = run.blocks[-1], run.plan.configuration.scene.peg_height
    tilt, at_wall = block["q"][:, 0], -block["contact_point"][:, loaded, 2]
    outside = np.flatnonzero((tilt <= 0.0) | (at_wall > height))
    if not len(outside):
        return
    first = outside[0]
    why = "the peg is upright" if tilt[first] <= 0.0 else "the whole peg would be in the hole"
    run.t = float(block["t"][first])
    run.blocks[-1] = {name: values[:first] for name, values in block.items()}
    run.event(f"the two points end at gamma = {tilt[first]:.4g} rad: {why}")
    run.ended_by = why


def _stuck(run):
    limits = run.plan.holder.force_limit, run.plan.holder.torque_limit
    run.state[3:] = 0
    begin = run.t
    whole = True
    while whole and run.t < run.knots[-1] - 1e-9:
        run.take_friction()
        end = run.stretch_end(tuple(PHASE_KINDS))
        samples = run.until(end)
        block, stays, reason = wedged_block(run.model, samples, run.state, limits)
        run.blocks.append(block)
        whole = len(block["t"]) == len(samples)
        run.t = end
    last = [block["t"][-1] for block in run.blocks if len(block["t"])][-1]
    run.t = max(begin, float(last))
    run.event(f"the wedged peg {reason}")
    run.ended_by = "jammed" if stays else "wedge gave way"
