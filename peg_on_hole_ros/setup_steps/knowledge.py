"""How each setting of a cell is known, and what contradicts it."""

from typing import Any, NamedTuple

from peg_on_hole_ros.config.configuration import BY_NAME, check_one, from_parameters
from peg_on_hole_ros.config.options import Configuration
from peg_on_hole_ros.setup_steps.tuned import UNSTATED_PEG

MEASURED, STATED, FOLLOWS = "measured", "stated", "follows"
DEFAULT, UNKNOWN = "default", "not known"


class Known(NamedTuple):
    """
    How a setting is known.

    Attributes
    ----------
    kind : str
        One of the words above.
    how : str
        By what, with its uncertainty; or, of what is not known, what to state or record.

    """

    kind: str
    how: str = ""

    def __str__(self) -> str:
        """Return both as one text."""
        return f"{self.kind}: {self.how}" if self.how else self.kind

    def alone(self) -> "Known":
        """Return it without what was compared with it, which is to be compared anew."""
        return self._replace(how=self.how.partition("; ")[0])


class Contradiction(NamedTuple):
    """
    What does not fit a setting.

    Attributes
    ----------
    name : str
        Of the parameter.
    text : str
        What, by how much, and the remedy.

    """

    name: str
    text: str

    def __str__(self) -> str:
        """Return both as one text, the name once."""
        return self.text if self.text.startswith(self.name) else f"{self.name}: {self.text}"


class Cell:
    """
    The settings of a cell as far as they have been found, each with how it is known.

    Parameters
    ----------
    values : dict of str to value
        Parameters that are stated.
    origin : str
        By what.

    Attributes
    ----------
    values : dict of str to value
        All that is not a default.
    known : dict of str to Known
    contradictions : list of Contradiction

    """

    def __init__(self, values: dict[str, object], origin: str) -> None:
        self.values: dict[str, Any] = dict(values)
        self.known = {name: Known(STATED, f"by {origin}") for name in values}
        self.contradictions: list[Contradiction] = []

    def put(self, name: str, value: object, known: Known) -> None:
        """
        Set a parameter.

        Raises
        ------
        PegOnHoleError
            The value is none of this parameter.

        """
        self.values[name] = check_one(name, value)
        self.known[name] = known

    def tell(self, name: str, known: Known) -> None:
        """Say how the value that a parameter has is known."""
        self.known[name] = known

    def add(self, name: str, more: str) -> None:
        """Say more of how a parameter is known."""
        before = self.how(name)
        self.known[name] = before._replace(how=f"{before.how}; {more}" if before.how else more)

    def make_room(self) -> None:
        """Give a peg of which nobody has stated the diameter one that the hole has room for."""
        hole, peg = "scene.hole_diameter", "scene.peg_diameter"
        if not self.is_given(peg) and self.value(peg) >= self.value(hole):
            size = UNSTATED_PEG.of_hole * self.value(hole)
            self.put(peg, size, Known(UNKNOWN, "gauge the shank and state it"))

    def contradict(self, name: str, text: str) -> None:
        """Note what does not fit a parameter."""
        self.contradictions.append(Contradiction(name, text))
        self.add(name, f"CONTRADICTED: {text}")

    def is_contradicted(self, name: str) -> bool:
        """Return whether something does not fit a parameter."""
        return any(each.name == name for each in self.contradictions)

    def is_given(self, name: str) -> bool:
        """Return whether a parameter is stated, or measured."""
        return name in self.values and self.how(name).kind != UNKNOWN

    def how(self, name: str) -> Known:
        """Return how a parameter is known."""
        return self.known.get(name, Known(DEFAULT))

    def value(self, name: str) -> Any:
        """Return the value of a parameter."""
        return self.values.get(name, BY_NAME[name].default)

    def configuration(self) -> Configuration:
        """
        Return the settings as they are used.

        Raises
        ------
        PegOnHoleError
            They do not fit together.

        """
        return from_parameters(self.values)

    def open_settings(self) -> list[str]:
        """Return a line for each setting that is not known: what to do about it."""
        return [
            f"{name}: {known.how}" for name, known in self.known.items() if known.kind == UNKNOWN
        ]
