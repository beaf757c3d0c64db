"""ROMANO messages: the data of one MQTT-SN PUBLISH (paper, tables "ROMANO Message Formats", "Movement Control Types").

    octet 0: type    octet 1: size of the whole message, 2 to 255    octets 2…: by type

Decoding is total: any octets give a message or the reason why they are none.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import Enum, IntEnum
from struct import Struct
from struct import error as StructError
from typing import ClassVar, TypeAlias

from .errors import TooLong

MAX_OCTETS = 255
MAX_IDS = 31
"""In one ConnectedNodes; a message with fewer ends the list."""

_ID = re.compile(r"[0-9a-f]{8}", re.ASCII)


def is_romano_id(text: str) -> bool:
    """Eight lower-case hexadecimal digits: a robot's id, and the name of the topic that reaches it alone."""
    return _ID.fullmatch(text) is not None


class DataType(IntEnum):
    """Octet 0. Values from 0x13 on are the application's own; 0x0D to 0x10 are reserved."""

    NORMAL_DATA = 0x00
    MQTT_SUBSCRIBE = 0x01
    MQTT_PUBLISH_REQUEST = 0x02
    CONNECTED_NODES = 0x03
    REQUEST_CONNECTED_NODES = 0x04
    RSSI_REPORT = 0x05
    SENSOR_DATA = 0x06
    MOVEMENT_CONTROL = 0x07
    REMOTE_CONTROL = 0x08
    MQTT_UNSUBSCRIBE = 0x09
    HEARTBEAT = 0x0A
    CONNECTION_REQUEST = 0x0B
    CONNECTION_ACK = 0x0C
    UDP_SEND_REQ = 0x11
    UDP_SEND_GO = 0x12


FIRST_OF_APPLICATION = 0x13


class Malformed(Enum):
    """Why data is no ROMANO message."""

    HEADER = "fewer than two octets"
    LENGTH = "the length octet differs from the size"
    RESERVED_TYPE = "a reserved type"
    SIZE = "not a size of this type"
    VALUE = "a field holds what it may not"


# --- what is sensed


@dataclass(frozen=True)
class Gyroscope:
    x_mdeg_per_s: int
    y_mdeg_per_s: int
    z_mdeg_per_s: int


@dataclass(frozen=True)
class Proximity:
    mm: int


@dataclass(frozen=True)
class Location:
    x_mm: int
    y_mm: int
    heading_mdeg: int


@dataclass(frozen=True)
class Speed:
    mm_per_s: int
    mdeg_per_s: int


@dataclass(frozen=True)
class Battery:
    mv: int


@dataclass(frozen=True)
class LineReflectance:
    values: tuple[int, int, int, int, int]


@dataclass(frozen=True)
class OwnSensor:
    """The application's own, type 0x8000 to 0xFFFF."""

    type: int
    value: bytes


Reading: TypeAlias = Gyroscope | Proximity | Location | Speed | Battery | LineReflectance | OwnSensor

_SENSORS: tuple[tuple[type, Struct], ...] = (
    (Gyroscope, Struct(">iii")),
    (Proximity, Struct(">I")),
    (Location, Struct(">iii")),
    (Speed, Struct(">ii")),
    (Battery, Struct(">H")),
    (LineReflectance, Struct(">5H")),
)


# --- messages


@dataclass(frozen=True)
class NormalData:
    data: bytes


@dataclass(frozen=True)
class MqttSubscribe:
    """Tells the receivers to subscribe to the topic."""

    topic: str


@dataclass(frozen=True)
class MqttUnsubscribe:
    topic: str


@dataclass(frozen=True)
class MqttPublishRequest:
    """Tells the receivers to publish that kind of data to that topic."""

    topic: str
    kind: bytes


@dataclass(frozen=True)
class ConnectedNodes:
    ids: tuple[str, ...]


@dataclass(frozen=True)
class RequestConnectedNodes:
    asker: str


@dataclass(frozen=True)
class RssiReport:
    heard: str
    dbm: int


@dataclass(frozen=True)
class SensorData:
    reading: Reading


@dataclass(frozen=True)
class MovementControl:
    """One of the six standard movements, by ``MOVEMENTS``: mm, or millidegrees for the last two."""

    MOVEMENTS: ClassVar[tuple[str, ...]] = ("front", "back", "left", "right", "rotate-left", "rotate-right")
    movement: str
    amount: int


