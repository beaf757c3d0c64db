"""The small numbers of MQTT-SN 1.2: message types, QoS, return codes, the flags octet (sections 5.2.2, 5.3)."""

from __future__ import annotations

from enum import IntEnum


class MsgType(IntEnum):
    """Section 5.2.2. Values that are not listed are reserved."""

    ADVERTISE = 0x00
    SEARCHGW = 0x01
    GWINFO = 0x02
    CONNECT = 0x04
    CONNACK = 0x05
    WILLTOPICREQ = 0x06
    WILLTOPIC = 0x07
    WILLMSGREQ = 0x08
    WILLMSG = 0x09
    REGISTER = 0x0A
    REGACK = 0x0B
    PUBLISH = 0x0C
    PUBACK = 0x0D
    PUBCOMP = 0x0E
    PUBREC = 0x0F
    PUBREL = 0x10
    SUBSCRIBE = 0x12
    SUBACK = 0x13
    UNSUBSCRIBE = 0x14
    UNSUBACK = 0x15
    PINGREQ = 0x16
    PINGRESP = 0x17
    DISCONNECT = 0x18
    WILLTOPICUPD = 0x1A
    WILLTOPICRESP = 0x1B
    WILLMSGUPD = 0x1C
    WILLMSGRESP = 0x1D


class Qos(IntEnum):
    """How sure a message is to arrive. Plain integers are as good in every call of this package."""

    WITHOUT_CONNECTION = -1
    """Sent and forgotten; needs no connection, but a short or predefined topic."""
    AT_MOST_ONCE = 0
    AT_LEAST_ONCE = 1
    EXACTLY_ONCE = 2


class TopicIdType(IntEnum):
    """How a topic is named in a message; section 5.3.4."""

    NORMAL = 0
    PREDEFINED = 1
    SHORT = 2
    RESERVED = 3


class ReturnCode(IntEnum):
    """Section 5.3.10. Any other value on the wire is a rejection without a name."""

    ACCEPTED = 0
    CONGESTION = 1
    INVALID_TOPIC_ID = 2
    NOT_SUPPORTED = 3


DUP = 0x80
RETAIN = 0x10
WILL = 0x08
CLEAN_SESSION = 0x04


def flags_octet(
    *,
    dup: bool = False,
    qos: int = 0,
    retain: bool = False,
    will: bool = False,
    clean_session: bool = False,
    topic_type: TopicIdType = TopicIdType.NORMAL,
) -> int:
    """The flags octet; QoS -1 is 0b11 in it. What a message does not use stays 0."""
    return (
        (DUP if dup else 0)
        | (qos & 3) << 5
        | (RETAIN if retain else 0)
        | (WILL if will else 0)
        | (CLEAN_SESSION if clean_session else 0)
        | topic_type
    )


def qos_in(flags: int) -> Qos:
    bits = flags >> 5 & 3
    return Qos.WITHOUT_CONNECTION if bits == 3 else Qos(bits)


def topic_type_in(flags: int) -> TopicIdType:
    return TopicIdType(flags & 3)


def is_assignable(topic_id: int) -> bool:
    """Two ids are reserved: never assigned, never accepted in a PUBLISH (section 5.3.11)."""
    return topic_id not in (0x0000, 0xFFFF)


PROTOCOL_ID = 0x01
MAX_DATAGRAM = 65507
"""Octets that UDP over IPv4 carries."""
