"""What falls short of the table of faults, with the reason. The list may only become shorter."""

from typing import NamedTuple


class Short(NamedTuple):
    """Scenes, cases and kinds of `shortfalls` that go together, and why."""

    scenes: str
    cases: str
    kinds: str
    why: str


LIST: list[Short] = []


def known(scene: str, case: str) -> dict[str, str]:
    """Return which kinds fall short in a scene's case, with the reason of each."""
    return {
        kind: each.why
        for each in LIST
        if scene in each.scenes.split() and case in each.cases.split("; ")
        for kind in each.kinds.split()
    }