@dataclass(frozen=True)
class OwnMovement:
    """A movement of the application's own, type 0x8000 to 0xFFFF."""

    type: int
    arguments: bytes


@dataclass(frozen=True)
class RemoteControl:
    data: bytes


@dataclass(frozen=True)
class Heartbeat:
    sender: str


@dataclass(frozen=True)
class ConnectionRequest:
    sender: str


@dataclass(frozen=True)
class ConnectionAck:
    pass


@dataclass(frozen=True)
class UdpSendReq:
    pass


@dataclass(frozen=True)
class UdpSendGo:
    pass


@dataclass(frozen=True)
class ApplicationData:
    """Types 0x13 to 0xFF."""

    type: int
    data: bytes


RomanoMessage: TypeAlias = (
    NormalData | MqttSubscribe | MqttUnsubscribe | MqttPublishRequest | ConnectedNodes | RequestConnectedNodes
    | RssiReport | SensorData | MovementControl | OwnMovement | RemoteControl | Heartbeat | ConnectionRequest
    | ConnectionAck | UdpSendReq | UdpSendGo | ApplicationData
)  # fmt: skip


def decode(data: bytes) -> RomanoMessage | Malformed:
    """The message, or the reason why ``data`` is none."""
    if len(data) < 2:
        return Malformed.HEADER
    if data[1] != len(data):
        return Malformed.LENGTH
    type, body = data[0], data[2:]
    if type >= FIRST_OF_APPLICATION:
        return ApplicationData(type, body)
    if type not in DataType.__members__.values():
        return Malformed.RESERVED_TYPE
    if type in (DataType.NORMAL_DATA, DataType.REMOTE_CONTROL):
        return NormalData(body) if type == DataType.NORMAL_DATA else RemoteControl(body)
    if type in (DataType.MQTT_SUBSCRIBE, DataType.MQTT_UNSUBSCRIBE):
        return _decode_topic(type, body)
    if type == DataType.MQTT_PUBLISH_REQUEST:
        return _decode_publish_request(body)
    if type in (DataType.SENSOR_DATA, DataType.MOVEMENT_CONTROL):
        return _decode_typed(type, body)
    if type in (DataType.CONNECTION_ACK, DataType.UDP_SEND_REQ, DataType.UDP_SEND_GO):
        if body:
            return Malformed.SIZE
        if type == DataType.CONNECTION_ACK:
            return ConnectionAck()
        return UdpSendReq() if type == DataType.UDP_SEND_REQ else UdpSendGo()
    return _decode_ids(type, body)


def _decode_topic(type: int, body: bytes) -> RomanoMessage | Malformed:
    if not body:
        return Malformed.SIZE
    topic = _text(body)
    if topic is None:
        return Malformed.VALUE
    return MqttSubscribe(topic) if type == DataType.MQTT_SUBSCRIBE else MqttUnsubscribe(topic)


def _decode_publish_request(body: bytes) -> RomanoMessage | Malformed:
    if len(body) < 2:
        return Malformed.SIZE
    size = body[0] - 2  # octet 2 is the index of the topic's last octet
    topic = _text(body[1 : 1 + size]) if 0 < size < len(body) else None
    return Malformed.VALUE if topic is None else MqttPublishRequest(topic, body[1 + size :])


def _decode_typed(type: int, body: bytes) -> RomanoMessage | Malformed:
    if len(body) < 2:
        return Malformed.SIZE
    inner, rest = int.from_bytes(body[:2], "big"), body[2:]
    is_sensor = type == DataType.SENSOR_DATA
    if inner >= 0x8000:
        return SensorData(OwnSensor(inner, rest)) if is_sensor else OwnMovement(inner, rest)
    if inner >= 6:
        return Malformed.VALUE
    if not is_sensor:
        if len(rest) != 4:
            return Malformed.SIZE
        return MovementControl(MovementControl.MOVEMENTS[inner], int.from_bytes(rest, "big"))
    kind, layout = _SENSORS[inner]
    if len(rest) != layout.size:
        return Malformed.SIZE
    values = layout.unpack(rest)
    return SensorData(kind(values) if kind is LineReflectance else kind(*values))


