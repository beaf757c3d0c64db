"""What a client core tells its owner, in the order in which it arose: datagrams to send, and events."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from ..mqttsn.topic import PredefinedTopic, Topic
from ..mqttsn.types import Qos


@dataclass(frozen=True)
class Send:
    """A datagram for the broker."""

    datagram: bytes


@dataclass(frozen=True)
class Connected:
    """CONNACK "accepted": operations may flow."""


@dataclass(frozen=True)
class Refused:
    """CONNACK with another return code. The end, unless one connects again."""

    return_code: int


@dataclass(frozen=True)
class Lost:
    """No answer after N_retry repetitions (6.13). The end, unless one connects again."""


@dataclass(frozen=True)
class Disconnected:
    """By one's own disconnect(), or by the broker, unasked (6.12). The end, unless one connects again."""

    by_broker: bool


@dataclass(frozen=True)
class Interrupted:
    """The connection is gone; the core connects again by itself. ``reason`` is for people."""

    reason: str


@dataclass(frozen=True)
class Asleep:
    """The broker knows that the client sleeps; or all that it kept for the sleeper has come (6.14)."""


@dataclass(frozen=True)
class Done:
    """The end of an operation."""

    operation: int
    topic_id: int = 0
    """Of a REGISTER, and of a SUBSCRIBE without wildcard."""
    granted: Qos = Qos.AT_MOST_ONCE
    """Of a SUBSCRIBE."""


@dataclass(frozen=True)
class Failed:
    """The broker refused the operation, or there is no room for the topic's id here (1)."""

    operation: int
    return_code: int


@dataclass(frozen=True)
class SubscriptionLost:
    """After a new connection the broker refused a subscription that it had granted before."""

    topic: Topic
    return_code: int


@dataclass(frozen=True)
class Received:
    """A PUBLISH for the application, which calls ``ClientCore.accept()`` if it has room for it.

    A message of QoS 1 or 2 that is not accepted is not acknowledged, and so the broker sends it again.
    """

    topic: str | PredefinedTopic
    data: bytes
    qos: Qos
    retain: bool
    dup: bool
    topic_id: int
    msg_id: int


Event: TypeAlias = (
    Connected | Refused | Lost | Disconnected | Interrupted | Asleep | Done | Failed | SubscriptionLost | Received
)
Action: TypeAlias = Send | Event
