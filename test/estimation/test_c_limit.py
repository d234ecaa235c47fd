"""The filter step as C is the step that the kernel takes."""

import numpy as np
import pytest

import c_limit as race
from peg_on_hole_ros.configuration import from_parameters
from peg_on_hole_ros.edges.c_code import limit as c_limit
from peg_on_hole_ros.edges.c_code import translation as c_translation
from peg_on_hole_ros.edges.config_file import read_parameters
from peg_on_hole_ros.mechanics.kernel import compiled

needs_compiler = pytest.mark.skipif(c_limit.compiler() is not None, reason=str(c_limit.compiler()))


@needs_compiler
def test_c_gives_the_kernels_numbers():
    configuration = from_parameters(read_parameters(race.ROOT / "config" / f"{race.SAMPLE}.yaml"))
    limit, text = c_limit.build(("-O1", "-shared", "-fPIC"))
    assert limit is not None, text
    bench = race.Race(configuration, race.ROOT / "bags" / f"{race.SAMPLE}.mcap")
    before = bench.memory.copy()
    # Other orders of rounding, over 300 steps of a stable recursion.
    assert bench.difference(limit) < 1e-7
    assert np.abs(bench.memory - before).max() > 1e-3


def test_what_is_not_known_is_refused():
    @compiled
    def with_a_list(x):
        values = [x, x]
        return values[0]

    with pytest.raises(c_translation.TranslationError, match="with_a_list"):
        c_translation.Translation().add(with_a_list, [c_translation.D])


def test_without_a_compiler_it_says_so(monkeypatch, capsys):
    monkeypatch.setattr(c_limit, "COMPILER", "no-such-compiler")
    assert race.main([]) == 0
    assert "skipped: no no-such-compiler on this machine" in capsys.readouterr().out
