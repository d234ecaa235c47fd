"""From the channels of a file to what reads their messages."""

from collections.abc import Callable
from typing import Any, NamedTuple

from mcap_ros2.decoder import DecoderFactory

from peg_on_hole_ros.bags.first_pass import Found
from peg_on_hole_ros.bags.schemas import own_schema, serving
from peg_on_hole_ros.errors import BagError
from peg_on_hole_ros.messages.decode import JOINTS_TYPE, WRENCH_TYPE


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


def decoders_of(scan: Found, types: dict[str, str | None]) -> dict[int, Decoder]:
    """
    Return a decoder for each channel of some topics.

    Parameters
    ----------
    scan : Found
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
    for channel in scan.channels.values():
        if channel.topic not in types:
            continue
        schema = scan.schemas.get(channel.schema_id)
        wanted = types[channel.topic]
        found = serving(schema)
        if schema is None and wanted:
            found = serving(own_schema(0, wanted))
        if schema is None and not wanted:
            continue
        name = schema.name if schema else wanted
        if found.schema is None:
            raise BagError(
                f"{scan.path}: the definition of {name} on {channel.topic} cannot be read, and "
                f"the type is not one that is known: it lacks {found.lacking or 'its text'}"
            )
        try:
            decode = factory.decoder_for(channel.message_encoding, found.schema)
        except Exception as error:
            # The parser of definitions has a dozen exceptions with no base but this.
            raise BagError(
                f"{scan.path}: the definition of {name} on {channel.topic} cannot be read: {error}"
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
