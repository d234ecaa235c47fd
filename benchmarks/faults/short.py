"""What falls short of the table of faults, with the reason. The list may only become shorter."""

import csv
from functools import cache
from pathlib import Path

LIST = Path(__file__).with_name("short.csv")
# By the word that the list has for it.
WHY = {
    "moved": "the move of the peg is detected 4 ms late",
    "mixed": "exchanged or frozen joints look like another motion, at times near the true one",
    "rest": "the values of a peg at rest do not change either",
    "slow": "in so short a time the peg turns by little more than the noise of the encoders",
    "short": "0.36 s on three contacts do not determine settings; in the hole other axes fit",
    "faint": "the loads of this cell are small against its noise: no setting stands out",
    "air": "the recording begins in the air, where only the weight is evidence",
    "turn": "at this tilt a turn about the peg's own axis looks like another psi",
    "begin": "the alarm is false for about 10 ms at the start, until the wrench is reported",
    "peak": "the largest of thousands of errors is 1 urad above the limit",
    "pounds": "a force that is too small by a factor fits another friction for that long",
    "weight": "under a load a wrong friction explains as much as a missing weight",
    "along": "a wrong friction explains a force along the peg, and is corrected slowly",
    "gears": "gears bend by more than the stated noise, here more than elsewhere",
    "end": "the recording ends within the fault: no later message can count the gap",
    "back": "the mode is declared again a few milliseconds late",
    "hole": "in the hole the bounds are too narrow, here slightly more than without the fault",
    "steps": "a stamp that is up to 4 ms wrong changes the angles by what the peg turns meanwhile",
    "chance": "coverage is 89 %, without the fault 93 % and more, in half a second of noise",
    "small": "in degrees, angles of this arm are within its limits, or the peg points away",
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
