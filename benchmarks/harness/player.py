"""
Play samples through the pipeline of whichever checkout Python finds, and keep what it says.

As a program it answers requests from another checkout's benchmarks: pickled (parameters, samples)
on standard input, pickled arrays on standard output. So two states of the package see the same
samples; what has changed its name between them is taken by either.
"""

import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

import peg_on_hole_ros
from peg_on_hole_ros.records import JointSample, WrenchSample

# The folder is asked, not the import: an editable install of another checkout would fill in
# whatever modules this one lacks.
if (Path(peg_on_hole_ros.__file__).parent / "engine").is_dir():
    from peg_on_hole_ros.config.configuration import BY_NAME, from_parameters
    from peg_on_hole_ros.engine.pipeline import Pipeline
else:
    from peg_on_hole_ros.configuration import from_parameters
    from peg_on_hole_ros.pipeline import Pipeline

    BY_NAME = {}

ALARMS = ("jamming", "contact_loss", "overload")


class Record(NamedTuple):
    """
    What was published, a row an output; of `rows_at` a row a stamp of the truth.

    Attributes
    ----------
    t_ns : ndarray of int, shape (n,)
        Stamps [ns].
    state, normal, normal_stddev : ndarray, shape (n, 6), (n, 3), (n, 3)
        Angles [rad] and rates [rad/s], reactions [N]; NaN where there was no output.
    covariance : ndarray, shape (n, 6, 6)
        Of the state.
    mode : ndarray of str, shape (n,)
        Contact mode; empty where there was no output.
    flag : ndarray of bool, shape (n,)
        Of the transition.
    alarms : dict of str to ndarray of int, shape (n,)
        Level of each alarm.
    monitor : dict of str to ndarray, shape (n,)
        NaN where a value did not exist.
    nis : float
        Mean normalised innovation of the orientations after the filter has settled.
    restarts : int
        Of the filter by itself.

    """

    t_ns: np.ndarray
    state: np.ndarray
    covariance: np.ndarray
    normal: np.ndarray
    normal_stddev: np.ndarray
    mode: np.ndarray
    flag: np.ndarray
    alarms: dict
    monitor: dict
    nis: float = float("nan")
    restarts: int = 0

    @property
    def determined(self) -> np.ndarray:
        """Return where the reactions are declared determined, shape (n,)."""
        return self.monitor["reactions_determined"] == 1.0

    def rows_at(self, t_ns: np.ndarray, start_ns: int) -> "Record":
        """Return a row for each stamp [ns] of a truth that was measured from `start_ns` on."""
        k = np.searchsorted(t_ns, self.t_ns - start_ns)

        def spread(values, nothing):
            rows = np.full((len(t_ns), *values.shape[1:]), nothing, values.dtype)
            rows[k] = values
            return rows

        return self._replace(
            t_ns=t_ns + start_ns,
            mode=spread(self.mode, ""),
            flag=spread(self.flag, False),
            alarms={name: spread(levels, 0) for name, levels in self.alarms.items()},
            monitor={name: spread(values, np.nan) for name, values in self.monitor.items()},
            **{
                name: spread(getattr(self, name), np.nan)
                for name in ("state", "covariance", "normal", "normal_stddev")
            },
        )


def record_of(pipeline, samples, settled_ns: int = 0) -> Record:
    """
    Return what a pipeline says of samples.

    Parameters
    ----------
    pipeline : Pipeline
    samples : iterable of JointSample and WrenchSample
    settled_ns : int
        Innovations count from this stamp on.

    """
    found, nis, taken, last_nis = [], [], 0, _last_nis(pipeline.filter)
    for o in pipeline.play(samples):
        found.append(o)
        # Of the last orientation; only the mean is published, and none comes with each wrench.
        now, before = pipeline.counts["joints_used"] + pipeline.counts["joints_gated"], taken
        taken, value = now, last_nis()
        if now > before and o.t_ns >= settled_ns and np.isfinite(value):
            nis.append(value)
    n = len(found)
    levels = [{a.name: a.level for a in getattr(o, "alarms", ())} for o in found]
    # As they came: an output may have values that another has not.
    values = {name: np.full(n, np.nan) for o in found for name in o.monitor}
    for i, o in enumerate(found):
        for name, value in o.monitor.items():
            values[name][i] = value
    return Record(
        t_ns=np.array([o.t_ns for o in found], np.int64),
        state=_column(found, "state", 6),
        covariance=_column(found, "state_covariance", 6, 6),
        normal=_column(found, "normal", 3),
        normal_stddev=_column(found, "normal_stddev", 3),
        mode=np.array([o.contact_mode for o in found], "U16"),
        flag=np.array([getattr(o, "transition", False) for o in found], bool),
        alarms={name: np.array([each.get(name, 0) for each in levels], int) for name in ALARMS},
        monitor=values,
        nis=float(np.mean(nis)) if nis else float("nan"),
        restarts=pipeline.counts["filter_restarted"],
    )


