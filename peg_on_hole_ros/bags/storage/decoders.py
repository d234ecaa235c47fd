"""From the definition of a channel, the bag's or this package's, to what reads its messages."""

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from mcap.records import Channel, Schema
from mcap_ros2.decoder import DecoderFactory

from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE
from peg_on_hole_ros.messages.definitions import definition

_PRIMITIVE_TYPE = re.compile(
    r"(bool|byte|char|float32|float64|u?int(8|16|32|64)|w?string(<=\d+)?)$"
)
_FIELD_NAME = re.compile(r"[A-Za-z]\w*$")
_ARRAY = re.compile(r"\[(<=)?\d*\]$")
# For ROS 2 a part of its language, in a bag or not.
_BUILT_IN = ("builtin_interfaces/Time", "builtin_interfaces/Duration")
_MOST_FIELDS = 10_000


class SchemaDecoding(NamedTuple):
    """
    What decodes the messages of a channel.

    Attributes
    ----------
    schema : Schema or None
        None: nothing does.
    usual : bool
        Whether it lays messages out as the own definition does.
    stamped : bool
        Whether messages begin with a header.
    lacking : str
        What is missing in the bag's definition, so that the own one serves; empty: nothing is.

    """

    schema: Schema | None
    usual: bool
    stamped: bool
    lacking: str = ""


def serving(schema: Schema | None) -> SchemaDecoding:
    """Return what decodes messages of a schema; None: the bag has none."""
    if schema is None:
        return SchemaDecoding(None, False, False)
    own = own_schema(schema.id, schema.name)
    if not schema.data.strip() or schema.encoding != "ros2msg":
        # Some recorders leave the definition out, or have it as IDL, from which the same bytes
        # come; that of a type known here will do.
        return SchemaDecoding(own, own is not None, _stamped(own))
    try:
        parts = _parts(schema.data.decode(), schema.name)
        lacking = ", ".join(_lacking(parts, _short(schema.name)))
    except (ValueError, UnicodeDecodeError):
        parts, lacking = None, "all of its fields"
    if lacking:
        return SchemaDecoding(own, own is not None, _stamped(own), lacking)
    usual = own is not None and _flat(parts, schema.name) == _flat(
        _parts(own.data.decode(), schema.name), schema.name
    )
    return SchemaDecoding(schema, usual, _stamped(schema))


def own_schema(number: int, ros_type: str) -> Schema | None:
    """Return a schema of the own definition of a type, or None where it is not known."""
    try:
        text = definition(ros_type)
    except KeyError:
        return None
    return Schema(id=number, name=ros_type, encoding="ros2msg", data=text.encode())


def _short(name):
    return name.replace("/msg/", "/")


def _parts(text, name):
    """Return fields, as type and name, of each type in a definition; ValueError: it is none."""
    parts, current = {}, _short(name)
    parts[current] = []
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        if not line or set(line) == {"="}:
            continue
        if line.startswith("MSG:"):
            current = _short(line[4:].strip())
            parts[current] = []
            continue
        kind, _, rest = line.partition(" ")
        field, _, more = rest.strip().partition(" ")
        if "=" in field or more.strip().startswith("="):
            continue  # a constant
        if not field or not _FIELD_NAME.match(field):
            raise ValueError(line)
        array = _ARRAY.search(kind)
        base = kind[: array.start()] if array else kind
        if not _PRIMITIVE_TYPE.match(base):
            if base == "Header":
                base = "std_msgs/Header"
            base = _short(base) if "/" in base else f"{current.split('/')[0]}/{base}"
        parts[current].append((base, array[0] if array else "", field))
    return parts


def _lacking(parts, name):
    """Return types that are used and not defined; the whole type, if it has no fields."""
    used = {base for fields in parts.values() for base, _, _ in fields}
    missing = [b for b in sorted(used) if not _PRIMITIVE_TYPE.match(b) and b not in parts]
    missing = [base for base in missing if base not in _BUILT_IN]
    return missing if missing or parts[name] else ["all of its fields"]


def _flat(parts, name):
    """Return the kinds of all numbers and texts of a message, in their order, or None."""
    kinds, stack, taken = [], [("", _short(name))], 0
    while stack:
        prefix, base = stack.pop()
        taken += 1
        if taken + len(stack) > _MOST_FIELDS or len(prefix) > _MOST_FIELDS:
            return None  # it contains itself
        if base in _BUILT_IN:
            kinds.append(prefix + base)
        elif base in parts:
            kinds += [prefix + "{"] if prefix else []
            stack += [(prefix + array, inner) for inner, array, _ in reversed(parts[base])]
        else:
            kinds.append(prefix + base)
    return kinds


def _stamped(schema):
    """Return whether the first field is a header."""
    if schema is None:
        return False
    fields = _parts(schema.data.decode(), schema.name)[_short(schema.name)]
    return bool(fields) and fields[0][:2] == ("std_msgs/Header", "")


class Decoder(NamedTuple):
    """
    What reads the messages of a channel.

    Attributes
    ----------
    number : int
        Place of its topic among those that are read.
    topic : str
    decode : callable
        From a payload to a message, fields as attributes.
    columns : str
        The type, where messages can be read many at once; else empty.

    """

    number: int
    topic: str
    decode: Callable[[bytes], Any]
    columns: str


def decoders_of(
    path: Path,
    channels: Iterable[Channel],
    schemas: dict[int, Schema],
    types: dict[str, str | None],
) -> dict[int, Decoder]:
    """
    Return a decoder for each channel of some topics.

    Parameters
    ----------
    path : Path
        Of the file, for errors.
    channels : iterable of Channel
    schemas : dict of int to Schema
    types : dict of str to str or None
        Topics, and what is read where the bag does not say of which type they are.

    Raises
    ------
    BagError
        A definition that cannot be read, of a type that is not known.

    """
    factory = DecoderFactory()
    numbers = {topic: i for i, topic in enumerate(types)}
    decoders = {}
    for channel in channels:
        if channel.topic not in types:
            continue
        schema = schemas.get(channel.schema_id)
        wanted = types[channel.topic]
        found = serving(schema)
        if schema is None and wanted:
            found = serving(own_schema(0, wanted))
        if schema is None and not wanted:
            continue
        name = schema.name if schema else wanted
        if found.schema is None:
            raise BagError(
                f"{path}: the definition of {name} on {channel.topic} cannot be read, and "
                f"the type is not one that is known: it lacks {found.lacking or 'its text'}"
            )
        try:
            decode = factory.decoder_for(channel.message_encoding, found.schema)
        except Exception as error:
            # The parser of definitions has a dozen exceptions with no base but this.
            raise BagError(
                f"{path}: the definition of {name} on {channel.topic} cannot be read: {error}"
            ) from None
        if decode is not None:
            columns = found.usual and name in (WRENCH_TYPE, JOINTS_TYPE)
            decoders[channel.id] = Decoder(
                numbers[channel.topic],
                channel.topic,
                decode,
                name if columns else "",  # type: ignore[arg-type]
            )
    return decoders