def _decode_ids(type: int, body: bytes) -> RomanoMessage | Malformed:
    is_list = type == DataType.CONNECTED_NODES
    size = len(body) - (type == DataType.RSSI_REPORT)
    if size % 8 != 0 or (size != 8 and not is_list):
        return Malformed.SIZE
    ids = tuple(body[at : at + 8].decode("latin-1") for at in range(0, size, 8))
    if not all(map(is_romano_id, ids)):
        return Malformed.VALUE
    if is_list:
        return ConnectedNodes(ids)
    if type == DataType.RSSI_REPORT:
        return RssiReport(ids[0], int.from_bytes(body[8:], "big", signed=True))
    if type == DataType.REQUEST_CONNECTED_NODES:
        return RequestConnectedNodes(ids[0])
    return Heartbeat(ids[0]) if type == DataType.HEARTBEAT else ConnectionRequest(ids[0])


def _text(octets: bytes) -> str | None:
    try:
        return octets.decode()
    except UnicodeDecodeError:
        return None


def encode(message: RomanoMessage) -> bytes:
    """The octets. Raises TooLong above 255 of them; ValueError for what would not decode again."""
    type, body = _encode_body(message)
    size = 2 + len(body)
    if size > MAX_OCTETS:
        raise TooLong(f"a ROMANO message of {size} octets: {MAX_OCTETS} at most")
    data = bytes((type, size)) + body
    if decode(data) != message:
        raise ValueError(f"{message}: no ROMANO message can say this")
    return data


def _encode_body(message: RomanoMessage) -> tuple[int, bytes]:
    if isinstance(message, NormalData):
        return DataType.NORMAL_DATA, message.data
    if isinstance(message, RemoteControl):
        return DataType.REMOTE_CONTROL, message.data
    if isinstance(message, MqttSubscribe):
        return DataType.MQTT_SUBSCRIBE, message.topic.encode()
    if isinstance(message, MqttUnsubscribe):
        return DataType.MQTT_UNSUBSCRIBE, message.topic.encode()
    if isinstance(message, MqttPublishRequest):
        topic = message.topic.encode()
        if len(topic) > MAX_OCTETS:
            raise TooLong(f"a topic of {len(topic)} octets in a ROMANO message of {MAX_OCTETS}")
        return DataType.MQTT_PUBLISH_REQUEST, bytes(((len(topic) + 2) & 0xFF,)) + topic + message.kind
    if isinstance(message, ConnectedNodes):
        return DataType.CONNECTED_NODES, "".join(message.ids).encode()
    if isinstance(message, RequestConnectedNodes):
        return DataType.REQUEST_CONNECTED_NODES, message.asker.encode()
    if isinstance(message, RssiReport):
        return DataType.RSSI_REPORT, message.heard.encode() + (message.dbm & 0xFF).to_bytes(1, "big")
    if isinstance(message, SensorData):
        return DataType.SENSOR_DATA, _encode_reading(message.reading)
    if isinstance(message, MovementControl):
        type = MovementControl.MOVEMENTS.index(message.movement)
        return DataType.MOVEMENT_CONTROL, type.to_bytes(2, "big") + _u32(message.amount)
    if isinstance(message, OwnMovement):
        return DataType.MOVEMENT_CONTROL, (message.type & 0xFFFF).to_bytes(2, "big") + message.arguments
    if isinstance(message, Heartbeat):
        return DataType.HEARTBEAT, message.sender.encode()
    if isinstance(message, ConnectionRequest):
        return DataType.CONNECTION_REQUEST, message.sender.encode()
    if isinstance(message, ConnectionAck):
        return DataType.CONNECTION_ACK, b""
    if isinstance(message, UdpSendReq):
        return DataType.UDP_SEND_REQ, b""
    if isinstance(message, UdpSendGo):
        return DataType.UDP_SEND_GO, b""
    return message.type & 0xFF, message.data


def _encode_reading(reading: Reading) -> bytes:
    if isinstance(reading, OwnSensor):
        return (reading.type & 0xFFFF).to_bytes(2, "big") + reading.value
    for type, (kind, layout) in enumerate(_SENSORS):
        if isinstance(reading, kind):
            values = reading.values if isinstance(reading, LineReflectance) else vars(reading).values()
            try:
                return type.to_bytes(2, "big") + layout.pack(*values)
            except StructError as error:
                raise ValueError(f"{reading}: {error}") from None
    raise ValueError(f"{reading!r} is no reading of a sensor")


def _u32(value: int) -> bytes:
    if not 0 <= value <= 0xFFFFFFFF:
        raise ValueError(f"amount {value}: must be from 0 to 4294967295")
    return value.to_bytes(4, "big")
