"""The check of sentences counts words of prose, not code, tables or formulas."""

import runpy

import pytest

from simulated import ROOT

TOOL = runpy.run_path(str(ROOT / "tools" / "sentences.py"))
LONG = "One " + "word " * 24 + "more."


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("Short. Shorter!", 0),
        (LONG, 1),
        (f"{LONG} {LONG}\nShort.", 2),
        (f"- a point\n- {LONG}", 1),
        # A link counts by its text, and what is in code as one word.
        ("One " + "word " * 22 + "[more words](a/b.md) `x = 1 + 2`.", 1),
        ("One " + "word " * 21 + "[more words](a/b.md) `x = 1 + 2`.", 0),
        (f"    {LONG}\n", 0),
        (f"```\n{LONG}\n```\n", 0),
        (f"| {LONG} |\n", 0),
        (f"# {LONG}\n", 0),
        # No end: two halves are one sentence.
        ("Half " + "word " * 12 + "e.g. Half " + "word " * 12 + "more.", 1),
    ],
)
def test_long_sentences_are_found(text, count):
    assert len(TOOL["long_sentences"](text)) == count


def project(tmp_path, readme, page):
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(readme)
    (tmp_path / "docs" / "page.md").write_text(page)
    return tmp_path


def test_a_page_with_a_long_sentence_fails(tmp_path, capsys):
    assert TOOL["main"](project(tmp_path, "Fine.", LONG)) == 1
    assert "docs/page.md: 1 sentences of more than 25 words" in capsys.readouterr().out


def test_a_readme_that_is_too_long_fails(tmp_path, capsys):
    assert TOOL["main"](project(tmp_path, "Word. " * 1001, "Fine.")) == 1
    assert "README.md: 1001 words, more than 1000" in capsys.readouterr().out


def test_this_project_keeps_it(capsys):
    assert TOOL["main"](ROOT) == 0, capsys.readouterr().out
