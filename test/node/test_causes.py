"""A setting that the wrench contradicts is named in the node's log, once."""

import re

import pytest
import rclpy

from peg_on_hole_ros.bags.reader import Bag
from peg_on_hole_ros.ros.diagnostics import Diagnostics
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init
from simulated import ROOT

pytestmark = pytest.mark.xdist_group("dds")

NOISE = "wrench.force_stddev: the noise of the force is {} times the stated one"


def test_figures_that_change_are_no_new_cause():
    diagnostics, logged = Diagnostics(), []
    for causes in (
        [],
        [NOISE.format(4.2)],
        [NOISE.format("1e+01"), "wrench: two"],
        [],
        # It comes and goes, and then has been gone for ten seconds.
        ["wrench: two"],
        *[[]] * 11,
        ["wrench: two"],
    ):
        for source in ("wrench", "joints"):
            diagnostics.received(source, 1)
        logged.append(diagnostics.report(0, 10**9, {}, {}, causes=causes)[1])
    again = [*[[]] * 13, ["wrench: two"]]
    assert logged == [[], [NOISE.format(4.2)], ["wrench: two"], *again]


def test_a_sign_that_is_stated_wrong_is_named_with_what_to_state():
    arguments = ["--ros-args", "-p", "wrench.acts_on:=robot"]
    init(arguments)
    try:
        node = PegOnHoleNode(arguments)
        node.trigger_configure()
        node.trigger_activate()
        lines = []
        node._warn = lambda said: lines.extend(said)
        take = {"/wrench": node.arrivals.wrench, "/joint_states": node.arrivals.joints}
        bag = Bag(ROOT / "bags" / "working_cycle.mcap")
        for count, (item, payload) in enumerate(bag.with_payloads(list(take))):
            take[item.topic](payload)
            node.process()
            if count % 1500 == 1499:
                node._report()
            if node._stream.causes and count % 1500 == 0:
                break
        node.close()
        node.destroy_node()
    finally:
        rclpy.shutdown()
    told = [line for line in lines if line.startswith("wrench: ")]
    assert len(told) == 1
    # What is wrong, what to set, and how that is known.
    assert re.match(
        r"wrench: the sign of the wrench is reversed: set wrench\.acts_on: peg; "
        r"with it the forces balance to .* N",
        told[0],
    )
