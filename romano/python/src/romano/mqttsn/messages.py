"""The messages of MQTT-SN 1.2, section 5.4: what stands behind length and type.

Each class is a line of the specification's table: a head of fixed size, and at most one field of any size behind it.
"""

from __future__ import annotations

from dataclasses import dataclass
from struct import Struct
from typing import ClassVar, Self

from .types import MsgType


@dataclass(frozen=True)
class Message:
    """The base of all messages."""

    TYPE: ClassVar[MsgType]
    HEAD: ClassVar[Struct] = Struct("")
    REST: ClassVar[int | None] = None
    """The least size of the last field; None: there is no such field."""

    def body(self) -> bytes:
        fields = tuple(vars(self).values())
        if self.REST is None:
            return self.HEAD.pack(*fields)
        return self.HEAD.pack(*fields[:-1]) + bytes(fields[-1])

    @classmethod
    def read(cls, body: bytes) -> Self | None:
        """None when a message of this type cannot have that size."""
        head, rest = body[: cls.HEAD.size], body[cls.HEAD.size :]
        if len(head) < cls.HEAD.size or len(rest) < (cls.REST or 0):
            return None
        fields = cls.HEAD.unpack(head)
        if cls.REST is not None:
            fields += (rest,)
        elif rest:
            return None
        return cls(*fields)


# --- discovery, section 6.1


@dataclass(frozen=True)
class Advertise(Message):
    TYPE = MsgType.ADVERTISE
    HEAD = Struct(">BH")
    gateway_id: int
    duration_s: int


@dataclass(frozen=True)
class Searchgw(Message):
    TYPE = MsgType.SEARCHGW
    HEAD = Struct(">B")
    radius: int


@dataclass(frozen=True)
class Gwinfo(Message):
    """``address`` is empty when the gateway itself sends it."""

    TYPE = MsgType.GWINFO
    HEAD = Struct(">B")
    REST = 0
    gateway_id: int
    address: bytes


# --- connection, sections 6.2 to 6.4


@dataclass(frozen=True)
class Connect(Message):
    TYPE = MsgType.CONNECT
    HEAD = Struct(">BBH")
    REST = 0
    flags: int
    protocol_id: int
    keep_alive_s: int
    client_id: bytes


@dataclass(frozen=True)
class CodeOnly(Message):
    HEAD = Struct(">B")
    return_code: int


@dataclass(frozen=True)
class Connack(CodeOnly):
    TYPE = MsgType.CONNACK


@dataclass(frozen=True)
class Willtopicresp(CodeOnly):
    TYPE = MsgType.WILLTOPICRESP


@dataclass(frozen=True)
class Willmsgresp(CodeOnly):
    TYPE = MsgType.WILLMSGRESP


@dataclass(frozen=True)
class Willtopicreq(Message):
    TYPE = MsgType.WILLTOPICREQ


@dataclass(frozen=True)
class Willmsgreq(Message):
    TYPE = MsgType.WILLMSGREQ


@dataclass(frozen=True)
class WillTopicFields(Message):
    """An empty topic deletes the will; then there is no flags octet either (sections 5.4.7, 5.4.22)."""

    HEAD = Struct(">B")
    REST = 0
    flags: int
    topic: bytes

    def body(self) -> bytes:
        return super().body() if self.topic else b""

    @classmethod
    def read(cls, body: bytes) -> Self | None:
        return cls(body[0] if body else 0, body[1:])


@dataclass(frozen=True)
class Willtopic(WillTopicFields):
    TYPE = MsgType.WILLTOPIC


@dataclass(frozen=True)
class Willtopicupd(WillTopicFields):
    TYPE = MsgType.WILLTOPICUPD


@dataclass(frozen=True)
class Willmsg(Message):
    TYPE = MsgType.WILLMSG
    REST = 0
    message: bytes


@dataclass(frozen=True)
class Willmsgupd(Message):
    TYPE = MsgType.WILLMSGUPD
    REST = 0
    message: bytes


@dataclass(frozen=True)
class Disconnect(Message):
    """``duration_s`` is for a client that goes to sleep; 0: the field is not sent (section 5.4.21)."""

    TYPE = MsgType.DISCONNECT
    duration_s: int = 0

    def body(self) -> bytes:
        return self.duration_s.to_bytes(2, "big") if self.duration_s else b""

    @classmethod
    def read(cls, body: bytes) -> Self | None:
        return cls(int.from_bytes(body, "big")) if len(body) in (0, 2) else None


# --- keep-alive and sleep, sections 6.11 and 6.14


@dataclass(frozen=True)
class Pingreq(Message):
    TYPE = MsgType.PINGREQ
    REST = 0
    client_id: bytes = b""


@dataclass(frozen=True)
class Pingresp(Message):
    TYPE = MsgType.PINGRESP


# --- topics and messages, sections 6.5 to 6.10


@dataclass(frozen=True)
class Register(Message):
    TYPE = MsgType.REGISTER
    HEAD = Struct(">HH")
    REST = 0
    topic_id: int
    msg_id: int
    topic_name: bytes


@dataclass(frozen=True)
class TopicAck(Message):
    HEAD = Struct(">HHB")
    topic_id: int
    msg_id: int
    return_code: int


@dataclass(frozen=True)
class Regack(TopicAck):
    TYPE = MsgType.REGACK


@dataclass(frozen=True)
class Puback(TopicAck):
    TYPE = MsgType.PUBACK


@dataclass(frozen=True)
class Publish(Message):
    """``topic_id`` holds the two octets of a short name, if the flags say that it is one."""

    TYPE = MsgType.PUBLISH
    HEAD = Struct(">BHH")
    REST = 0
    flags: int
    topic_id: int
    msg_id: int
    data: bytes


@dataclass(frozen=True)
class MsgIdOnly(Message):
    HEAD = Struct(">H")
    msg_id: int


@dataclass(frozen=True)
class Pubrec(MsgIdOnly):
    TYPE = MsgType.PUBREC


@dataclass(frozen=True)
class Pubrel(MsgIdOnly):
    TYPE = MsgType.PUBREL


@dataclass(frozen=True)
class Pubcomp(MsgIdOnly):
    TYPE = MsgType.PUBCOMP


@dataclass(frozen=True)
class Unsuback(MsgIdOnly):
    TYPE = MsgType.UNSUBACK


@dataclass(frozen=True)
class Subscribe(Message):
    """``topic``: a name or filter, or the two octets of an id, as the flags say."""

    TYPE = MsgType.SUBSCRIBE
    HEAD = Struct(">BH")
    REST = 1
    flags: int
    msg_id: int
    topic: bytes


@dataclass(frozen=True)
class Unsubscribe(Message):
    TYPE = MsgType.UNSUBSCRIBE
    HEAD = Struct(">BH")
    REST = 1
    flags: int
    msg_id: int
    topic: bytes


@dataclass(frozen=True)
class Suback(Message):
    """``topic_id`` is 0 for a filter with wildcards."""

    TYPE = MsgType.SUBACK
    HEAD = Struct(">BHHB")
    flags: int
    topic_id: int
    msg_id: int
    return_code: int


def _leaves(base: type[Message]) -> list[type[Message]]:
    below = base.__subclasses__()
    return [base] if not below else [leaf for child in below for leaf in _leaves(child)]


BY_TYPE: dict[int, type[Message]] = {leaf.TYPE: leaf for leaf in _leaves(Message)}
