"""
ROS settings of every test, and a replayed bag for those that look at one.

The settings (this machine only, a domain of its own) must stand before rclpy loads: nothing of
the package but them is imported up here.
"""

import json
import os
import signal
import tempfile

import pytest
from hypothesis import settings

from peg_on_hole_ros.ros.local_dds import environment, free_domain

# A shell lets what it runs in the background ignore Ctrl-C, and so what that starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ.update(environment(free_domain()))
# What the processes of a run share, gone with the first of them.
RUN = "PEG_ON_HOLE_TEST_RUN"
if RUN not in os.environ:
    shared = tempfile.TemporaryDirectory(prefix="peg_on_hole_run_", ignore_cleanup_errors=True)
    os.environ[RUN] = shared.name
os.environ.setdefault("ROS_LOG_DIR", os.environ[RUN])

# How many examples: `HYPOTHESIS_PROFILE=nightly` for a run that may take its time.
settings.register_profile("push", max_examples=50, deadline=None)
settings.register_profile("nightly", max_examples=20_000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "push"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Keep the tests of a file in one worker: what they share is made and compiled once."""
    for item in items:
        if item.get_closest_marker("xdist_group") is None:
            item.add_marker(pytest.mark.xdist_group(item.path.stem))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    from small_bags import write_bag

    return write_bag(tmp_path_factory.mktemp("bag") / "a.mcap", count=400)


@pytest.fixture(scope="module")
def replayed(bag):
    from peg_on_hole_ros.cli.main import main

    folder = bag.parent
    out, summary = folder / "out.mcap", folder / "summary.json"
    assert main(["replay", str(bag), "--out", str(out), "--summary", str(summary)]) == 0
    return out, json.loads(summary.read_text(encoding="utf-8"))
