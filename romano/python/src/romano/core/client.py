"""An MQTT-SN 1.2 client without a socket or a clock.

    core = ClientCore(Timing(), Limits())
    core.connect(now, ConnectOptions("robot-7"))
    operation = core.publish(now, "pose", b"x=1", qos=1)

Times are seconds on any clock that never goes back. After each call the owner carries ``take_actions()`` out, in order:
datagrams go to the broker, events to the application. It calls ``on_datagram()`` with what comes from the broker's
address, and ``on_tick()`` at ``next_wakeup()``.

The core connects with or without a will, registers names by itself before it publishes on them, publishes and receives
at every QoS (QoS 2 exactly once), repeats what is not answered, registers anew after PUBACK 2, keeps the session alive,
sleeps, and connects again when a connection was lost. Operations may be asked for at any time: they wait in a bounded
queue and go out one after the other, as the specification wants.
"""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace
from enum import Enum

from ..errors import InvalidTopic, NotConnected
from ..mqttsn import messages
from ..mqttsn.codec import Malformed, decode, encode
from ..mqttsn.messages import Message
from ..mqttsn.topic import Topic, check_filter, check_name
from ..mqttsn.types import MsgType, ReturnCode
from .connection import ConnectOptions, Will, connect_step
from .events import Action, Asleep, Connected, Disconnected, Event, Interrupted, Lost, Received, Refused, Send
from .keep_alive import KeepAlive, before_end_of
from .operations import Operation
from .receiver import Receiver
from .requests import Requests
from .timers import NEVER, RetryTimer
from .timing import Limits, Timing
from .topic_table import TopicTable


class State(Enum):
    """What a client is to its broker: MQTT-SN 1.2 section 6.14."""

    DISCONNECTED = "disconnected"
    """Never connected, refused, said so, or lost for good."""
    CONNECTING = "connecting"
    CONNECTED = "connected"
    INTERRUPTED = "interrupted"
    """The connection was lost; the next attempt comes by itself."""
    DISCONNECTING = "disconnecting"
    FALLING_ASLEEP = "falling asleep"
    ASLEEP = "asleep"
    AWAKE = "awake"
    """Asleep, and collecting its messages."""


_RECEIVING = (State.CONNECTED, State.DISCONNECTING, State.FALLING_ASLEEP, State.ASLEEP, State.AWAKE)


