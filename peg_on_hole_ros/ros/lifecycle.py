"""Transitions of a lifecycle node whose errors are logged: rclpy drops them silently."""

from collections.abc import Callable
from functools import wraps

from rclpy.lifecycle import TransitionCallbackReturn

from peg_on_hole_ros.errors import PegOnHoleError
from peg_on_hole_ros.safe_text import printable

Transition = Callable[..., TransitionCallbackReturn]


def log_errors(transition: Transition) -> Transition:
    """
    Have an error of a transition logged, and answered as one: `on_error` of the node is next.

    Parameters
    ----------
    transition : callable
        Method of a LifecycleNode, such as `on_configure`.

    """

    @wraps(transition)
    def logged(node, state):
        try:
            return transition(node, state)
        except Exception as error:
            known = isinstance(error, PegOnHoleError)
            name = transition.__name__.removeprefix("on_")
            what = "recover from that" if name == "error" else name
            text = str(error) if known else f"cannot {what}: {error!r}"
            node.get_logger().error(printable(text))
            return TransitionCallbackReturn.ERROR

    return logged
