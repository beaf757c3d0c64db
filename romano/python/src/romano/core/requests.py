"""The client's requests, one after the other: MQTT-SN 1.2 sections 6.4, 6.5, 6.6, 6.8 and 6.9.

Says what to send and which operation ended; whether there is a connection is the owner's matter (client.py).
"""

from __future__ import annotations

import random

from ..errors import QueueFull
from ..mqttsn import messages
from ..mqttsn.codec import encode
from ..mqttsn.messages import Message, Puback, Regack, Suback
from ..mqttsn.topic import PredefinedTopic, Topic, has_wildcard, to_wire, type_of
from ..mqttsn.types import MsgType, Qos, ReturnCode, flags_octet, is_assignable, qos_in
from .events import Action, Done, Failed, Send, SubscriptionLost
from .operations import Operation, OperationQueue
from .timers import NEVER, RetryTimer
from .timing import Limits, Timing
from .topic_table import TopicTable


class Requests:
    def __init__(self, timing: Timing, limits: Limits, topics: TopicTable, out: list[Action], seed: int | None) -> None:
        self._timing = timing
        self._limits = limits
        self._topics = topics
        self._out = out
        self._queue = OperationQueue()
        self._timer = RetryTimer()
        # A kept session may remember message ids of this client's earlier life; a random start makes it unlikely to
        # meet them.
        self._last_msg_id = random.Random(seed).randrange(0xFFFF)
        self._paused_until = -NEVER
        self._subscriptions: dict[Topic, int] = {}

    # --- from the application

    def push(self, operation: Operation) -> int:
        """The operation's id. Raises QueueFull; TooLong when no datagram holds it."""
        if len(self._queue) >= self._limits.operations:
            raise QueueFull(f"{len(self._queue)} requests wait for the broker already")
        if operation.request is MsgType.SUBSCRIBE and len(self._subscriptions) >= self._limits.subscriptions:
            raise QueueFull(f"there are {len(self._subscriptions)} subscriptions already")
        encode(self._message(operation, operation.request, dup=False))
        if operation.request is MsgType.PUBLISH:
            encode(self._message(operation, MsgType.REGISTER, dup=False))  # it may come to that
        return self._queue.push(operation)

    def cancel(self, operation: int) -> bool:
        return self._queue.cancel(operation)

    def publish_at_once(self, topic: Topic, data: bytes, qos: int, retain: bool) -> int | None:
        """Below QoS 1, beside whatever exchange is open (6.6c): the operation's id. None when the topic has no id yet,
        or when a message of QoS 0 waits for one: this one must stay behind it."""
        topic_id = self._topic_id(topic)
        if topic_id is None or (self._queue.qos0 and qos == 0):
            return None
        operation = Operation(MsgType.PUBLISH, topic, data, qos, retain, topic_id=topic_id)
        self._out.append(Send(encode(self._message(operation, MsgType.PUBLISH, dup=False))))
        operation.id = self._queue.next_id()
        self._out.append(Done(operation.id))
        return operation.id

    def paused_for(self, now: float) -> float:
        """Seconds, 0 when there is no pause."""
        return max(0.0, self._paused_until - now)

    # --- from the connection

    def carry_on(self, now: float) -> None:
        """Begins the operations in their turn, as far as no answer is awaited."""
        while not self._timer.is_running and (front := self._queue.front) is not None:
            if self.paused_for(now) and front.request is not MsgType.UNSUBSCRIBE:
                self._fail(ReturnCode.CONGESTION)
            else:
                self._begin(front, now)

    def resume(self, now: float, is_clean: bool) -> None:
        """There is a new connection. What was on its way is repeated where the session knows its message id, and else
        begun anew; PUBREL is answered by any broker (6.6d). Subscriptions are made again: nothing tells a client
        whether the broker has kept them."""
        self._paused_until = -NEVER
        front = self._queue.front
        if front is not None and front.sent is not None:
            if is_clean and front.sent is not MsgType.PUBREL:
                self._postpone(front)
            else:
                self._send_again(now, front)
        waiting = {operation.topic for operation in self._queue if operation.is_restoring}
        for topic, qos in reversed(self._subscriptions.items()):
            if topic not in waiting:
                self._queue.push_front(Operation(MsgType.SUBSCRIBE, topic, qos=qos, is_restoring=True))

    def stop(self) -> None:
        """There is no connection any more. Operations are kept."""
        self._timer.stop()

    def on_tick(self, now: float) -> bool:
        """False when the broker has not answered after all repetitions."""
        if now < self._timer.deadline or self._queue.front is None:
            return True
        if not self._timer.repeat(now, self._timing.t_retry):
            return False
        self._send(self._queue.front, dup=True)
        return True

    @property
    def deadline(self) -> float:
        return self._timer.deadline

    def on_answer(self, now: float, message: Message) -> bool:
        """False when nobody waits for it."""
        front = self._queue.front
        if front is None or not self._timer.is_running or not self._is_answer_to(front, message):
            return self._on_puback_of_qos0(now, message)
        code = getattr(message, "return_code", ReturnCode.ACCEPTED)
        if isinstance(message, Puback):
            if code == ReturnCode.ACCEPTED and front.qos == Qos.EXACTLY_ONCE:
                return False  # never belongs to QoS 2 (6.6a)
            if code == ReturnCode.INVALID_TOPIC_ID and isinstance(front.topic, str) and not front.registered_anew:
                self._topics.forget(front.topic_id)
                front.registered_anew = True
                self._postpone(front)
                return True
        if code == ReturnCode.ACCEPTED:
            self._on_acceptance(now, front, message)
        else:
            if code == ReturnCode.CONGESTION:
                self._paused_until = now + self._timing.t_wait
            self._fail(code)
        return True

    # --- the exchanges

    def _begin(self, front: Operation, now: float) -> None:
        if front.request is MsgType.PUBLISH:
            topic_id = self._topic_id(front.topic)
            if topic_id is None:
                return self._begin_register(front, now)
            front.topic_id = topic_id
            if front.is_qos0:
                front.msg_id = 0  # that of the REGISTER before it
                self._send(front, dup=False, sent=MsgType.PUBLISH)
                return self._finish(Done(front.id))
        elif front.request is MsgType.REGISTER:
            return self._begin_register(front, now)
        has_msg_id = front.request not in (MsgType.WILLTOPICUPD, MsgType.WILLMSGUPD)
        self._send_first(now, front, front.request, self._next_msg_id() if has_msg_id else 0)

    def _begin_register(self, front: Operation, now: float) -> None:
        if len(self._topics) >= self._limits.topics:
            return self._fail(ReturnCode.CONGESTION)  # an id that cannot be kept is of no use
        self._send_first(now, front, MsgType.REGISTER, self._next_msg_id())

    def _send_first(self, now: float, front: Operation, type: MsgType, msg_id: int) -> None:
        front.msg_id = msg_id
        self._timer.start(now, self._timing.t_retry, self._timing.n_retry)
        self._send(front, dup=False, sent=type)

    def _send_again(self, now: float, front: Operation) -> None:
        self._timer.start(now, self._timing.t_retry, self._timing.n_retry)
        self._send(front, dup=True)

    def _send(self, front: Operation, *, dup: bool, sent: MsgType | None = None) -> None:
        front.sent = sent or front.sent
        assert front.sent is not None
        self._out.append(Send(encode(self._message(front, front.sent, dup))))

    def _message(self, operation: Operation, type: MsgType, dup: bool) -> Message:
        topic_type = type_of(operation.topic)
        if type is MsgType.REGISTER:
            return messages.Register(0, operation.msg_id, to_wire(operation.topic))
        if type is MsgType.PUBREL:
            return messages.Pubrel(operation.msg_id)
        if type is MsgType.WILLMSGUPD:
            return messages.Willmsgupd(operation.data)
        if type is MsgType.UNSUBSCRIBE:
            return messages.Unsubscribe(flags_octet(topic_type=topic_type), operation.msg_id, to_wire(operation.topic))
        flags = flags_octet(dup=dup, qos=operation.qos, retain=operation.retain, topic_type=topic_type)
        if type is MsgType.SUBSCRIBE:
            return messages.Subscribe(flags, operation.msg_id, to_wire(operation.topic))
        if type is MsgType.WILLTOPICUPD:
            return messages.Willtopicupd(flags, to_wire(operation.topic))
        return messages.Publish(flags, operation.topic_id, operation.msg_id, operation.data)

    def _topic_id(self, topic: Topic) -> int | None:
        """What stands in a PUBLISH for ``topic``; None when the name has no id yet."""
        if isinstance(topic, PredefinedTopic):
            return topic.id
        return self._topics.id_of(topic) if isinstance(topic, str) else int.from_bytes(to_wire(topic), "big")

    def _is_answer_to(self, front: Operation, message: Message) -> bool:
        if front.msg_id != getattr(message, "msg_id", 0):
            return False
        if message.TYPE is MsgType.PUBCOMP:
            return front.sent is MsgType.PUBREL
        if message.TYPE is MsgType.PUBREC:  # asks for PUBREL however often it comes
            return front.qos == Qos.EXACTLY_ONCE and front.sent in (MsgType.PUBLISH, MsgType.PUBREL)
        # The numbers of the others are those of their requests plus one (5.2.2).
        return front.sent is not None and message.TYPE == front.sent + 1

    def _on_acceptance(self, now: float, front: Operation, message: Message) -> None:
        if message.TYPE is MsgType.PUBREC:
            return self._send_first(now, front, MsgType.PUBREL, front.msg_id)
        topic_id = message.topic_id if isinstance(message, (Regack, Suback)) else 0
        if isinstance(message, Regack) and not is_assignable(topic_id):
            return self._fail(ReturnCode.INVALID_TOPIC_ID)
        if isinstance(front.topic, str) and not has_wildcard(front.topic) and is_assignable(topic_id):
            if not self._topics.put(topic_id, front.topic):
                return self._fail(ReturnCode.CONGESTION)
        if isinstance(message, Regack) and front.request is MsgType.PUBLISH:
            return self._postpone(front)  # its own turn comes at once
        if isinstance(message, Suback):
            self._subscriptions[front.topic] = front.qos
            return self._finish(Done(front.id, topic_id, qos_in(message.flags)))
        if front.request is MsgType.UNSUBSCRIBE:
            self._subscriptions.pop(front.topic, None)
        self._finish(Done(front.id, topic_id))

    def _on_puback_of_qos0(self, now: float, message: Message) -> bool:
        """An error is answered at QoS 0 too (6.6b): the message is lost, what it says is heeded."""
        if not isinstance(message, Puback):
            return False
        if message.return_code == ReturnCode.INVALID_TOPIC_ID:
            self._topics.forget(message.topic_id)
            return True
        if message.return_code == ReturnCode.CONGESTION:
            self._paused_until = now + self._timing.t_wait
            return True
        return False

    def _postpone(self, front: Operation) -> None:
        """It begins anew when its turn comes."""
        self._timer.stop()
        front.sent = None

    def _finish(self, event: Action) -> None:
        self._timer.stop()
        self._queue.pop()
        self._out.append(event)

    def _fail(self, code: int) -> None:
        front = self._queue.front
        assert front is not None
        if front.is_restoring:
            self._subscriptions.pop(front.topic, None)
            return self._finish(SubscriptionLost(front.topic, code))
        self._finish(Failed(front.id, code))

    def _next_msg_id(self) -> int:
        self._last_msg_id = self._last_msg_id % 0xFFFF + 1  # 0 means "no message id"
        return self._last_msg_id