class ClientCore:
    def __init__(self, timing: Timing = Timing(), limits: Limits = Limits(), seed: int | None = None) -> None:
        self.state = State.DISCONNECTED
        self.drops: Counter[str] = Counter()
        """Datagrams that had no effect, by reason; "no_room": the application accepted no more."""
        self._timing = timing
        self._random = random.Random(seed)
        self._out: list[Action] = []
        self._topics = TopicTable(limits.topics)
        self._requests = Requests(timing, limits, self._topics, self._out, seed)
        self._receiver = Receiver(self._topics, limits.unreleased)
        self._keep_alive = KeepAlive(timing)
        self._options = ConnectOptions("-")
        self._step = MsgType.CONNECT  # CONNECT, WILLTOPIC, WILLMSG; DISCONNECT; PINGREQ of a sleeper
        self._step_timer = RetryTimer()
        self._was_connected = False
        self._connected_at = -NEVER
        self._reconnect_at = NEVER
        self._reconnect_pause = 0.0
        self._sleep_s = 0
        self._collect_due = NEVER

    # --- what the application asks for

    def connect(self, now: float, options: ConnectOptions) -> None:
        """Begins a connection, from any state. Ends in Connected, Refused or Lost."""
        self._options = options
        self._was_connected = False
        self._reconnect_pause = 0.0
        self._begin_connecting(now)

    def disconnect(self, now: float) -> None:
        """Ends in Disconnected, also when nobody answers. Waiting operations are kept."""
        if self.state in (State.DISCONNECTED, State.INTERRUPTED):
            return self._end(Disconnected(by_broker=False))
        self._leave(now, 0, State.DISCONNECTING)

    def sleep(self, now: float, duration_s: int) -> None:
        """Tells the broker to keep messages; ends in Asleep. From then on the client collects them by itself within
        each ``duration_s`` (1 to 65535 s). wake_up() ends the sleep.

        Raises NotConnected, ValueError.
        """
        if not 1 <= duration_s <= 0xFFFF:
            raise ValueError(f"sleep of {duration_s} s: must be from 1 to 65535")
        if self.state not in (State.CONNECTED, State.ASLEEP, State.AWAKE):
            raise NotConnected(f"a client that is {self.state.value} cannot fall asleep")
        self._sleep_s = duration_s
        self._leave(now, duration_s, State.FALLING_ASLEEP)

    def collect(self, now: float) -> None:
        """Collects now what the broker keeps for the sleeper; ends in Asleep. Raises NotConnected when not asleep."""
        if self.state is not State.ASLEEP:
            raise NotConnected(f"a client that is {self.state.value} cannot collect messages")
        self._begin_collecting(now)

    def wake_up(self, now: float) -> None:
        """Ends the sleep; ends as connect() does. Raises NotConnected when not asleep."""
        if self.state not in (State.ASLEEP, State.AWAKE):
            raise NotConnected(f"a client that is {self.state.value} cannot wake up")
        self._begin_connecting(now)

    def publish(self, now: float, topic: Topic, data: bytes, qos: int = 0, retain: bool = False) -> int:
        """An operation that ends in Done (sent at QoS -1 and 0, acknowledged at 1, completed at 2) or Failed.

        QoS -1 needs a short or predefined topic, and no connection. QoS 0 needs a connection: it does not wait for one.
        Raises InvalidTopic, NotConnected, QueueFull, TooLong, ValueError.
        """
        _check_qos(qos, least=-1)
        check_name(topic)
        if qos == -1 and isinstance(topic, str):
            raise InvalidTopic(f"topic {topic!r}: QoS -1 needs a ShortTopic or a PredefinedTopic")
        if qos == 0 and self.state is not State.CONNECTED:
            raise NotConnected(f"QoS 0 does not wait for a connection, and the client is {self.state.value}")
        if qos == -1 or (qos == 0 and not self._requests.paused_for(now)):
            at_once = self._requests.publish_at_once(topic, data, qos, retain)
            if at_once is not None:
                return at_once
        return self._ask(now, Operation(MsgType.PUBLISH, topic, data, qos, retain))

    def subscribe(self, now: float, topic: Topic, qos: int = 1) -> int:
        """An operation that ends in Done or Failed. After a lost connection it is made again by itself.

        Raises InvalidTopic, QueueFull, TooLong, ValueError.
        """
        _check_qos(qos, least=0)
        check_filter(topic)
        return self._ask(now, Operation(MsgType.SUBSCRIBE, topic, qos=qos))

    def unsubscribe(self, now: float, topic: Topic) -> int:
        """An operation that ends in Done. Raises InvalidTopic, QueueFull, TooLong."""
        check_filter(topic)
        return self._ask(now, Operation(MsgType.UNSUBSCRIBE, topic))

    def register(self, now: float, name: str) -> int:
        """publish() does this by itself; of use to know a topic's id early. An operation that ends in Done or Failed.

        Raises InvalidTopic, QueueFull, TooLong.
        """
        check_name(name)
        return self._ask(now, Operation(MsgType.REGISTER, name))

    def update_will(self, now: float, will: Will | None) -> list[int]:
        """Two operations, or one that deletes the will; each ends in Done or Failed. A connection that is made again
        has the new will. Raises QueueFull, TooLong."""
        if will is None:
            operations = [Operation(MsgType.WILLTOPICUPD)]
        else:
            operations = [
                Operation(MsgType.WILLMSGUPD, data=will.message),
                Operation(MsgType.WILLTOPICUPD, will.topic, qos=will.qos, retain=will.retain),
            ]
        ids = [self._ask(now, operation) for operation in operations]
        self._options = replace(self._options, will=will)
        return ids

    def cancel(self, operation: int) -> bool:
        """Forgets an operation that was not begun. False when it is on its way or over; its end will be told."""
        return self._requests.cancel(operation)

    def accept(self, received: Received) -> None:
        """The application has taken the message: only then the broker is told so."""
        answer = self._receiver.accept(received)
        if answer is not None:
            self._send(answer)

    def decline(self, received: Received) -> None:
        """The application has no room: a message of QoS 1 or 2 comes again, one of QoS 0 is lost."""
        self.drops["no_room"] += 1

    # --- what happens

    def on_datagram(self, now: float, datagram: bytes) -> None:
        """Whatever came from the broker's address. What is no message, or none that a client receives in this state, is
        dropped and counted."""
        message = decode(datagram)
        if isinstance(message, Malformed):
            self.drops[message.value] += 1
            return
        if self.state is State.AWAKE:
            # Whatever comes now shows that the broker is not done yet (6.14d).
            self._step_timer.put_off(now, self._timing.t_retry)
        if not self._dispatch(now, message):
            self.drops["unexpected"] += 1
        self._carry_on(now)

    def on_tick(self, now: float) -> None:
        """Early or repeated ticks are harmless."""
        if self._reconnect_at <= now:
            self._begin_connecting(now)
        if self._step_timer.deadline <= now:
            if self._step_timer.repeat(now, self._timing.t_retry):
                self._send_step()
            else:
                self._give_up(now)
        if self._collect_due <= now:
            self._begin_collecting(now)
        if not self._requests.on_tick(now):
            self._lose(now, "the broker did not answer")
        ping = self._keep_alive.on_tick(now)
        if ping is False:
            self._lose(now, "the broker did not answer PINGREQ")
        elif ping:
            self._send(messages.Pingreq())
        self._carry_on(now)

    def next_wakeup(self) -> float:
        """When to call on_tick(); infinite when nothing is due."""
        return min(
            self._step_timer.deadline,
            self._requests.deadline,
            self._keep_alive.deadline,
            self._collect_due,
            self._reconnect_at,
        )

    def take_actions(self) -> list[Action]:
        """What arose since the last call."""
        actions = self._out.copy()
        self._out.clear()
        return actions

    def paused_for(self, now: float) -> float:
        """Seconds for which nothing is asked of a congested broker; 0 when it is not."""
        return self._requests.paused_for(now)

    # --- messages

    def _dispatch(self, now: float, message: Message) -> bool:
        """False when the message means nothing in this state."""
        if isinstance(message, messages.Connack):
            return self._on_connack(now, message.return_code)
        if isinstance(message, (messages.Willtopicreq, messages.Willmsgreq)):
            return self._on_will_prompt(now, message)
        if self.state not in _RECEIVING:
            return False
        if isinstance(message, messages.Publish):
            result = self._receiver.on_publish(message)
            if isinstance(result, Received):
                self._out.append(result)
            else:
                self._send(result)
        elif isinstance(message, messages.Register):
            self._send(self._receiver.on_register(message))
        elif isinstance(message, messages.Pubrel):
            self._send(self._receiver.on_pubrel(message))
        elif isinstance(message, messages.Pingreq):
            self._send(messages.Pingresp())  # the broker asks whether we live
        elif isinstance(message, messages.Pingresp):
            return self._on_pingresp(now)
        elif isinstance(message, messages.Disconnect):
            self._on_disconnect(now)
        else:
            return self._on_answer(now, message)
        return True

    def _on_answer(self, now: float, message: Message) -> bool:
        if self.state is not State.CONNECTED or not self._requests.on_answer(now, message):
            return False
        self._keep_alive.on_sign_of_life(now)
        return True

    def _on_pingresp(self, now: float) -> bool:
        if self.state is State.AWAKE:
            self._fall_asleep(now)
        elif self.state is State.CONNECTED:
            self._keep_alive.on_pingresp(now)
        else:
            return False
        return True

    # --- connection, sections 6.2, 6.12 and 6.13

    def _begin_connecting(self, now: float) -> None:
        self._stop()
        self.state = State.CONNECTING
        self._begin_step(now, MsgType.CONNECT)

    def _begin_step(self, now: float, step: MsgType) -> None:
        self._step = step
        self._step_timer.start(now, self._timing.t_retry, self._timing.n_retry)
        self._send_step()

    def _send_step(self) -> None:
        if self._step is MsgType.DISCONNECT:
            self._send(messages.Disconnect(self._sleep_s if self.state is State.FALLING_ASLEEP else 0))
        elif self._step is MsgType.PINGREQ:
            self._send(messages.Pingreq(self._options.client_id.encode()))
        else:
            goes_on = replace(self._options, clean_session=self._options.clean_session and not self._was_connected)
            self._send(connect_step(self._step, goes_on))

    def _on_will_prompt(self, now: float, prompt: Message) -> bool:
        """A prompt may come twice, as every message; the answer is given again (6.2d)."""
        if self.state is not State.CONNECTING or self._options.will is None:
            return False
        is_topic = isinstance(prompt, messages.Willtopicreq)
        self._begin_step(now, MsgType.WILLTOPIC if is_topic else MsgType.WILLMSG)
        return True

    def _on_connack(self, now: float, code: int) -> bool:
        if self.state is not State.CONNECTING:
            return False
        if code == ReturnCode.CONGESTION and self._was_connected and self._options.reconnect:
            self._reconnect_in(now, self._timing.t_wait)
            return True
        if code != ReturnCode.ACCEPTED:
            self._end(Refused(code))
            return True
        is_clean = self._options.clean_session and not self._was_connected
        self._step_timer.stop()
        self.state = State.CONNECTED
        self._was_connected = True
        self._connected_at = now
        self._keep_alive.start(now, self._options.keep_alive_s)
        self._out.append(Connected())
        if is_clean:
            self._topics.clear()
            self._receiver.clear()
        self._requests.resume(now, is_clean)
        return True

    def _leave(self, now: float, sleep_s: int, state: State) -> None:
        self._stop()
        self._sleep_s = sleep_s
        self.state = state
        self._begin_step(now, MsgType.DISCONNECT)

    def _on_disconnect(self, now: float) -> None:
        if self.state is State.FALLING_ASLEEP:
            self._fall_asleep(now)
        elif self.state is State.DISCONNECTING:
            self._end(Disconnected(by_broker=False))
        else:
            self._interrupt(now, Disconnected(by_broker=True), "the broker knows the session no more")

    def _give_up(self, now: float) -> None:
        """N_retry repetitions of a step were not answered (6.13)."""
        if self.state is State.AWAKE:
            self._fall_asleep(now)  # it tries again in its next period (6.14d)
        elif self.state is State.DISCONNECTING:
            self._end(Disconnected(by_broker=False))
        elif self.state is State.CONNECTING and self._was_connected and self._options.reconnect:
            self._reconnect_in(now, self._next_pause())
        else:
            self._lose(now, "the broker did not answer")

    def _lose(self, now: float, reason: str) -> None:
        self._interrupt(now, Lost(), reason)

    def _interrupt(self, now: float, end: Event, reason: str) -> None:
        """The connection is gone without our doing."""
        if not (self._options.reconnect and self._was_connected):
            return self._end(end)
        self._out.append(Interrupted(reason))
        if now - self._connected_at > self._timing.reconnect_most:
            self._reconnect_pause = 0.0
        self._reconnect_in(now, self._next_pause())

    def _next_pause(self) -> float:
        """At first none. Later ones double, also when a broker takes us in only to throw us out."""
        pause = self._reconnect_pause * self._random.uniform(0.5, 1.0)
        self._reconnect_pause = min(max(1.0, 2 * self._reconnect_pause), self._timing.reconnect_most)
        return pause

    def _reconnect_in(self, now: float, pause_s: float) -> None:
        self._stop()
        self.state = State.INTERRUPTED
        self._reconnect_at = now + pause_s

    def _end(self, event: Event) -> None:
        self._stop()
        self.state = State.DISCONNECTED
        self._out.append(event)

    def _stop(self) -> None:
        """All timers."""
        self._step_timer.stop()
        self._requests.stop()
        self._keep_alive.stop()
        self._reconnect_at = NEVER
        self._collect_due = NEVER

    # --- sleep, section 6.14

    def _begin_collecting(self, now: float) -> None:
        self.state = State.AWAKE
        self._collect_due = NEVER
        self._begin_step(now, MsgType.PINGREQ)

    def _fall_asleep(self, now: float) -> None:
        self._stop()
        self.state = State.ASLEEP
        self._collect_due = now + before_end_of(self._sleep_s)
        self._out.append(Asleep())

    # --- operations

    def _ask(self, now: float, operation: Operation) -> int:
        id = self._requests.push(operation)
        self._carry_on(now)
        return id

    def _carry_on(self, now: float) -> None:
        if self.state is State.CONNECTED:
            self._requests.carry_on(now)

    def _send(self, message: Message) -> None:
        self._out.append(Send(encode(message)))


def _check_qos(qos: int, least: int) -> None:
    if not least <= qos <= 2:
        raise ValueError(f"QoS {qos}: must be from {least} to 2")
