"""
Play measured motions through the pipeline of whichever checkout Python finds.

As a program it answers requests from another checkout's grid: pickled (parameters, samples) on
standard input, pickled arrays on standard output. So two states of the package see the same
samples; what has changed its name between them is taken by either.
"""

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np

import peg_on_hole_ros
from peg_on_hole_ros.records import JointSample, WrenchSample

# The folder is asked, not the import: an editable install of another checkout would fill in
# whatever modules this one lacks.
if (Path(peg_on_hole_ros.__file__).parent / "engine").is_dir():
    from peg_on_hole_ros.config.configuration import from_parameters
    from peg_on_hole_ros.engine.pipeline import Pipeline
else:
    from peg_on_hole_ros.configuration import from_parameters
    from peg_on_hole_ros.pipeline import Pipeline


def play(parameters: dict, samples: list[tuple], settled_ns: int) -> dict:
    """
    Return what a pipeline says of samples.

    Parameters
    ----------
    parameters : dict
        Of the configuration, by dotted name.
    samples : list of tuple
        The fields of a JointSample or a WrenchSample.
    settled_ns : int
        Innovations are kept from this stamp on.

    Returns
    -------
    dict
        t_ns (n,), state (n, 6), covariance (n, 6, 6), normal, stddev (n, 3), determined, contact
        (n,) bool, friction (n, 2) with its deviation, nis: mean of the orientations' after
        `settled_ns`, restarts.

    """
    pipeline, nis, found, taken = Pipeline(from_parameters(parameters)), [], [], 0
    last_nis = _last_nis(pipeline.filter)
    for o in pipeline.play(map(_record, samples)):
        found.append(
            (
                o.t_ns, o.state, o.state_covariance, o.normal, o.normal_stddev,
                bool(o.monitor["reactions_determined"]), o.contact_mode == "three_point",
                (o.monitor.get("friction", np.nan), o.monitor.get("friction_stddev", 0.0)),
            )
        )  # fmt: skip
        # Of the last orientation; only the mean is published, and none comes with each wrench.
        now, before = pipeline.counts["joints_used"] + pipeline.counts["joints_gated"], taken
        taken, value = now, last_nis()
        if now > before and o.t_ns >= settled_ns and np.isfinite(value):
            nis.append(value)
    names = (
        "t_ns", "state", "covariance", "normal", "stddev", "determined", "contact", "friction"
    )  # fmt: skip
    columns = {name: np.array(column) for name, column in zip(names, zip(*found))}
    columns["nis"] = float(np.mean(nis)) if nis else float("nan")
    columns["restarts"] = pipeline.counts["filter_restarted"]
    return columns


def _record(sample):
    # The second field of a joint state is its names.
    kind = JointSample if isinstance(sample[1][0], str) else WrenchSample
    return kind(*sample)


def _last_nis(kalman):
    """Return what tells the normalised innovation of the last orientation."""
    if hasattr(kalman, "state"):
        return lambda: float(kalman.state.nis[0])
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

    def play(self, parameters, samples, settled_ns):
        """Return what `play` does there."""
        pickle.dump((parameters, samples, settled_ns), self._process.stdin)
        self._process.stdin.flush()
        return pickle.load(self._process.stdout)

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.stdout.close()
        self._process.wait()


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
        pickle.dump(play(*request), answers)
        answers.flush()


if __name__ == "__main__":
    _serve()
