"""How a message is serialised, by its first two bytes: what is read, and names of the rest."""

# CDR of the first version, in either order of bytes.
READ = b"\0\0", b"\0\1"
# DDS-XTypes 1.3, table 60.
_NAMES = {
    0x0002: "a parameter list in big-endian CDR",
    0x0003: "a parameter list in CDR",
    0x0006: "big-endian XCDR2",
    0x0007: "XCDR2",
    0x0008: "big-endian delimited XCDR2",
    0x0009: "delimited XCDR2",
    0x000A: "a parameter list in big-endian XCDR2",
    0x000B: "a parameter list in XCDR2",
}


def foreign(payload: bytes) -> str:
    """Return the name of a serialisation that is not read; empty: it is, or is cut off."""
    kind = bytes(payload[:2])
    if kind in READ or len(kind) < 2:
        return ""
    number = int.from_bytes(kind, "big")
    return f"{_NAMES.get(number, 'no CDR')} (0x{number:04x})"
