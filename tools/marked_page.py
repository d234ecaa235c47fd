"""Replaces what stands between two marks of a page."""

import re


def replaced(text: str, begin: str, end: str, block: str) -> str:
    """
    Return the text of a page with other content between two marks.

    Raises
    ------
    SystemExit
        The two marks do not stand there once.

    """
    text, count = re.subn(
        f"{begin}.*?{end}", lambda _: f"{begin}\n\n{block}\n\n{end}", text, flags=re.DOTALL
    )
    if count != 1:
        raise SystemExit(f"{begin} ... {end} is there {count} times")
    return text
