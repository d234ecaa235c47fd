"""The truth of a plan: phases put together, every sample with its wrench, contacts and mode."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.sim.blocks import joined
from peg_on_hole_ros.sim.plan import Plan
from peg_on_hole_ros.sim.run import run_phases


@dataclass(frozen=True)
class Truth:
    """
    What truly happened, one row a wrench sample.

    Attributes
    ----------
    plan : Plan
    t_ns : ndarray of int, shape (n,)
        From the begin of the recording [ns].
    q, rates, acceleration : ndarray, shape (n, 3)
        gamma, psi, phi (unwrapped) [rad], [rad/s], [rad/s^2].
    position : ndarray, shape (n, 3)
        Origin of the peg frame, hole axes [m].
    centre : ndarray, shape (n, 3, 3)
        Mass centre's position, velocity, acceleration, hole axes [m], [m/s], [m/s^2].
    normal, slip_speed : ndarray, shape (n, 3)
        K, B1, B2 [N], [m/s].
    closed : ndarray of bool, shape (n, 3)
    known : ndarray of bool, shape (n,)
        False: the reactions are not determined (a wedged peg at rest), and stand as 0.
    contact_point, contact_force : ndarray, shape (n, 3, 3)
        Rows K, B1, B2, hole axes [m], [N].
    force, moment : ndarray, shape (n, 3)
        Of the holder on the peg at its mass centre, hole axes [N], [N m].
    turning : ndarray, shape (n, 2, 3)
        Angular velocity and acceleration, hole axes [rad/s], [rad/s^2].
    hole_normal, hole_azimuth, hole_slip : ndarray, shape (n, 4)
        Normal force, place about the hole's axis and slip speed at two places of the rim and two
        of the peg's lower edge [N], [rad], [m/s]; on three contacts K, none, B1, B2.
    mode : ndarray of str, shape (n,)
        `three_point`, `two_point`, `one_point`, `line`, `open`, `unknown`.
    phase : ndarray of str, shape (n,)
    ended_by : str
        `transition`, `jammed`, `end`, or what stopped the simulation.
    events : tuple of (int, str)
        Stamp [ns] and what happened.

    """

    plan: Plan
    t_ns: np.ndarray
    q: np.ndarray
    rates: np.ndarray
    acceleration: np.ndarray
    position: np.ndarray
    centre: np.ndarray
    normal: np.ndarray
    slip_speed: np.ndarray
    closed: np.ndarray
    known: np.ndarray
    contact_point: np.ndarray
    contact_force: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    turning: np.ndarray
    hole_normal: np.ndarray
    hole_azimuth: np.ndarray
    hole_slip: np.ndarray
    mode: np.ndarray
    phase: np.ndarray
    ended_by: str
    events: tuple[tuple[int, str], ...]

    @property
    def place(self) -> np.ndarray:
        """Place x, y and depth below the rim of the lower end's centre, shape (n, 3) [m]."""
        return self.position * [1.0, 1.0, -1.0]

    @property
    def place_rate(self) -> np.ndarray:
        """How fast `place` changes, shape (n, 3) [m/s]."""
        lever = self.position - self.centre[:, 0]
        velocity = self.centre[:, 1] + np.cross(self.turning[:, 0], lever)
        return velocity * [1.0, 1.0, -1.0]


def integrate(plan: Plan, progress: Callable[[float], None] | None = None) -> Truth:
    """
    Return the truth of a plan; the same plan gives the same truth.

    Parameters
    ----------
    plan : Plan
    progress : callable, optional
        Told the share done, 0 to 1.

    Raises
    ------
    PegOnHoleError
        A plan that touches down or lets go in a way that cannot be.

    """
    run = run_phases(plan, progress)
    block = joined(run.blocks)
    t = block.pop("t")
    del block["gap"]
    keep = t >= plan.lead_in - 1e-9
    if not keep.any():
        raise PegOnHoleError(
            f"nothing is left to record: {run.events[-1][1]} when the lead-in of "
            f"{plan.lead_in:g} s was over; begin with a pose and load that press all contacts"
        )
    names = np.array([phase.name for phase in plan.phases])
    phase = names[[run.phase_index(ti) for ti in t[keep]]]
    events = tuple((int(round((ti - plan.lead_in) * 1e9)), text) for ti, text in run.events)
    return Truth(
        plan=plan,
        t_ns=np.round((t[keep] - plan.lead_in) * 1e9).astype(np.int64),
        phase=phase,
        ended_by=run.ended_by,
        events=events,
        **{name: values[keep] for name, values in block.items()},
    )
