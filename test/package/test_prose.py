"""The check of the pages' prose finds each kind of mistake, where it is, and nothing else."""

import re

import pytest
import tomllib

from scripts import loaded
from simulated import ROOT

PROSE = loaded(ROOT / "tools" / "prose.py")
GIVEN = tomllib.loads(PROSE.RULES.read_text(encoding="utf-8"))
RULES = GIVEN["words"]

CLEAN = """# Bounds of reactions

The filter estimates the tilt. It publishes `told` as it is, and its standard
deviation [rad] too. Speed is a
quantity. If nothing touches, the mode is `open`. Is it late? Then the count rises.

    Found is a command: peg-on-hole tell

```
surely learnt
```

<!-- what is told -->

- Let the peg hang free.
  `filter.method` chooses an estimator ([jamming](insertion.md#what-is-told-of-them)).
- Needles are thin.

| load | delay [ms] | count of alarms | result |
|---|---|---|---|
| 1 N | 3 | 4 | late |
| 2 N | 10 | 5 | 7 |

| load | found |
|---|---|
| error [N] | 3 |
| time [s] | 4.5 to 6 |

| number of cells | drawn | real |
|---|---|---|
| a plan is possible | 168 | 77 |
| it keeps all limits | 168 | 76 |

| number | unit | value |
|---|---|---|
| force | N | 3 |
| torque | N m | 4 |
"""


def found(text):
    return [(each.line, each.found) for each in PROSE.findings(text, RULES)]


def test_a_clean_page_passes():
    assert found(CLEAN) == []


@pytest.mark.parametrize(
    ("sentence", "word"),
    [
        ("A stall is told early.", "told"),
        ("The wrench says nothing of it.", "says"),
        ("Of a peg that surely slides.", "surely"),
        ("The friction is learnt.", "learnt"),
        ("The slopes are exact.", "slopes"),
        ("Two deviations are allowed.", "deviations"),
        ("It depends on what friction makes of it.", "makes of"),
        ("The bounds do not hold here.", "bounds do not hold"),
        ("Several frictions live.", "frictions"),
        ("gamma0 hangs\non the clearance.", "hangs on"),
    ],
)
def test_a_word_is_found_with_its_line(sentence, word):
    assert found(f"# Page\n\nThe first line.\n{sentence}\n") == [(4, word)]


def test_a_finding_states_what_to_write_instead():
    (each,) = PROSE.findings("The sensor's zero wanders.", RULES)
    assert each.instead == "drift; of a state of the filter: random walk"


@pytest.mark.parametrize(
    ("sentence", "begin"),
    [
        ("The peg opens. None does.", "None does"),
        ("The peg opens. Nothing is that jams.", "Nothing is"),
        ("- Not found is a step to another value.", "Not found is"),
        ("- Left out are two typestores.", "Left out are"),
        ("Compared is the load.", "Compared is"),
        ("It is late. Takes an eighth of a core.", "Takes"),
        ("It is late.\nIs dropped then.", "Is"),
    ],
)
def test_a_sentence_without_a_subject_is_found(sentence, begin):
    assert [each for _, each in found(sentence)] == ([begin] if begin else [])


@pytest.mark.parametrize(
    "sentence",
    [
        "Nothing in the hole is forecast by it.",
        "Speed is known.",
        "Open contacts are rare.",
        "Does it fit?",
    ],
)
def test_a_sentence_with_a_subject_passes(sentence):
    assert found(sentence) == []


def test_numbers_without_a_unit_are_found_at_the_head():
    page = (
        "Text.\n\n| load | delay | mode |\n|---|---|---|\n| 1 | 3 | open |\n| 2 | 4.5 | open |\n"
    )
    assert found(page) == [(3, "delay")]
    assert found(page.replace("delay", "delay [ms]")) == []
    # A table of words may have a number here and there.
    assert found(page.replace("| 3 |", "| late |")) == []


def test_pages_are_checked_and_those_that_are_not_yet_exist(capsys):
    assert PROSE.main([]) == 0, capsys.readouterr().out
    assert PROSE.main([str(ROOT / "docs" / "chart.md")]) in (0, 1)


def test_it_prints_page_line_word_and_remedy(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text("One.\n\nA load is told.\n", encoding="utf-8")
    assert PROSE.main([str(page)]) == 1
    assert re.fullmatch(r'.*page\.md:3: "told": estimate, .*\n', capsys.readouterr().out)


PROGRAM = '''"""What is told, by its module."""

KEY, NAMED = "told", {"the taken weight": "measured"}


def line(told, learnt):
    """Say what is told."""
    # What a comment says.
    size: int
    """Of what is learnt."""
    return f"reactions: not told, as {told} ({'a load, ' if learnt else 'no load, '}see above)"
'''


def test_texts_of_the_program_are_strings_with_a_blank_and_no_docstrings():
    assert sorted(PROSE.printed(PROGRAM)) == [
        (3, "the taken weight"),
        (11, "a load, "),
        (11, "no load, "),
        (11, "reactions: not told, as X (Xsee above)"),
    ]
    # Neither names nor what another program reads is a finding.
    assert PROSE.wordings(PROGRAM, GIVEN) == []


@pytest.mark.parametrize(
    ("code", "word"),
    [
        ("raise ValueError(f'{name} says nothing')", "says"),
        ("help='the load that\\n is learnt'", "learnt"),
        ('f\'{name}: {"the weight is taken off" if on else ""}\'', "taken off"),
        ("text = (\n    'a peg that '\n    f'surely hangs {how}'\n)", "surely"),
    ],
)
def test_a_word_in_a_text_of_the_program_is_found(tmp_path, capsys, code, word):
    source = tmp_path / "source.py"
    source.write_text(f"{code}\n", encoding="utf-8")
    assert PROSE.main([str(source)]) == 1
    assert re.search(rf'source\.py:[12]: "{word}": ', capsys.readouterr().out)


def test_texts_that_keep_a_word_exist():
    texts = [
        text
        for path in PROSE.sources()
        for _, text in PROSE.printed(path.read_text(encoding="utf-8"))
    ]
    # Help of a command, an alarm's advice, and an answer of a service are among them.
    for begin in ("also write the node's", "stop pushing", "there is no estimate at"):
        assert any(begin in text for text in texts)
    for kept in GIVEN["kept_texts"]:
        assert any(kept in text for text in texts)


def test_each_word_is_a_pattern_with_a_remedy():
    for rule in RULES:
        assert set(rule) == {"find", "say"} and rule["say"]
        re.compile(rule["find"])
