"""DDS that stays on this machine, in a domain of its own: for the demonstration and the tests."""

import os
import socket
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from peg_on_hole_ros.errors import PegOnHoleError

PROFILE = Path(__file__).with_name("fastdds_local.xml")
_RESERVED: list[socket.socket] = []
LAST_DOMAIN = 101  # above it, the ports of DDS run into the ephemeral ones of Linux


def free_domain() -> int:
    """
    Return a domain id, 1 to 101, in which no participant of this machine is.

    It is this process's until that ends: nobody else is given it, not even before anyone joins.

    Raises
    ------
    PegOnHoleError
        If all are taken.

    """
    first = os.getpid() % LAST_DOMAIN
    for offset in range(LAST_DOMAIN):
        domain = 1 + (first + offset) % LAST_DOMAIN
        if _is_free(domain) and _reserve(domain):
            return domain
    raise PegOnHoleError(f"all DDS domains 1 to {LAST_DOMAIN} are taken: end a ROS process first")


def environment(domain: int) -> dict[str, str]:
    """
    Return the variables that keep ROS 2 with Fast DDS on this machine and in `domain`.

    Shared memory is left out on purpose: a killed process leaves files behind that make the next
    one fail. The profile has one name in Kilted and another in Jazzy.
    """
    return {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_DOMAIN_ID": str(domain),
        "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
        _profiles_variable(): str(PROFILE),
        "ROS_PYTHON_CHECK_FIELDS": "1",
    }


def _profiles_variable():
    try:
        old = int(version("rclpy").split(".")[0]) < 9
    except PackageNotFoundError:
        old = False
    return f"{'FASTRTPS' if old else 'FASTDDS'}_DEFAULT_PROFILES_FILE"


def _reserve(domain):
    """Take a name that only one process has, and that goes with it."""
    name = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        name.bind(f"\0peg_on_hole_ros.dds_domain.{domain}")
    except OSError:
        name.close()
        return False
    _RESERVED.append(name)
    return True


def _is_free(domain):
    port = 7400 + 250 * domain + 10  # unicast discovery of the domain's first participant
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True
