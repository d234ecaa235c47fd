"""Messages of rclpy as nested dicts, to be compared."""

from typing import Any


def to_plain(message: Any) -> object:
    """
    Return the fields of an rclpy message as nested dicts and lists of Python's own numbers.

    A byte field becomes its number.
    """
    if hasattr(message, "get_fields_and_field_types"):
        names = message.get_fields_and_field_types()
        return {name: to_plain(getattr(message, name)) for name in names}
    if isinstance(message, bytes):
        return message[0] if len(message) == 1 else list(message)
    if isinstance(message, (str, bool, int, float)):
        return message
    return [
        to_plain(item) for item in (message.tolist() if hasattr(message, "tolist") else message)
    ]
