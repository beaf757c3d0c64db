"""ROMANO for Python programs: MQTT-SN messages, robots and their commands, the results of sweeps.

    import asyncio
    import romano

    async def main() -> None:
        async with romano.Client("127.0.0.1") as client:
            await client.publish("robots/abcd1234/pose", "x=1 y=2", qos=1)

    asyncio.run(main())

Pure Python on asyncio; nothing else is needed. Times are seconds unless a name says another unit (``_ms``). Everything
that is raised is a RomanoError, or Python's own error for what it says. The package logs to the logger ``romano``.
"""

from . import message
from .client import Client
from .core.client import State
from .core.connection import Will
from .core.discovery import Gateway
from .core.timing import Limits, Timing
from .errors import (
    CannotSay,
    Congestion,
    ConnectionLost,
    InvalidTopic,
    InvalidTopicId,
    NoAnswer,
    NoSweep,
    NotConnected,
    NotSupported,
    QueueFull,
    Rejected,
    RomanoError,
    TooLong,
    UnknownRobot,
)
from .fleet import Change, Fleet
from .mqttsn.topic import PredefinedTopic, ShortTopic, Topic
from .mqttsn.types import Qos
from .node_entry import Robot
from .search import find_brokers
from .subscription import Message, Subscription
from .sweep import Sweep, Table

__all__ = [
    "CannotSay",
    "Change",
    "Client",
    "Congestion",
    "ConnectionLost",
    "Fleet",
    "Gateway",
    "InvalidTopic",
    "InvalidTopicId",
    "Limits",
    "Message",
    "NoAnswer",
    "NoSweep",
    "NotConnected",
    "NotSupported",
    "PredefinedTopic",
    "Qos",
    "QueueFull",
    "Rejected",
    "Robot",
    "RomanoError",
    "ShortTopic",
    "State",
    "Subscription",
    "Sweep",
    "Table",
    "Timing",
    "TooLong",
    "Topic",
    "UnknownRobot",
    "Will",
    "find_brokers",
    "message",
]
