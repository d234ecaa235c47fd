"""
Faults put into a recording: what drivers, sensors, clocks, networks and people do to it.

    faulted = inject(recording, "spikes", begin=0.2, end=0.4, size=50.0)

A recording is a list of `Sent` in the order of arrival; `sent` makes one of samples. FAULTS has
all faults by name, with what their parameters mean in the docstring of each. A fault touches what
was measured from `begin` to `end` [s] after the first sample, and leaves the rest as it is. What a
fault needs to know of the cell is in `Cell`; as it is, that of the sample bags.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from peg_on_hole_ros.mechanics.reference import peg_axes
from peg_on_hole_ros.records import JointSample, WrenchSample

WRENCH, JOINTS = WrenchSample, JointSample
SOURCES = {"wrench": (WRENCH,), "joints": (JOINTS,), "both": (WRENCH, JOINTS)}
# All right-handed ways in which a sensor's axes can be named, the right one last.
TURNS = sorted(
    np.rint(Rotation.create_group("O").as_matrix()).tolist(), key=lambda turn: np.trace(turn) > 2.9
)
MS = 1_000_000


class Sent(NamedTuple):
    """
    A sample on its way.

    Attributes
    ----------
    sample : WrenchSample, JointSample or str
        A text is a call: `tare` or `reset`.
    true_ns : int
        When it was measured, by the clock of the recording as it was [ns].

    """

    sample: WrenchSample | JointSample | str
    true_ns: int


class Cell(NamedTuple):
    """
    What faults need to know of the cell.

    Attributes
    ----------
    force, torque, angle : float
        Stated noise of the sensors [N], [N m], [rad].
    axes : callable
        Returns the sensor's axes in the base, shape (3, 3), of the joints' positions.
    weighs : bool
        Whether the wrench holds the weight of what hangs at the sensor; else it is taken off.
    sign : float
        1 where the wrench is that on the peg, -1 where it is that on the robot.
    turning : tuple of int
        Joints that turn the peg most like gamma, psi and phi.
    angles : bool
        Whether positions are gamma, psi and phi themselves.

    """

    force: float = 0.2
    torque: float = 5e-3
    angle: float = 1e-4
    axes: Callable = peg_axes
    weighs: bool = True
    sign: float = 1.0
    turning: tuple[int, int, int] = (0, 1, 2)
    angles: bool = True


SAMPLE_BAGS = Cell()
Recording = list[Sent]
FAULTS: dict[str, Callable[..., Recording]] = {}


class Part:
    """Where a fault is: from `begin` to before `end` [s] after the first sample, in a cell."""

    def __init__(self, recording: Recording, begin: float, end: float, cell: Cell):
        self.cell = cell
        first = recording[0].true_ns
        self.begin_ns = first + round(begin * 1e9)
        self.end_ns = first + round(min(end, 1e6) * 1e9)

    def has(self, item: Sent) -> bool:
        """Return whether an item was measured within."""
        return self.begin_ns <= item.true_ns < self.end_ns


def sent(samples: Iterable[WrenchSample | JointSample]) -> Recording:
    """Return samples as they are, each measured at its stamp."""
    return [Sent(sample, sample.t_ns) for sample in samples]


def inject(
    recording: Recording,
    name: str,
    begin=0.0,
    end=np.inf,
    seed: int = 1,
    cell: Cell = SAMPLE_BAGS,
    **parameters,
) -> Recording:
    """
    Return a recording with a fault.

    Parameters
    ----------
    recording : list of Sent
        In the order of arrival; it stays as it is.
    name : str
        Of FAULTS.
    begin, end : float
        Where the fault is, after the first sample [s].
    seed : int
        Of what is drawn.
    cell : Cell
    **parameters
        Those of the fault.

    """
    part, draw = Part(recording, begin, end, cell), np.random.default_rng(seed)
    return FAULTS[name](recording, part, draw, **parameters)


def fault(function):
    """Put a function into FAULTS under its name."""
    FAULTS[function.__name__] = function
    return function


def _changed(recording, part, source, change) -> Iterator[Sent]:
    """Yield items, those of a source within a part as `change` makes them; None: lost."""
    kinds = SOURCES[source]
    for item in recording:
        if isinstance(item.sample, kinds) and part.has(item):
            sample = change(item.sample)
            if sample is not None:
                yield Sent(sample, item.true_ns)
        else:
            yield item


def _wrenches(recording, part, change) -> Recording:
    """Return a recording with wrenches as `change(force, torque, q, seconds)` makes them."""
    q, found = None, []
    for item in recording:
        sample = item.sample
        if isinstance(sample, JOINTS):
            q = sample.position
        elif isinstance(sample, WRENCH) and part.has(item) and q is not None:
            seconds = (item.true_ns - part.begin_ns) * 1e-9
            read = change(np.array(sample.force), np.array(sample.torque), q, seconds)
            force, torque = (tuple(map(float, value)) for value in read)
            item = Sent(sample._replace(force=force, torque=torque), item.true_ns)
        found.append(item)
    return found


def _joints(recording, part, change) -> Recording:
    """Return a recording with positions as `change(positions)` makes them."""

    def each(sample):
        return sample._replace(position=tuple(map(float, change(np.array(sample.position)))))

    return list(_changed(recording, part, "joints", each))


# --- messages that do not come, come twice, late, or in another order


@fault
def gap(recording, part, draw, source="both"):
    """No message of a source."""
    return list(_changed(recording, part, source, lambda sample: None))


@fault
def burst_loss(recording, part, draw, source="both", share=0.3, length=8):
    """Lose a share of the messages, in bursts of so many on average."""
    lost = False
    stay, begin = 1.0 - 1.0 / length, share / (1.0 - share) / length

    def each(sample):
        nonlocal lost
        lost = draw.random() < (stay if lost else begin)
        return None if lost else sample

    return list(_changed(recording, part, source, each))


@fault
def duplicate(recording, part, draw, source="both", times=2):
    """Each message so many times."""
    kinds = SOURCES[source]
    found = []
    for item in recording:
        more = times if isinstance(item.sample, kinds) and part.has(item) else 1
        found += [item] * more
    return found


def _delayed(recording, part, source, delay_ns):
    """Return a recording in the order in which messages come that were so long on their way."""
    kinds = SOURCES[source]
    come = [
        item.true_ns + (delay_ns() if isinstance(item.sample, kinds) and part.has(item) else 0)
        for item in recording
    ]
    return [recording[i] for i in np.argsort(come, kind="stable")]


@fault
def reorder(recording, part, draw, source="both", most_ms=5.0):
    """Messages are on their way for up to so long, each for itself [ms]."""
    return _delayed(recording, part, source, lambda: int(draw.uniform(0.0, most_ms) * MS))


@fault
def late(recording, part, draw, source="wrench", by_ms=80.0, share=0.01):
    """Have a share of the messages come so much late [ms]."""
    return _delayed(recording, part, source, lambda: (draw.random() < share) * round(by_ms * MS))


@fault
def rate_halved(recording, part, draw, source="both"):
    """Every second message of a source alone."""
    seen = dict.fromkeys((WRENCH, JOINTS), 0)

    def each(sample):
        seen[type(sample)] += 1
        return sample if seen[type(sample)] % 2 else None

    return list(_changed(recording, part, source, each))


@fault
def loop(recording, part, draw):
    """All that was recorded comes again, with the same stamps."""
    return [*recording, *recording]


@fault
def set_again(recording, part, draw):
    """Stop the recorder for the part, and its clock with it: the peg is elsewhere at once."""
    missing = part.end_ns - part.begin_ns
    return [
        item._replace(sample=_stamped(item.sample, -missing if item.true_ns >= part.end_ns else 0))
        for item in recording
        if not part.has(item)
    ]


# --- stamps


def _stamped(sample, more_ns):
    return sample if isinstance(sample, str) else sample._replace(t_ns=sample.t_ns + more_ns)


@fault
def stamps_zero(recording, part, draw, source="wrench", share=0.01):
    """Stamp a share of the messages with zero."""

    def each(sample):
        return sample._replace(t_ns=0) if draw.random() < share else sample

    return list(_changed(recording, part, source, each))


@fault
def stamps_off(recording, part, draw, source="wrench", by_ms=80.0, share=0.01):
    """Stamps of a share of the messages lie ahead by so much, or back (below 0) [ms]."""

    def each(sample):
        return _stamped(sample, round(by_ms * MS) if draw.random() < share else 0)

    return list(_changed(recording, part, source, each))


@fault
def stamps_coarse(recording, part, draw, source="both", step_ms=4.0):
    """Stamps are whole multiples of a step [ms]."""
    step = round(step_ms * MS)

    def each(sample):
        return sample._replace(t_ns=sample.t_ns // step * step)

    return list(_changed(recording, part, source, each))


@fault
def clock_jump(recording, part, draw, source="both", by_s=5.0):
    """Set the clock on by so much, or back (below 0), for good [s]."""
    part.end_ns = np.inf
    return list(_changed(recording, part, source, lambda s: _stamped(s, round(by_s * 1e9))))


@fault
def delay(recording, part, draw, by_ms=5.0):
    """Joint states have stamps later by so much than when they were measured [ms]."""
    return list(_changed(recording, part, "joints", lambda s: _stamped(s, round(by_ms * MS))))


# --- values of either sensor


@fault
def noise(recording, part, draw, source="wrench", times=5.0):
    """White noise so many times the stated one, which is there already."""
    more, cell = np.sqrt(times**2 - 1.0), part.cell
    if source == "joints":

        def moved(q):
            by = draw.normal(0, more * cell.angle, len(q))
            return _turned(q, by) if cell.angles else q + by

        return _joints(recording, part, moved)
    return _wrenches(
        recording,
        part,
        lambda f, m, q, t: (
            f + draw.normal(0, more * cell.force, 3),
            m + draw.normal(0, more * cell.torque, 3),
        ),
    )


def _turned(q, by):
    """Return gamma, psi, phi of an orientation turned by a small vector in peg axes [rad]."""
    R = peg_axes(q) @ Rotation.from_rotvec(by).as_matrix()
    gamma = np.arctan2(np.hypot(R[2, 0], R[2, 1]), R[2, 2])
    return gamma, np.arctan2(-R[1, 2], -R[0, 2]), np.arctan2(-R[2, 1], R[2, 0])


def _held(source, keep):
    """Return a change that repeats values as long as `keep(count)` says so."""
    last, count = {}, dict.fromkeys((WRENCH, JOINTS), 0)

    def each(sample):
        kind = type(sample)
        if kind not in last or not keep(count[kind]):
            last[kind] = sample
        count[kind] += 1
        return last[kind]._replace(t_ns=sample.t_ns)

    return each


@fault
def frozen(recording, part, draw, source="joints"):
    """Every value stays as it was, with fresh stamps."""
    return list(_changed(recording, part, source, _held(source, lambda count: True)))


@fault
def zero_order_hold(recording, part, draw, source="wrench", times=10):
    """Every value comes so many times, with fresh stamps."""
    return list(_changed(recording, part, source, _held(source, lambda count: count % times)))


@fault
def low_pass(recording, part, draw, source="wrench", cutoff_hz=20.0):
    """Filter by first order without correcting the stamp [Hz]; angles as they wind."""
    state, last_ns = {}, {}

    def each(sample):
        kind = type(sample)
        wrench = kind is WRENCH
        values = np.array([*sample.force, *sample.torque] if wrench else sample.position)
        if kind in state:
            gain = 1.0 - np.exp(-2.0 * np.pi * cutoff_hz * (sample.t_ns - last_ns[kind]) * 1e-9)
            step = values - state[kind]
            if not wrench:
                step = (step + np.pi) % (2.0 * np.pi) - np.pi
            values = state[kind] + gain * step
        state[kind], last_ns[kind] = values, sample.t_ns
        read = tuple(map(float, values))
        if wrench:
            return sample._replace(force=read[:3], torque=read[3:])
        return sample._replace(position=read)

    return list(_changed(recording, part, source, each))


@fault
def not_a_number(recording, part, draw, source="wrench", share=0.05):
    """Put a NaN into a share of the messages."""

    def each(sample):
        if draw.random() >= share:
            return sample
        if isinstance(sample, WRENCH):
            return sample._replace(torque=(*sample.torque[:2], np.nan))
        return sample._replace(position=(*sample.position[:-1], np.nan))

    return list(_changed(recording, part, source, each))


# --- the wrench


@fault
def spikes(recording, part, draw, size=50.0, share=0.01):
    """Have a share of the wrenches off by so much along one axis [N]."""

    def each(force, torque, q, seconds):
        off = np.zeros(3)
        if draw.random() < share:
            off[draw.integers(3)] = size * draw.choice([-1.0, 1.0])
        return force + off, torque

    return _wrenches(recording, part, each)


@fault
def drift(recording, part, draw, force=(0.7, 0.0, 0.0), torque=(0.0, 0.03, 0.0)):
    """Move the zero of the wrench by so much a second, where it stays [N/s], [N m/s]."""
    most = (part.end_ns - part.begin_ns) * 1e-9
    part.end_ns = np.inf

    def each(f, m, q, seconds):
        t = min(seconds, most)
        return f + t * np.array(force), m + t * np.array(torque)

    return _wrenches(recording, part, each)


@fault
def bias_step(recording, part, draw, force=(0.0, 0.0, 5.0), torque=(0.0, 0.0, 0.0)):
    """Have the zero of the wrench off by so much [N], [N m]."""
    return _wrenches(
        recording, part, lambda f, m, q, t: (f + np.array(force), m + np.array(torque))
    )


@fault
def saturation(recording, part, draw, force=20.0, torque=1.0):
    """No component goes beyond what the sensor measures [N], [N m]."""
    return _wrenches(
        recording,
        part,
        lambda f, m, q, t: (np.clip(f, -force, force), np.clip(m, -torque, torque)),
    )


@fault
def quantisation(recording, part, draw, force=0.1, torque=0.1):
    """Values come in steps [N], [N m]."""
    return _wrenches(
        recording,
        part,
        lambda f, m, q, t: (np.round(f / force) * force, np.round(m / torque) * torque),
    )


@fault
def sign(recording, part, draw):
    """Tell what acts on the robot instead of on the peg."""
    return _wrenches(recording, part, lambda f, m, q, t: (-f, -m))


@fault
def axes(recording, part, draw, turn=0):
    """Name the sensor's axes in another way, one of TURNS."""
    R = np.array(TURNS[turn])
    return _wrenches(recording, part, lambda f, m, q, t: (R @ f, R @ m))


