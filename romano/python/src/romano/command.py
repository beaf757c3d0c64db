"""What an operator wants of a robot, as the octets that this robot understands: the paper's messages, or the ASCII of
the authors' own firmware ("legacy")."""

from __future__ import annotations

from .errors import CannotSay
from .message import MovementControl, MqttPublishRequest, MqttSubscribe, MqttUnsubscribe, encode
from .mqttsn.topic import check_filter, check_name

BINARY = "binary"
LEGACY = "legacy"

_LEGACY_TOPIC_OCTETS = 15
_LEGACY_DATA_OCTETS = 31


def move_message(
    form: str,
    movement: str,
    *,
    mm: float | None = None,
    deg: float | None = None,
    ms: float | None = None,
    speed_percent: int = 30,
) -> bytes:
    """See Fleet.move(). Raises CannotSay."""
    movements = MovementControl.MOVEMENTS
    if movement not in movements:
        raise CannotSay(f"movement {movement!r}: must be one of {', '.join(movements)}")
    unit, amount = _amount(form, movement, mm, deg, ms)
    if form == LEGACY:
        return _legacy_move(movement, amount, speed_percent)
    number = round(amount * 1000 if unit == "deg" else amount)
    if not 0 <= number <= 0xFFFFFFFF:
        raise CannotSay(f"{unit}={amount:g}: must be from 0 to {0xFFFFFFFF // (1000 if unit == 'deg' else 1)}")
    return encode(MovementControl(movement, number))


def subscribe_message(form: str, topic: str) -> bytes:
    check_filter(topic)
    if form == BINARY:
        return encode(MqttSubscribe(topic))
    return _legacy("1" + _legacy_topic(topic))


def unsubscribe_message(form: str, topic: str) -> bytes:
    check_filter(topic)
    if form == LEGACY:
        raise CannotSay("the authors' firmware cannot unsubscribe")
    return encode(MqttUnsubscribe(topic))


def request_message(form: str, topic: str, kind: str) -> bytes:
    """ "Publish that kind of data on that topic." """
    check_name(topic)
    if form == BINARY:
        return encode(MqttPublishRequest(topic, kind.encode()))
    # The data is published as it stands: "0" makes it normal data for its readers.
    return _legacy("2" + chr(ord("0") + len(_legacy_topic(topic).encode())) + topic + "0" + kind)


def _amount(form: str, movement: str, mm: float | None, deg: float | None, ms: float | None) -> tuple[str, float]:
    given = {unit: amount for unit, amount in (("mm", mm), ("deg", deg), ("ms", ms)) if amount is not None}
    if movement.startswith("rotate"):
        wanted = "deg"
    else:
        wanted = "ms" if form == LEGACY else "mm"
    if list(given) != [wanted]:
        why = "this robot has the authors' firmware, which drives by time: " if wanted == "ms" else ""
        raise CannotSay(f"{movement}: {why}give {wanted}=, and nothing else")
    return wanted, given[wanted]


def _legacy_move(movement: str, amount: float, speed_percent: int) -> bytes:
    """`7`, then hexadecimal: type (2 digits), time (4), degrees (4, signed), speed (2, signed)."""
    if not 1 <= speed_percent <= 100:
        raise CannotSay(f"speed_percent={speed_percent}: must be from 1 to 100")
    if movement in ("left", "right"):
        raise CannotSay("the authors' firmware cannot drive sideways: rotate, then drive")
    turns = movement.startswith("rotate")
    number, most = round(amount), 32_767 if turns else 65_535
    if not 0 <= number <= most:
        raise CannotSay(f"{'deg' if turns else 'ms'}={amount:g}: must be from 0 to {most}")
    if turns:
        time_ms, degrees, speed = 0, number if movement == "rotate-left" else -number, speed_percent
    else:
        time_ms, degrees, speed = number, 0, speed_percent if movement == "front" else -speed_percent
    return _legacy(f"7{2 if turns else 4:02x}{time_ms:04x}{degrees & 0xFFFF:04x}{speed & 0xFF:02x}")


def _legacy_topic(topic: str) -> str:
    if not 1 <= len(topic.encode()) <= _LEGACY_TOPIC_OCTETS:
        raise CannotSay(f"topic {topic!r}: the authors' firmware takes 1 to {_LEGACY_TOPIC_OCTETS} octets")
    return topic


def _legacy(text: str) -> bytes:
    data = text.encode()
    if len(data) > _LEGACY_DATA_OCTETS or b"\0" in data:
        raise CannotSay(f"the authors' firmware takes at most {_LEGACY_DATA_OCTETS} octets without NUL in a message")
    return data
