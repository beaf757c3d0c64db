"""Messages from the broker: MQTT-SN 1.2 sections 6.10 and 6.6 at QoS 2.

At QoS 2 a message is handed on when it comes first; its message id is remembered until PUBREL, and what comes under
that id meanwhile is only answered.
"""

from __future__ import annotations

from ..mqttsn.messages import Message, Puback, Pubcomp, Publish, Pubrec, Pubrel, Regack, Register
from ..mqttsn.topic import PredefinedTopic, fixed_topic, text_on_wire
from ..mqttsn.types import DUP, RETAIN, Qos, ReturnCode, TopicIdType, is_assignable, qos_in, topic_type_in
from .events import Received
from .topic_table import TopicTable


class Receiver:
    def __init__(self, topics: TopicTable, most_unreleased: int) -> None:
        self._topics = topics
        self._most = most_unreleased
        self._unreleased: dict[int, None] = {}  # message ids, oldest first

    def clear(self) -> None:
        self._unreleased.clear()

    def on_register(self, message: Register) -> Regack:
        """Before the broker publishes on a name whose id this client cannot know. Any id is taken, and a new name for a
        known id replaces the old one."""
        name = text_on_wire(message.topic_name)
        if not is_assignable(message.topic_id):
            code = ReturnCode.INVALID_TOPIC_ID
        elif name is None:
            code = ReturnCode.NOT_SUPPORTED
        elif not self._topics.put(message.topic_id, name):
            code = ReturnCode.CONGESTION
        else:
            code = ReturnCode.ACCEPTED
        return Regack(message.topic_id, message.msg_id, code)

    def on_publish(self, message: Publish) -> Received | Message:
        """A message for the application, or what is to be answered without one. A refusal is told at QoS 0 too."""
        qos = qos_in(message.flags)
        type = topic_type_in(message.flags)
        topic: str | PredefinedTopic | None
        if type is TopicIdType.NORMAL:
            topic = self._topics.name_of(message.topic_id)
        else:
            topic = fixed_topic(type, message.topic_id)
        if topic is None or qos is Qos.WITHOUT_CONNECTION:
            is_unknown = topic is None and type is not TopicIdType.RESERVED
            code = ReturnCode.INVALID_TOPIC_ID if is_unknown else ReturnCode.NOT_SUPPORTED
            return Puback(message.topic_id, message.msg_id, code)
        if qos is Qos.EXACTLY_ONCE and message.msg_id in self._unreleased:
            return Pubrec(message.msg_id)
        flags = message.flags
        return Received(
            topic, message.data, qos, bool(flags & RETAIN), bool(flags & DUP), message.topic_id, message.msg_id
        )

    def accept(self, received: Received) -> Message | None:
        """The application has the message: what the broker is to be told."""
        if received.qos is Qos.AT_LEAST_ONCE:
            return Puback(received.topic_id, received.msg_id, ReturnCode.ACCEPTED)
        if received.qos is not Qos.EXACTLY_ONCE:
            return None
        if len(self._unreleased) >= self._most:
            # A broker has one exchange open per client, so the oldest is one that it gave up.
            del self._unreleased[next(iter(self._unreleased))]
        self._unreleased[received.msg_id] = None
        return Pubrec(received.msg_id)

    def on_pubrel(self, message: Pubrel) -> Pubcomp:
        """Answered also when the id is unknown: PUBCOMP was lost (6.6d)."""
        self._unreleased.pop(message.msg_id, None)
        return Pubcomp(message.msg_id)
