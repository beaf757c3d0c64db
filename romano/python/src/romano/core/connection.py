"""CONNECT and the will's prompts: MQTT-SN 1.2 sections 6.2 and 6.3."""

from __future__ import annotations

from dataclasses import dataclass

from ..mqttsn.codec import encode
from ..mqttsn.messages import Connect, Message, Willmsg, Willtopic
from ..mqttsn.topic import check_name
from ..mqttsn.types import PROTOCOL_ID, MsgType, flags_octet


@dataclass(frozen=True)
class Will:
    """What the broker publishes when this client is lost. Raises InvalidTopic, TooLong; ValueError for a QoS that is
    none."""

    topic: str
    message: bytes
    qos: int = 0
    retain: bool = False

    def __post_init__(self) -> None:
        check_name(self.topic)
        if self.qos not in (0, 1, 2):
            raise ValueError(f"will with QoS {self.qos}: must be 0, 1 or 2")
        encode(Willtopic(0, self.topic.encode()))
        encode(Willmsg(self.message))


@dataclass(frozen=True)
class ConnectOptions:
    client_id: str
    clean_session: bool = True
    """The first connection erases what the broker kept of this client id. Connections after it always go on."""
    keep_alive_s: int = 60
    """Seconds, up to 65535; 0: nobody watches."""
    will: Will | None = None
    reconnect: bool = True
    """Connect again by itself once a connection is lost."""

    def __post_init__(self) -> None:
        if not 0 <= self.keep_alive_s <= 0xFFFF:
            raise ValueError(f"keep-alive of {self.keep_alive_s} s: must be from 0 to 65535")
        if len(self.client_id.encode()) > 255 or not self.client_id:
            raise ValueError(f"client id {self.client_id!r}: must have 1 to 255 octets, better not above 23")


def connect_step(step: MsgType, options: ConnectOptions) -> Message:
    """CONNECT, WILLTOPIC or WILLMSG."""
    will = options.will
    if step is MsgType.WILLTOPIC and will is not None:
        return Willtopic(flags_octet(qos=will.qos, retain=will.retain), will.topic.encode())
    if step is MsgType.WILLMSG and will is not None:
        return Willmsg(will.message)
    flags = flags_octet(will=will is not None, clean_session=options.clean_session)
    return Connect(flags, PROTOCOL_ID, options.keep_alive_s, options.client_id.encode())
