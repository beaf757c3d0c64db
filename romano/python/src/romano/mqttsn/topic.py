"""Topics: names and filters after MQTT's rules (MQTT 3.1.1 section 4.7), and MQTT-SN's short and predefined ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from ..errors import InvalidTopic
from .types import TopicIdType, is_assignable


@dataclass(frozen=True)
class ShortTopic:
    """A name of exactly two octets that stands in a message by itself and needs no REGISTER (section 6.7)."""

    name: str

    def __post_init__(self) -> None:
        if not is_valid_name(self.name) or len(self.name.encode()) != 2:
            raise InvalidTopic(f"short topic {self.name!r}: must be a name of two octets")


@dataclass(frozen=True)
class PredefinedTopic:
    """A topic by the id that client and broker agreed on beforehand (``romano-broker --predefined``)."""

    id: int

    def __post_init__(self) -> None:
        if not 0 < self.id < 0xFFFF:
            raise InvalidTopic(f"predefined topic {self.id}: must be from 1 to 65534")


Topic: TypeAlias = str | ShortTopic | PredefinedTopic
"""How a program names a topic: a name or filter, or one of MQTT-SN's two other kinds."""


def _is_text(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return text != "" and "\0" not in text


def has_wildcard(filter: str) -> bool:
    return "+" in filter or "#" in filter


def is_valid_name(name: str) -> bool:
    """At least one character, no U+0000, no wildcard."""
    return _is_text(name) and not has_wildcard(name)


def is_valid_filter(filter: str) -> bool:
    """As a name, but ``+`` may fill a whole level and ``#`` the last one."""
    levels = filter.split("/")
    return (
        _is_text(filter)
        and all(level == "+" or "+" not in level for level in levels)
        and all("#" not in level for level in levels[:-1])
        and (levels[-1] == "#" or "#" not in levels[-1])
    )


def matches(filter: str, name: str) -> bool:
    """Whether a valid filter matches a valid name. ``a/#`` matches ``a`` too; names that begin with ``$`` are hidden
    from filters that begin with a wildcard."""
    if name.startswith("$") and filter[:1] in ("+", "#"):
        return False
    wanted, levels = filter.split("/"), name.split("/")
    for at, level in enumerate(wanted):
        if level == "#":
            return True
        if at == len(levels) or level not in ("+", levels[at]):
            return False
        if at + 1 == len(levels) and wanted[at + 1 :] == ["#"]:
            return True
    return len(wanted) == len(levels)


def check_name(topic: Topic) -> None:
    """Raises InvalidTopic when nothing can be published on ``topic``."""
    if isinstance(topic, str) and not is_valid_name(topic):
        raise InvalidTopic(f"topic {topic!r}: must be UTF-8 and not empty, without + and #")


def check_filter(topic: Topic) -> None:
    """Raises InvalidTopic when nobody can subscribe to ``topic``."""
    if isinstance(topic, str) and not is_valid_filter(topic):
        raise InvalidTopic(
            f"topic {topic!r}: must be UTF-8 and not empty, with + as a whole level and # as the last one"
        )


def type_of(topic: Topic) -> TopicIdType:
    if isinstance(topic, str):
        return TopicIdType.NORMAL
    return TopicIdType.SHORT if isinstance(topic, ShortTopic) else TopicIdType.PREDEFINED


def to_wire(topic: Topic) -> bytes:
    """As SUBSCRIBE has it: a name, or the two octets of an id."""
    if isinstance(topic, PredefinedTopic):
        return topic.id.to_bytes(2, "big")
    return (topic if isinstance(topic, str) else topic.name).encode()


def text_on_wire(octets: bytes) -> str | None:
    """A topic's name as it was received; None when it is none."""
    try:
        name = octets.decode()
    except UnicodeDecodeError:
        return None
    return name if is_valid_name(name) else None


def fixed_topic(type: TopicIdType, topic_id: int) -> str | PredefinedTopic | None:
    """The topic that PUBLISH names without a normal id; None when it is none."""
    if type is TopicIdType.PREDEFINED and is_assignable(topic_id):
        return PredefinedTopic(topic_id)
    if type is TopicIdType.SHORT:
        return text_on_wire(topic_id.to_bytes(2, "big"))
    return None
