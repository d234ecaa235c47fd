"""Questions in the terminal: each with default, unit, range and what it means."""

from collections.abc import Callable

from peg_on_hole_ros.config.configuration import BY_NAME
from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import printable
from peg_on_hole_ros.setup_steps.knowledge import DEFAULT, STATED, UNKNOWN, Cell, Known
from peg_on_hole_ros.setup_steps.questions import Question, read_answer


class Dialogue:
    """
    Asks for what cannot be measured, or takes what is given.

    Parameters
    ----------
    cell : Cell
    asks : bool
        Whether anybody is there to answer.

    """

    def __init__(self, cell: Cell, asks: bool) -> None:
        self._cell, self.asks = cell, asks
        self._step = 0

    def heading(self, text: str) -> None:
        """Begin a step."""
        self._step += 1
        self.say(f"\n{self._step}. {text}")

    def say(self, text: str) -> None:
        """Print lines."""
        print("\n".join(map(printable, text.split("\n"))), flush=True)

    def ask(self, question: Question, check: Callable[[], None] = lambda: None) -> None:
        """Set a parameter by an answer that passes a check; an empty one keeps what it is."""
        cell, name = self._cell, question.name
        if not self.asks:
            self._keep(question)
            return
        row, now = BY_NAME[name], cell.value(name)
        limits = "" if row.low is None else f", {row.low:g} to {row.high:g}"
        choices = f", {' or '.join(row.choices)}" if row.choices else ""
        unit = f" [{row.unit}]" if row.unit else ""
        # A tuple as a user would write it.
        now = f"[{', '.join(f'{x:g}' for x in now)}]" if isinstance(now, (tuple, list)) else now
        self.say(f"\n{name}{unit}{limits}{choices}: {question.text}")

        def take(text):
            if not text:
                self._keep(question)
                return
            before = dict(cell.values), dict(cell.known)
            cell.put(name, read_answer(name, text), Known(STATED, "by an answer"))
            cell.make_room()
            try:
                cell.configuration()
                check()
            except PegOnHoleError:
                cell.values, cell.known = before
                raise

        self.repeat(f"{name} (Enter: {now}): ", take)

    def repeat(self, prompt: str, take: Callable[[str], None]) -> None:
        """Ask until an answer can be used; raises EOFError at the end of all answers."""
        while True:
            print(printable(prompt), end="", flush=True)
            try:
                take(input().strip())
                return
            except PegOnHoleError as error:
                self.say(f"  {error}")

    def _keep(self, question: Question) -> None:
        cell, name = self._cell, question.name
        if cell.is_given(name) or cell.how(name).kind not in (DEFAULT, UNKNOWN):
            return
        if question.missing:
            cell.tell(name, Known(UNKNOWN, f"{question.missing}; its default is used"))
