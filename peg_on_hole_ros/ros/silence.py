"""Why nothing comes on a topic, as far as the publishers of others tell it."""

from rclpy.node import Node

from peg_on_hole_ros.config.options import Topics
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE

_MOST_NAMED = 4


def why_silent(node: Node, topics: Topics, source: str) -> str:
    """
    Return what is odd about the publishers of an input that is silent; empty: nothing is.

    Parameters
    ----------
    node : Node
        Who listens.
    topics : Topics
        To what.
    source : str
        `wrench` or `joints`.

    """
    name, kind = {
        "wrench": ("wrench", WRENCH_TYPE),
        "joints": ("joint_states", JOINTS_TYPE),
    }[source]
    topic = node.resolve_topic_name(getattr(topics, name))
    kinds = {info.topic_type for info in node.get_publishers_info_by_topic(topic)}
    if kind in kinds:
        return ""
    if kinds:
        return f"{topic} is {' and '.join(sorted(kinds))}, not {kind}"
    own = node.get_publisher_names_and_types_by_node(node.get_name(), node.get_namespace())
    left_out = {other for other, _ in own}
    others = sorted(
        other
        for other, found in node.get_topic_names_and_types()
        if kind in found and other not in left_out and node.count_publishers(other)
    )
    told = f"nobody publishes {topic}"
    if not others:
        return told
    more = " and more" if len(others) > _MOST_NAMED else ""
    return (
        f"{told}; of its type there is {', '.join(others[:_MOST_NAMED])}{more}: "
        f"state topics.{name}"
    )
