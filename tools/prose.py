"""
Check how the documents are written: words, sentences without a subject, numbers without a unit.

    python tools/prose.py [PAGE | SOURCE.py ...]

Prints a line for each finding, and what to write in its place; the exit code is 1 if there is one.
Without arguments, it checks the README files, CONTRIBUTING.md and docs/, except for those that
`tools/prose.toml` exempts, and the texts that the program prints. That file has
the words, too. The length of a sentence is not limited.

The texts of the program are the strings in its sources that contain a blank and are no docstrings.
Only their words are checked: a text may be a part of a sentence.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import tomllib

ROOT = Path(__file__).parents[1]
RULES = ROOT / "tools" / "prose.toml"


class Finding(NamedTuple):
    """What is wrong on a page: the line, the words there, and what to write in their place."""

    line: int
    found: str
    instead: str


# What is no prose: fenced and indented code, comments, tags, targets of links, code in a line.
_FENCE = re.compile(r"^(```|~~~).*?^\1[ \t]*$", re.M | re.S)
_INDENTED = re.compile(r"(?:(?<=\n\n)|\A)(?: {4}(?![-*+] |\d+\. ).*\n)(?:(?: {4}.*)?\n)*")
_COMMENT = re.compile(r"<!--.*?-->", re.S)
_TAG = re.compile(r"</?[a-zA-Z][^>\n]*>")
_TARGET = re.compile(r"(?<=\])\([^)\n]*\)")
_CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.S)

# A sentence begins after the end of another one, or with a paragraph or an item.
_ITEM = re.compile(r"^\s*(?:[-*+>]|\d+\.)\s+")
_END = re.compile(r"(?<=[.?!:])[\"*)]*\s+(?=[\"*(]*[A-Z])")
_ABBREVIATION = re.compile(r"(?:\b(?:e\.g|i\.e|cf|Fig|fig|eq|eqs|No|vs|[A-Z]))\.$")
# Nouns that end as a participle does.
_NOUNS = "speed|feed|need|seed|bed|shed|weed|breed"
_PARTICIPLE = (
    rf"(?!(?:{_NOUNS})\b)(?:[a-z]+ed|found|known|kept|given|left|seen|shown|drawn|taken|bound)"
)
_NO_SUBJECT = (
    (
        re.compile(
            r"(?:none|nothing|neither) (?:does|do|is|are|has|have|can|of (?:it|them|these))\b"
        ),
        "name what none of it does",
    ),
    (
        re.compile(
            rf"(?:not )?(?:{_PARTICIPLE}|open|worse|better)(?: out| off| up| in)? "
            r"(?:is|are|was|were)\b"
        ),
        "begin with what is found, kept or left",
    ),
    (
        re.compile(
            r"(?:is|are|was|were|has|have|does|makes|gives|takes|shows|needs|holds|stays|uses|"
            r"keeps|becomes|remains|means|comes|goes)\b(?!.*\?$)"
        ),
        "begin with the subject",
    ),
)

_ROW = re.compile(r"^\s*\|(.*)\|\s*$")
_RULE = re.compile(r"^\s*\|?(?:\s*:?-+:?\s*\|)+(?:\s*:?-+:?\s*)?$")
_CELL = re.compile(r"(?<!\\)\|")
_NUMBER = re.compile(r"[-+~]?\d[\d .,]*(?:e[-+]?\d+)?(?:(?: to |, |; | / )[-+]?\d[\d.,]*)*")
# A head that names a unit, or a quantity that has none.
_UNIT = re.compile(
    r"\[[^\]]+\]|%|\b(?:s|ms|us|N|kN|N m|m|mm|um|rad|mrad|Hz|kHz|V|g|kg|seconds|unit|"
    r"number|numbers|count|counts|times|share|ratio|factor|probability|risk|code|level|depth of|"
    r"default|version|year|port|limit|found|NIS|over|divided by|friction|lambda|l/d)\b"
)


def masked(text: str) -> str:
    """Return a page with all that is no prose blanked out; every character keeps its place."""

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    def code(match: re.Match[str]) -> str:
        # A name in code is a noun: it may be the subject.
        inside = re.sub(r"[^\n]", "x", match[0])
        return "X" + inside[1:]

    for pattern in (_COMMENT, _FENCE, _INDENTED):
        text = pattern.sub(blank, text)
    text = _CODE.sub(code, text)
    for pattern in (_TAG, _TARGET):
        text = pattern.sub(blank, text)
    return text


def words(text: str, rules: list[dict[str, str]]) -> Iterator[Finding]:
    """Find words that have a better one; the text is masked."""
    for rule in rules:
        spaced = rule["find"].replace(" ", r"\s+").replace(r"(?<!standard\s+)", "(?<!standard )")
        spaced = spaced.replace(r"(?<!smallest\s+)", "(?<!smallest )")
        for match in re.finditer(rf"\b(?:{spaced})\b", text, re.I):
            before = text[: match.start()]
            if match[0].lower().startswith("deviation") and re.search(r"standard\s+$", before):
                continue
            yield Finding(before.count("\n") + 1, " ".join(match[0].split()), rule["say"])


def paragraphs(text: str) -> Iterator[tuple[int, str]]:
    """Yield paragraphs and items as one line each, by the number of their first line."""
    first, parts = 0, []
    for number, line in enumerate([*text.split("\n"), ""], 1):
        bare = line.strip()
        ends = not bare or bare.startswith(("#", "|", "!"))
        if (ends or _ITEM.match(line)) and parts:
            yield first, " ".join(parts)
            parts = []
        if ends:
            continue
        if not parts:
            first = number
        parts.append(_ITEM.sub("", line).strip())


def sentences(paragraph: str) -> Iterator[str]:
    """Yield the sentences of a paragraph."""
    begin = 0
    for match in _END.finditer(paragraph):
        if not _ABBREVIATION.search(paragraph[: match.start()]):
            yield paragraph[begin : match.start()].strip()
            begin = match.end()
    yield paragraph[begin:].strip()


def without_subject(text: str) -> Iterator[Finding]:
    """Find sentences that begin without their subject; the text is masked."""
    for line, paragraph in paragraphs(text):
        for sentence in sentences(paragraph):
            bare = sentence.lstrip('"*_([ ')
            if not bare[:1].isupper():
                continue
            for pattern, instead in _NO_SUBJECT:
                match = pattern.match(bare[:1].lower() + bare[1:])
                if match:
                    yield Finding(line, bare[: match.end()], instead)
                    break


def tables(text: str) -> Iterator[tuple[int, list[str], list[list[str]]]]:
    """Yield tables: the number of the line of the heads, heads, rows."""
    lines = text.split("\n")
    for i in range(len(lines) - 1):
        if not (_ROW.match(lines[i]) and _RULE.match(lines[i + 1])):
            continue
        rows = []
        for line in lines[i + 2 :]:
            found = _ROW.match(line)
            if not found:
                break
            rows.append(_cells(found[1]))
        yield i + 1, _cells(lines[i].strip().strip("|")), rows


def _cells(row: str) -> list[str]:
    return [cell.strip().strip("*") for cell in _CELL.split(row)]


def without_unit(text: str) -> Iterator[Finding]:
    """Find columns of bare numbers whose head has no unit; code is not masked."""
    for line, heads, rows in tables(text):
        # A column has the units, or the first head is what all numbers count.
        if "unit" in heads or re.match(r"(?:number|count|share)s? of\b", heads[0]):
            continue
        for k, head in enumerate(heads[1:], 1):
            cells = [(row[0], row[k]) for row in rows if k < len(row) and row[k]]
            numbers = [(name, cell) for name, cell in cells if _NUMBER.fullmatch(cell)]
            bare = [name for name, _ in numbers if not _UNIT.search(name)]
            if (
                len(numbers) >= 2
                and 2 * len(numbers) > len(cells)
                and bare
                and not _UNIT.search(head)
            ):
                yield Finding(
                    line, head or "a head without a name", "add [unit], or name the count"
                )


def printed(source: str) -> Iterator[tuple[int, str]]:
    """Yield the texts of a Python source by their lines: strings with a blank, no docstrings."""
    tree = ast.parse(source)
    # Docstrings, and strings that document an attribute, are statements of their own.
    documents = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    parts = {
        id(part)
        for node in ast.walk(tree)
        if isinstance(node, ast.JoinedStr)
        for part in node.values
    }
    for node in ast.walk(tree):
        if id(node) in documents or id(node) in parts:
            continue
        if isinstance(node, ast.JoinedStr):
            # A value stands for a noun; a text within its expression is yielded by itself.
            text = "".join(
                str(part.value) if isinstance(part, ast.Constant) else "X" for part in node.values
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
        else:
            continue
        if " " in text.strip():
            yield node.lineno, text


def wordings(source: str, given: dict) -> list[Finding]:
    """Return the words in the texts of a Python source that have a better one."""
    found = []
    for line, text in printed(source):
        for kept in given["kept_texts"]:
            text = text.replace(kept, "")
        for each in words(masked(text), given["words"]):
            found.append(each._replace(line=line))
    return sorted(set(found))


def findings(text: str, rules: list[dict[str, str]]) -> list[Finding]:
    """Return all that is found on a page, from above."""
    prose = masked(text)
    blocks = _FENCE.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    found = [*words(prose, rules), *without_subject(prose), *without_unit(blocks)]
    return sorted(set(found))


def pages() -> list[Path]:
    """Return all pages."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def sources() -> list[Path]:
    """Return all sources of the program, whose texts users read."""
    return sorted(
        path for room in ("peg_on_hole_ros", "launch") for path in (ROOT / room).rglob("*.py")
    )


def main(arguments: list[str]) -> int:
    """Check pages and texts of the program, and print what is found."""
    given = tomllib.loads(RULES.read_text(encoding="utf-8"))
    exempt = {ROOT / name for name in given["exempt"]}
    missing = [path for path in exempt if not path.exists()]
    chosen = [Path(each).resolve() for each in arguments]
    count = 0
    for path in missing:
        print(f"{RULES.name}: {path.relative_to(ROOT)} is exempt, and does not exist")
    for page in chosen or [*(page for page in pages() if page not in exempt), *sources()]:
        name = page.relative_to(ROOT) if page.is_relative_to(ROOT) else page
        text = page.read_text(encoding="utf-8")
        is_source = page.suffix == ".py"
        for line, found, instead in (
            wordings(text, given) if is_source else findings(text, given["words"])
        ):
            count += 1
            print(f'{name}:{line}: "{found}": {instead}')
    return 1 if count or missing else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
