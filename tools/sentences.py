"""
Tell which sentences of README and docs are longer than 25 words, and what the docs come to.

A page that has longer ones is listed in `ALLOWED` with how many, so that no page gets worse; one
that has become better lowers its number. `make lint` runs it from the root of the checkout.
"""

import re
import sys
from pathlib import Path

MOST = 25
MOST_WORDS = {"README.md": 1000, "docs": 31_950}
# Pages that are not there yet.
ALLOWED: dict[str, int] = {
    "docs/command_line.md": 12,
    "docs/derivation/README.md": 3,
    "docs/engine.md": 3,
    "docs/errata.md": 9,
    "docs/estimator.md": 3,
    "docs/grid.md": 2,
    "docs/insertion.md": 6,
    "docs/integration.md": 32,
    "docs/jamming.md": 26,
    "docs/limits.md": 1,
    "docs/mechanics.md": 12,
    "docs/modes.md": 4,
    "docs/notation.md": 1,
    "docs/plan.md": 5,
    "docs/scenes.md": 9,
    "docs/simulation.md": 3,
    "docs/timing.md": 2,
}

_FENCED = re.compile(r"^(```|~~~).*?^\1", re.M | re.S)
_DISPLAYED = re.compile(r"\$\$.*?\$\$|<!--.*?-->", re.S)
_INLINE = re.compile(r"`[^`\n]+`|\$[^$\n]+\$")
_LINK = re.compile(r"!?\[([^\]]*)\]\([^)]*\)")
_END = re.compile(r"(?<=[.!?:;])[)\"*_]*\s+(?=[A-Z0-9`*(\[\"])")
# An end of these is no end of a sentence.
_SHORT = re.compile(r"\b(e\.g|i\.e|cf|vs|eq|eqs|fig|no|p|pp|sec|resp|approx)\.", re.I)


def paragraphs(text: str) -> list[str]:
    """Return the running text of a page in Markdown: no code, no tables, no headings."""
    text = _DISPLAYED.sub(" ", _FENCED.sub("\n", text))
    found: list[list[str]] = [[]]
    for line in text.splitlines():
        bare = line.strip()
        if not bare or bare.startswith(("#", "|", "<")) or line.startswith("    "):
            found.append([])
            continue
        if re.match(r"([-*+]|\d+\.)\s", bare):
            found.append([])
            bare = re.sub(r"^([-*+]|\d+\.)\s+", "", bare)
        found[-1].append(bare)
    return [" ".join(lines) for lines in found if lines]


def sentences(paragraph: str) -> list[str]:
    """Return the sentences of a paragraph; a formula or a name in code is one word."""
    plain = _LINK.sub(r"\1", _INLINE.sub("X", paragraph))
    plain = _SHORT.sub(lambda match: match[0][:-1], plain)
    return [part for part in _END.split(plain) if part]


def words(text: str) -> int:
    """Return the number of words: what holds a letter or a digit."""
    return sum(any(c.isalnum() for c in word) for word in text.split())


def long_sentences(text: str) -> list[str]:
    """Return the sentences of a page that are too long."""
    found = (sentence for part in paragraphs(text) for sentence in sentences(part))
    return [sentence for sentence in found if words(sentence) > MOST]


def main(root: Path = Path(".")) -> int:
    """Print what is wrong; return 1 if anything is."""
    pages = [root / "README.md", *sorted((root / "docs").rglob("*.md"))]
    wrong = []
    for page in pages:
        name = page.relative_to(root).as_posix()
        found, allowed = long_sentences(page.read_text(encoding="utf-8")), ALLOWED.get(name, 0)
        if len(found) > allowed:
            wrong.append(
                f"{name}: {len(found)} sentences of more than {MOST} words, not {allowed}:"
            )
            wrong += [f"    {words(sentence)}: {sentence[:120]}" for sentence in found]
        elif len(found) < allowed:
            wrong.append(f"{name}: {len(found)} long sentences are left: lower ALLOWED to that")
    for place, most in MOST_WORDS.items():
        of = [page for page in pages if page.relative_to(root).as_posix().startswith(place)]
        count = sum(len(page.read_text(encoding="utf-8").split()) for page in of)
        if count > most:
            wrong.append(f"{place}: {count} words, more than {most}")
    print("\n".join(wrong), end="\n" if wrong else "")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
