"""A short storm on a live node: what holds for ten minutes at night."""

import pytest

from benchmarks.faults import storm

pytestmark = [pytest.mark.xdist_group("dds"), pytest.mark.nightly, pytest.mark.timeout(900)]


def test_after_a_storm_a_clean_cycle_has_the_numbers_of_its_replay(tmp_path, monkeypatch):
    # All kinds of deeds within a short time, but the longest: to start another node.
    monkeypatch.setattr(
        storm, "DEEDS_DRAWN", dict.fromkeys(storm.DEEDS_DRAWN, 1) | {"kill_node": 0}
    )
    found = storm.run(10.0, tmp_path, seed=3)
    assert found["sound"], found
