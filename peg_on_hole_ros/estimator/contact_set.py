"""Which contacts a wrench is weighed with."""

from enum import IntEnum


class ContactSet(IntEnum):
    """
    Contacts that carry, by how many they are.

    THREE is K, B1 and B2 on the rim, TWO is K and B in the hole, NONE a peg that hangs free.
    UNKNOWN is not determined: the wrench does not correct the motion.
    """

    UNKNOWN = -1
    NONE = 0
    TWO = 2
    THREE = 3
