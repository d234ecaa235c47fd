"""What is still possible beside an alarm: the plan from the present state, in a sentence."""

from dataclasses import replace

import numpy as np

from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.estimator.state import RATE
from peg_on_hole_ros.mechanics.planning.cell import Cell
from peg_on_hole_ros.mechanics.planning.motion import NEAREST_TO_GAMMA0
from peg_on_hole_ros.mechanics.planning.steady import holder_law, steady_loads
from peg_on_hole_ros.mechanics.planning.words import advice
from peg_on_hole_ros.mechanics.scene import Scene
from peg_on_hole_ros.monitor.output_view import OutputView
from peg_on_hole_ros.monitor.tuned import PRESENT_STATE
from peg_on_hole_ros.records import Alarm
from peg_on_hole_ros.typed_record import Floats

# Alarms that a motion on three contacts can be chosen against.
_ADVISED = ("jamming", "overload")


class StillPossible:
    """
    Says beside an alarm what is still possible, and keeps to it while the alarm lasts.

    An alarm goes out at once; the plan, which takes milliseconds, is made at the next stamp.

    Parameters
    ----------
    configuration : Configuration
        For scene, holder and limits.

    Attributes
    ----------
    due : bool
        Whether there is a sentence to be made.

    """

    def __init__(self, configuration: Configuration) -> None:
        self.configuration = configuration
        self.due = False
        self._levels: dict[str, int] = {}
        self._sentence = ""

    def take(self, configuration: Configuration) -> None:
        """Use other settings from here on."""
        self.configuration = configuration

    def beside(self, outputs: OutputView) -> tuple[Alarm, ...]:
        """Return the alarms of a stamp, with the sentence where there is one."""
        levels = {a.name: a.level for a in outputs.alarms if a.name in _ADVISED}
        risen = any(level > self._levels.get(name, 0) for name, level in levels.items())
        if risen or not any(levels.values()):
            self.due, self._sentence = risen, ""
        elif self.due:
            self.due, self._sentence = False, possible(outputs, self.configuration)
        self._levels = levels
        if not self._sentence:
            return outputs.alarms
        return tuple(
            alarm._replace(message=f"{alarm.message}; {self._sentence}")
            if alarm.level and alarm.name in _ADVISED
            else alarm
            for alarm in outputs.alarms
        )


def possible(outputs: OutputView, configuration: Configuration) -> str:
    """
    Return what keeps the limits from the state of a stamp, with the push that there was.

    Parameters
    ----------
    outputs : OutputView
    configuration : Configuration
        Friction and clearance are taken as they are known by now.

    Returns
    -------
    str
        Empty where the peg is not on three contacts.

    """
    scene, gamma = _known(outputs, configuration.scene), float(outputs.state[0])
    if outputs.contact_mode != "three_point" or not gamma > scene.gamma0 + NEAREST_TO_GAMMA0:
        return ""
    rates = _rates(outputs, scene)
    push = _push(outputs, scene, configuration.plan, rates)
    cell = replace(configuration.plan, press=push)
    sentence = advice(scene, cell, configuration.monitor.max_normal, gamma, rates)
    return f"at {np.linalg.norm(push):.2g} N of push: {sentence}"


def _known(outputs: OutputView, scene: Scene) -> Scene:
    numbers, stated = outputs.monitor, scene.hole_diameter - scene.peg_diameter
    # A clearance of nothing has no gamma0.
    clearance = max(numbers["clearance"], PRESENT_STATE.least_clearance * stated)
    return replace(
        scene,
        peg_diameter=scene.hole_diameter - clearance,
        clearance_stddev=numbers["clearance_stddev"],
        friction=min(max(numbers["friction"], 0.0), 2.0),
        friction_stddev=min(numbers["friction_stddev"], 1.0),
    )


def _rates(outputs: OutputView, scene: Scene) -> Floats:
    """Return closing, and a turn beyond its uncertainty; how it parts in two is hardly known."""
    ratio = scene.peg_diameter / scene.hole_diameter
    weights = np.array([1.0, ratio])
    turn = float(weights @ outputs.state[RATE + 1 :])
    variance = float(weights @ outputs.state_covariance[RATE + 1 :, RATE + 1 :] @ weights)
    closing = min(float(outputs.state[RATE]), 0.0)
    return np.array(
        [closing, 0.0, turn / ratio if turn * turn > PRESENT_STATE.sure**2 * variance else 0.0]
    )


def _push(
    outputs: OutputView, scene: Scene, cell: Cell, rates: Floats
) -> tuple[float, float, float]:
    """Return what the holder presses beside the weight, less what its lag gives."""
    psi = outputs.state[1]
    c, s = np.cos(psi), np.sin(psi)
    push = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ -outputs.contact_force.sum(axis=0)
    if np.any(rates):
        gamma = outputs.state[:1]
        pressed = replace(cell, press=tuple(push))
        lag = steady_loads(scene, pressed, gamma, rates, [scene.friction]).lag[:, 0, 0]
        law = holder_law(scene, cell, gamma, cell.stiffness, cell.rotational_stiffness)
        push = push - law[0, :3] @ lag
    along_h, along_e, along_z = map(float, push)
    return along_h, along_e, along_z