def _column(found, name, *shape):
    rows = [np.broadcast_to(getattr(o, name), shape) for o in found]
    return np.array(rows, float).reshape(-1, *shape)


def play(parameters: dict, samples: list[tuple], settled_ns: int = 0) -> Record:
    """
    Return what a pipeline says of samples, from plain values that any checkout takes.

    Parameters
    ----------
    parameters : dict
        Of the configuration, by dotted name.
    samples : list of tuple
        The fields of a JointSample or a WrenchSample.
    settled_ns : int
        Innovations count from this stamp on.

    """
    # A checkout that knows no accuracies takes every cell for exact.
    known = {
        name: value
        for name, value in parameters.items()
        if name in BY_NAME or not name.startswith("accuracy.")
    }
    return record_of(Pipeline(from_parameters(known)), map(_sample, samples), settled_ns)


def _sample(fields):
    # The second field of a joint state is its names.
    kind = JointSample if isinstance(fields[1][0], str) else WrenchSample
    return kind(*fields)


def _last_nis(kalman):
    """Return what tells the normalised innovation of the last orientation."""
    if hasattr(kalman, "state"):
        return lambda: float(kalman.state.nis_orientation)
    # Older filters return it, and keep none.
    values, correct = [float("nan")], kalman.correct

    def correct_and_keep(q, R):
        result, values[0] = correct(q, R)
        return result, values[0]

    kalman.correct = correct_and_keep
    return lambda: float(values[0])


class Elsewhere:
    """
    The same by another checkout, in a process of its own.

    Parameters
    ----------
    checkout : Path

    Raises
    ------
    RuntimeError
        The package, or a module of it, is not found there.

    """

    def __init__(self, checkout: Path):
        environment = dict(os.environ, PYTHONPATH=str(checkout.resolve()))
        # Compiled code of each checkout has a folder of its own, beside this one's.
        environment["NUMBA_CACHE_DIR"] = str(Path(os.environ["NUMBA_CACHE_DIR"]).parent)
        self._process = subprocess.Popen(
            [sys.executable, __file__], env=environment, cwd=checkout,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        try:
            modules = pickle.load(self._process.stdout)
        except EOFError:
            modules = ["nowhere"]
        strange = [m for m in modules if not Path(m).is_relative_to(checkout.resolve())]
        if strange:
            self.close()
            raise RuntimeError(f"{checkout} holds no checkout: {strange[0]} was taken")

    def play(self, parameters, samples, settled_ns=0):
        """Return what `play` does there."""
        pickle.dump((parameters, samples, settled_ns), self._process.stdin)
        self._process.stdin.flush()
        return Record(**pickle.load(self._process.stdout))

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()


@cache
def player_of(checkout: str) -> Callable[..., Record]:
    """Return `play` by a checkout, in one process of it for each of this one's; empty: here."""
    return Elsewhere(Path(checkout)).play if checkout else play


def _serve():
    # What the package prints is no answer.
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    ours = [m for name, m in sys.modules.items() if name.partition(".")[0] == "peg_on_hole_ros"]
    pickle.dump([str(Path(m.__file__).resolve()) for m in ours], answers)
    answers.flush()
    while True:
        try:
            request = pickle.load(sys.stdin.buffer)
        except EOFError:
            return
        pickle.dump(play(*request)._asdict(), answers)
        answers.flush()


if __name__ == "__main__":
    _serve()