@fault
def base_axes(recording, part, draw):
    """Numbers in the axes of the base."""

    def each(force, torque, q, seconds):
        R = part.cell.axes(q)
        return R @ force, R @ torque

    return _wrenches(recording, part, each)


@fault
def compensated_gravity(recording, part, draw, mass=0.5, centre=(0.0, 0.0, -0.035)):
    """Take off the weight of what hangs at the sensor, as a controller does, or leave it."""
    share = part.cell.sign * (1.0 if part.cell.weighs else -1.0)

    def each(force, torque, q, seconds):
        weight = part.cell.axes(q).T @ [0.0, 0.0, -share * mass * 9.80665]
        return force + weight, torque + np.cross(centre, weight)

    return _wrenches(recording, part, each)


@fault
def unit(recording, part, draw, force=1.0, torque=1.0, angle=1.0):
    """Values are so many times what they are in N, N m and rad."""
    turned = _joints(recording, part, lambda q: q * angle) if angle != 1.0 else recording
    if force == torque == 1.0:
        return turned
    return _wrenches(turned, part, lambda f, m, q, t: (f * force, m * torque))


# --- joint states


@fault
def joints_permuted(recording, part, draw, order=(1, 0, 2)):
    """Positions of the joints that turn the peg stand under the names of others."""
    turning = part.cell.turning

    def each(q):
        mixed = q.copy()
        mixed[list(turning)] = q[[turning[i] for i in order]]
        return mixed

    return _joints(recording, part, each)


@fault
def joint_frozen(recording, part, draw, joint=0):
    """One joint keeps its value, the others go on."""
    kept, joint = [], part.cell.turning[joint]

    def each(q):
        kept.append(q[joint])
        q[joint] = kept[0]
        return q

    return _joints(recording, part, each)


@fault
def joint_offset(recording, part, draw, joint=0, by=2e-3):
    """One joint is off by so much [rad]."""
    joint = part.cell.turning[joint]
    return _joints(recording, part, lambda q: q + by * np.eye(len(q))[joint])


# --- people


@fault
def call(recording, part, draw, what="tare"):
    """Somebody calls `~/tare` or `~/reset` as the part begins."""
    at = next(i for i, item in enumerate(recording) if part.has(item))
    return [*recording[:at], Sent(what, recording[at].true_ns), *recording[at:]]
