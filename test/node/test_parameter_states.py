"""What the descriptors of parameters offer in each state of the node is what it takes, no more."""

import pytest
import rclpy
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.parameter import Parameter

from peg_on_hole_ros.config.parameter_table import PARAMETERS
from peg_on_hole_ros.ros.node import PegOnHoleNode
from peg_on_hole_ros.ros.process import init

pytestmark = pytest.mark.xdist_group("dds_starts")

LIVE = {row.name for row in PARAMETERS if row.live}
ALL = {row.name for row in PARAMETERS}


@pytest.fixture
def node():
    init([])
    try:
        made = PegOnHoleNode([])
        yield made
        made.close()
        made.destroy_node()
    finally:
        rclpy.shutdown()


def offered(node):
    """Return the parameters that are not read-only; each is set to its value once, or refused."""
    writable = set()
    for name in sorted(ALL):
        (descriptor,) = node.describe_parameters([name])
        present = Parameter(name, value=node.get_parameter(name).value)
        result = node.set_parameters_atomically([present])
        assert result.successful == (not descriptor.read_only), (name, result.reason)
        assert result.successful or result.reason.startswith(f"{name}: ")
        if not descriptor.read_only:
            writable.add(name)
    return writable


def test_what_is_offered_is_what_is_taken_in_every_state(node):
    # Once the process has started, nothing reads `autostart` any more.
    assert offered(node) == ALL - {"autostart"}
    assert node.trigger_configure() == TransitionCallbackReturn.SUCCESS
    assert offered(node) == LIVE
    assert node.trigger_activate() == TransitionCallbackReturn.SUCCESS
    assert offered(node) == LIVE
    assert node.trigger_deactivate() == TransitionCallbackReturn.SUCCESS
    assert offered(node) == LIVE
    assert node.trigger_cleanup() == TransitionCallbackReturn.SUCCESS
    assert offered(node) == ALL - {"autostart"}
    assert node.trigger_shutdown() == TransitionCallbackReturn.SUCCESS
    assert offered(node) == set()


def test_what_a_failed_transition_leaves_can_be_set_again(node, monkeypatch):
    def fail(*_):
        raise OSError("made up")

    node.trigger_configure()
    monkeypatch.setattr(node, "count_publishers", fail)
    monkeypatch.setattr(node, "create_timer", fail)
    assert node.trigger_activate() == TransitionCallbackReturn.ERROR
    # It is unconfigured again, and its estimator is gone.
    assert not node.is_configured and offered(node) == ALL - {"autostart"}


def test_a_node_whose_recovery_fails_is_finalized(node, monkeypatch):
    node.trigger_configure()
    monkeypatch.setattr(node, "create_timer", lambda *_, **__: 1 / 0)
    monkeypatch.setattr(node, "_release", lambda: 1 / 0)
    assert node.trigger_activate() == TransitionCallbackReturn.ERROR
    assert offered(node) == set()
