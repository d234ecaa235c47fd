"""What falls short of the table of faults, with the reason. The list may only become shorter."""

import csv
from functools import cache
from pathlib import Path

LIST = Path(__file__).with_name("short.csv")
# By the word that the list has for it.
WHY = {
    "moved": "that a peg was moved meanwhile is known four milliseconds later",
    "mixed": "joints that are mixed up or stand still make another motion, near enough at times",
    "rest": "a peg that rests moves no value either",
    "slow": "in so short a time the peg turns by little more than the encoders' noise",
    "short": "0.36 s of three contacts are too short to tell settings; in the hole other axes fit",
    "faint": "the loads of this cell are faint beside its noise: no setting stands out",
    "air": "the recording begins in the air, where only the peg's weight speaks",
    "turn": "a turn about the peg's own axis looks like another psi at this tilt",
    "begin": "false for some ten milliseconds at the begin, until the wrench is doubted",
    "peak": "the largest of thousands of errors, by a microradian more than the limit",
    "pounds": "a force that is too small by a factor fits another friction for as long",
    "weight": "under a load a friction that is off explains as much as a missing weight",
    "along": "a friction that is off explains a force along the peg, and is unlearnt slowly",
    "gears": "gears bend by more than the stated noise, here more than there",
    "end": "the recording ends within it: nothing comes after it that could count it",
    "back": "the mode is declared again a few milliseconds late",
    "hole": "in the hole the bounds of an insertion are too narrow, here a little more so",
    "steps": "a stamp that is up to 4 ms off moves the angles by what the peg turns meanwhile",
    "chance": "89 % for 93 % and more without the fault: half a second of noise tells no more",
    "small": "joints of this arm in degrees are within its limits, or point away",
}


@cache
def _rows():
    with LIST.open(newline="", encoding="utf-8") as file:
        return {
            (row["scene"], row["fault"], row["what"]): row["why"] for row in csv.DictReader(file)
        }


def listed() -> dict[tuple[str, str, str], str]:
    """Return the reason of each scene, fault and kind of `shortfalls` that falls short."""
    return {key: WHY[why] for key, why in _rows().items()}


def known(scene: str, fault: str) -> dict[str, str]:
    """Return which kinds fall short where a fault is put into a scene, with the reasons."""
    return {key[2]: WHY[why] for key, why in _rows().items() if key[:2] == (scene, fault)}
