"""What was asked for and is not answered yet, oldest first.

One exchange is open at a time (MQTT-SN 1.2: 6.5c, 6.6c, 6.9g), that of the front; the others wait behind it.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from ..mqttsn.topic import Topic
from ..mqttsn.types import MsgType


@dataclass
class Operation:
    request: MsgType
    """PUBLISH, SUBSCRIBE, UNSUBSCRIBE, REGISTER, WILLTOPICUPD or WILLMSGUPD."""
    topic: Topic = ""
    data: bytes = b""
    qos: int = 0
    retain: bool = False
    is_restoring: bool = False
    """A subscription that is made again; nobody waits for it."""

    id: int = 0
    sent: MsgType | None = None
    """What is out and not answered: the request, a REGISTER on the way to it, or PUBREL behind it."""
    msg_id: int = 0
    topic_id: int = 0
    registered_anew: bool = False
    """After PUBACK 2. A second one ends the operation (6.6e)."""

    @property
    def is_qos0(self) -> bool:
        return self.request is MsgType.PUBLISH and self.qos <= 0


class OperationQueue:
    def __init__(self) -> None:
        self._queue: deque[Operation] = deque()
        self._last_id = 0
        self.qos0 = 0
        """PUBLISHes of QoS 0 among them: while one waits, later ones wait behind it."""

    def __len__(self) -> int:
        return len(self._queue)

    def __iter__(self) -> Iterator[Operation]:
        return iter(self._queue)

    @property
    def front(self) -> Operation | None:
        return self._queue[0] if self._queue else None

    def next_id(self) -> int:
        self._last_id += 1
        return self._last_id

    def push(self, operation: Operation) -> int:
        operation.id = self.next_id()
        self.qos0 += operation.is_qos0
        self._queue.append(operation)
        return operation.id

    def push_front(self, operation: Operation) -> None:
        """Before all that was not begun yet."""
        operation.id = self.next_id()
        is_begun = self.front is not None and self.front.sent is not None
        self._queue.insert(1 if is_begun else 0, operation)

    def pop(self) -> Operation:
        operation = self._queue.popleft()
        self.qos0 -= operation.is_qos0
        return operation

    def cancel(self, id: int) -> bool:
        """False when it is unknown or on its way already."""
        for operation in self._queue:
            if operation.id == id and operation.sent is None:
                self._queue.remove(operation)
                self.qos0 -= operation.is_qos0
                return True
        return False
