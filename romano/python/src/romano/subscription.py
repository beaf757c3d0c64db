"""What comes in on one subscription: a bounded queue that a program reads at its own pace."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from types import TracebackType

from .errors import NotConnected
from .mqttsn.topic import PredefinedTopic, ShortTopic, Topic, matches
from .mqttsn.types import Qos


@dataclass(frozen=True)
class Message:
    """One PUBLISH as it came."""

    topic: str | PredefinedTopic
    """A name; a PredefinedTopic if the message named its topic by such an id. Short names come as names."""
    data: bytes
    qos: Qos = Qos.AT_MOST_ONCE
    retain: bool = False
    """True when it was kept by the broker and is sent because of a new subscription."""
    dup: bool = False
    """True when the broker has sent it before. At QoS 2 every message comes once all the same."""

    @property
    def text(self) -> str:
        """The data as UTF-8; octets that are none are replaced."""
        return self.data.decode(errors="replace")


class Subscription:
    """Read it with ``async for``, ``get()`` or ``drain()``; end it with ``unsubscribe()``, ``close()`` or ``async
    with``.

    When ``room`` messages wait unread, further ones of QoS 0 are lost and counted in ``dropped``; those of QoS 1 and 2
    are not acknowledged, and the broker, which keeps them, sends them again until there is room.
    """

    def __init__(self, topic: Topic, room: int, leave: Callable[[Subscription], Awaitable[object] | None]) -> None:
        if room < 1:
            raise ValueError(f"a queue with room for {room} messages: must be at least 1")
        self.topic = topic
        self.granted = Qos.AT_MOST_ONCE
        """The QoS that the broker granted, the most at which messages come."""
        self.dropped = 0
        """Messages of QoS 0 that found no room."""
        self._room = room
        self._leave = leave
        self._messages: deque[Message] = deque()
        self._changed = asyncio.Event()
        self._end: Exception | None = None

    def __aiter__(self) -> Subscription:
        return self

    async def __anext__(self) -> Message:
        """Ends with StopAsyncIteration after unsubscribe() or disconnect(). Raises ConnectionLost when the connection
        is lost for good, and Rejected when the broker does not grant the subscription again after a new connection."""
        while not self._messages:
            if self._end is not None:
                raise self._end
            self._changed.clear()
            await self._changed.wait()
        return self._messages.popleft()

    async def get(self, timeout_s: float | None = None) -> Message:
        """The next message. Raises TimeoutError after ``timeout_s`` seconds, NotConnected when the subscription is
        over."""
        try:
            async with asyncio.timeout(timeout_s):
                return await self.__anext__()
        except StopAsyncIteration:
            raise NotConnected(f"the subscription to {self.topic!r} is over") from None

    def drain(self) -> list[Message]:
        """All that waits now, oldest first; perhaps nothing."""
        messages = list(self._messages)
        self._messages.clear()
        return messages

    async def unsubscribe(self) -> None:
        """Nothing comes any more; what waits can still be read. Returns when the broker knows it. Raises NotConnected,
        QueueFull."""
        told = self._leave(self)
        if told is not None:
            await told

    def close(self) -> None:
        """As unsubscribe(), without waiting for the broker."""
        self._leave(self)

    async def __aenter__(self) -> Subscription:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --- for the client

    def wants(self, topic: str | PredefinedTopic) -> bool:
        if isinstance(self.topic, str) and isinstance(topic, str):
            return matches(self.topic, topic)
        return topic == (self.topic.name if isinstance(self.topic, ShortTopic) else self.topic)

    @property
    def has_room(self) -> bool:
        return len(self._messages) < self._room

    def put(self, message: Message) -> None:
        if not self.has_room:
            self.dropped += 1
            return
        self._messages.append(message)
        self._changed.set()

    def end(self, why: Exception | None = None) -> None:
        self._end = self._end or why or StopAsyncIteration()
        self._changed.set()

    @property
    def is_over(self) -> bool:
        return self._end is not None
