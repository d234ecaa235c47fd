"""The symbolic derivation in docs/ holds, and notices a wrong claim."""

import importlib.util

import pytest

from simulated import ROOT

PATH = ROOT / "docs" / "derivation" / "derive.py"


def load():
    spec = importlib.util.spec_from_file_location("derive", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.nightly
def test_every_claim_of_the_derivation_holds(capsys):
    count = load().main()
    assert count == capsys.readouterr().out.count("holds:") >= 30


def test_a_wrong_closed_form_is_noticed():
    derive = load()
    derive.STEPS = (lambda: iter([("wrong", derive.A1 * derive.c + derive.S1 - derive.A2)]),)
    derive.STEPS[0].__doc__ = "A wrong claim."
    with pytest.raises(SystemExit, match="does not hold: wrong"):
        derive.main()
