"""A whole message to a datagram and back: MQTT-SN 1.2 section 5.2. Decoding is total: it never raises."""

from __future__ import annotations

from enum import Enum

from ..errors import TooLong
from .messages import BY_TYPE, Message
from .types import MAX_DATAGRAM


class Malformed(Enum):
    """Why a datagram is no message."""

    EMPTY = "empty"
    LENGTH = "length"
    RESERVED_TYPE = "reserved_type"
    SIZE = "size"


def encode(message: Message) -> bytes:
    """The datagram. Many clients and brokers read the short form of the length only, so it is used wherever it fits.

    Raises TooLong when UDP does not carry it.
    """
    body = message.body()
    if len(body) + 2 <= 0xFF:
        return bytes((len(body) + 2, message.TYPE)) + body
    size = len(body) + 4
    if size > MAX_DATAGRAM:
        raise TooLong(f"a message of {size} octets: UDP carries {MAX_DATAGRAM} at most")
    return b"\x01" + size.to_bytes(2, "big") + bytes((message.TYPE,)) + body


def decode(datagram: bytes) -> Message | Malformed:
    """The message, or the reason why it is none. The datagram's size is the truth, its length octets are a claim."""
    size = len(datagram)
    if size == 0:
        return Malformed.EMPTY
    is_long = datagram[0] == 0x01
    head = 4 if is_long else 2
    if size < head:
        return Malformed.LENGTH
    claimed = int.from_bytes(datagram[1:3], "big") if is_long else datagram[0]
    # Paho writes 01 00 FF in front of a message of 257 octets: it forgets to count the long form's two more.
    if claimed != size and not (is_long and claimed == 255 and size == 257):
        return Malformed.LENGTH
    kind = BY_TYPE.get(datagram[head - 1])
    if kind is None:
        return Malformed.RESERVED_TYPE
    message = kind.read(datagram[head:])
    return Malformed.SIZE if message is None else message
