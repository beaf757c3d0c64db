"""What the brokers tell of a robot: one retained message on ``$ROMANO/nodes/<id>`` each.

    form=binary state=connected heartbeat_unix_ms=1790000000123 home=r1 client=abcd1234
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import datetime, timezone

from .message import is_romano_id

ENTRIES = "$ROMANO/nodes/+"
_PREFIX = ENTRIES[:-1]
_ENTRY = re.compile(
    r"form=(binary|legacy) state=(connected|silent|away) heartbeat_unix_ms=([0-9]{1,20}) home=([^ ]*) client=(.*)",
    re.ASCII | re.DOTALL,
)


@dataclass(frozen=True)
class Robot:
    """A robot as the brokers know it."""

    id: str
    """Eight hexadecimal digits; also the topic that reaches it alone."""
    state: str
    """"connected"; "silent": its heartbeats are missing, messages to it wait; "away": not connected, its session is
    kept."""
    home: str
    """The name of the broker that serves it."""
    form: str
    """"binary", or "legacy" for the authors' firmware."""
    client: str
    """The MQTT-SN client id of its session."""
    heartbeat_unix_ms: int
    """The last heartbeat, to ten seconds, in ms since 1970 (UTC); 0: it sends none."""

    @property
    def heartbeat(self) -> datetime | None:
        """The last heartbeat in UTC; None if it sends none."""
        if self.heartbeat_unix_ms == 0:
            return None
        try:
            return datetime.fromtimestamp(self.heartbeat_unix_ms / 1000, timezone.utc)
        except (OverflowError, ValueError, OSError):
            return None


def robot_of(topic: str) -> str | None:
    """The id in an entry's topic."""
    id = topic.removeprefix(_PREFIX)
    return id if topic.startswith(_PREFIX) and is_romano_id(id) else None


def parse_entry(id: str, data: bytes) -> Robot | None:
    """None when it is no entry."""
    try:
        found = _ENTRY.fullmatch(data.decode())
    except UnicodeDecodeError:
        return None
    if found is None:
        return None
    form, state, heartbeat, home, client = found.groups()
    return Robot(id, state, home, form, client, int(heartbeat))
