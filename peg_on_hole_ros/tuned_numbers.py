"""All tuned numbers of the package as one record, and as a list with unit and reason."""

import re
from inspect import cleandoc, getdoc
from typing import Any, NamedTuple

import numpy as np

from peg_on_hole_ros.diagnosis.tuned import DiagnosisNumbers
from peg_on_hole_ros.engine.tuned import EngineNumbers
from peg_on_hole_ros.estimator.settings import Settings, default_settings
from peg_on_hole_ros.estimator.tuned import EstimatorNumbers
from peg_on_hole_ros.identification.tuned import IdentificationNumbers
from peg_on_hole_ros.measurements.tuned import MeasurementNumbers
from peg_on_hole_ros.monitor.tuned import MonitorNumbers
from peg_on_hole_ros.setup_steps.tuned import SetupNumbers

# Fields of `Settings` that are no tuned numbers: how many there are of others, and what another
# method leaves out or does.
_NOT_TUNED = {
    "modes", "inertia", "direction_share", "products", "top_waits", "wrench_moves", "small_tilt",
    "psi_moves", "phi_moves", "sigma_points", "particles",
}  # fmt: skip
_ATTRIBUTE = re.compile(r"^(\w+) : .*\n((?:(?: +.*)?\n)*)", re.MULTILINE)
_UNIT = re.compile(r"\s*\[([^\]]+)\]")


class TunedNumbers(NamedTuple):
    """
    Tuned numbers by room; each is a record of subjects with a field for each number.

    Attributes
    ----------
    settings : Settings
        Those of the estimator that a method may change for one filter, as they are shipped.
    estimator : EstimatorNumbers
    measurements : MeasurementNumbers
    identification : IdentificationNumbers
    monitor : MonitorNumbers
    diagnosis : DiagnosisNumbers
    engine : EngineNumbers
    setup_steps : SetupNumbers

    """

    settings: Settings
    estimator: EstimatorNumbers = EstimatorNumbers()
    measurements: MeasurementNumbers = MeasurementNumbers()
    identification: IdentificationNumbers = IdentificationNumbers()
    monitor: MonitorNumbers = MonitorNumbers()
    diagnosis: DiagnosisNumbers = DiagnosisNumbers()
    engine: EngineNumbers = EngineNumbers()
    setup_steps: SetupNumbers = SetupNumbers()


class TunedNumber(NamedTuple):
    """
    One tuned number.

    Attributes
    ----------
    name : str
        Room, subject and field, with dots; of the estimator's settings `settings` and field.
    value : float, int or tuple of float
    unit : str
        Of SI, of what is counted, or `-`.
    reason : str
        What it does, and why it is about so large.

    """

    name: str
    value: Any
    unit: str
    reason: str


def tuned_numbers() -> TunedNumbers:
    """Return all of them."""
    return TunedNumbers(default_settings())


def listed(numbers: TunedNumbers) -> list[TunedNumber]:
    """
    Return a line for each number, in the order of rooms, subjects and fields.

    Unit and reason are those in the docstring of its class.

    Raises
    ------
    ValueError
        A number has no unit there, or no text.

    """
    found = _of_class("settings", Settings, _shipped(numbers.settings))
    rooms: dict[str, Any] = numbers._asdict()
    for room in numbers._fields[1:]:
        for subject, values in rooms[room]._asdict().items():
            found += _of_class(f"{room}.{subject}", type(values), values._asdict())
    return found


def subject_text(number: TunedNumber, numbers: TunedNumbers) -> str:
    """Return what the class of a number says of all its fields, one paragraph or more."""
    record: Any = numbers
    for part in number.name.split(".")[:-1]:
        record = getattr(record, part)
    kind = Settings if number.name.startswith("settings.") else type(record)
    return _text(kind).split("\nAttributes\n")[0].strip()


def _shipped(settings: Settings) -> dict[str, Any]:
    modes, found = int(settings.modes), {}
    for name in Settings.__annotations__:
        value = getattr(settings, name)
        array = isinstance(value, np.ndarray)
        found[name] = tuple(value[:modes].tolist()) if array else value.item()
    return {name: value for name, value in found.items() if name not in _NOT_TUNED}


def _of_class(prefix: str, kind: type, values: dict[str, Any]) -> list[TunedNumber]:
    texts = dict(_ATTRIBUTE.findall(_text(kind) + "\n"))
    found = []
    for name, value in values.items():
        text = " ".join(cleandoc(texts.get(name, "")).split())
        unit = _UNIT.search(text)
        if unit is None:
            raise ValueError(f"{prefix}.{name}: its docstring states no [unit]")
        reason = text[: unit.start()] + text[unit.end() :]
        found.append(TunedNumber(f"{prefix}.{name}", value, unit[1], reason))
    return found


def _text(kind: type) -> str:
    return getdoc(kind) or ""
