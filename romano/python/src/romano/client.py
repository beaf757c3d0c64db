"""An MQTT-SN client for asyncio: one UDP socket and one timer around ``core.client``."""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
from collections import Counter, deque
from types import TracebackType
from typing import TypeAlias

from .core import events
from .core.client import ClientCore, State
from .core.connection import ConnectOptions, Will
from .core.timing import Limits, Timing
from .errors import ConnectionLost, NotConnected, RomanoError, rejection
from .mqttsn.topic import Topic
from .subscription import Message, Subscription

_log = logging.getLogger("romano")
_Address: TypeAlias = tuple[str, int] | tuple[str, int, int, int]
"""Of IPv4, or of IPv6 with its flow and scope."""

MOST_UNCLAIMED = 100
"""Messages of a kept session that no subscription of this program wants yet. The oldest goes."""


class Client:
    """A connection to one broker, which may change its machine without this client noticing.

        async with romano.Client("127.0.0.1") as client:
            poses = await client.subscribe("robots/+/pose")
            await client.publish("robots/abcd1234/pose", "x=1 y=2", qos=1)
            print((await poses.get(timeout_s=1)).text)

    ``client_id``: made up if None. ``clean_session``: the broker first erases what it kept of this id;
    if not, messages that it kept wait for the subscribe() that wants them (100, the oldest goes). ``keep_alive_s``:
    the broker publishes ``will`` when it hears nothing for about 1.5 times as long. ``reconnect``: after a lost
    connection connect again, as often as it takes, with all subscriptions; requests wait meanwhile.

    One asyncio loop owns a client; it is not for several threads. Raises ValueError for settings that are not possible.
    """

    def __init__(
        self,
        host: str = "127.0.0.1",
        port: int = 1883,
        *,
        client_id: str | None = None,
        clean_session: bool = True,
        keep_alive_s: int = 60,
        will: Will | None = None,
        reconnect: bool = True,
        timing: Timing = Timing(),
        limits: Limits = Limits(),
    ) -> None:
        self.host = host
        self.port = port
        self.interruptions = 0
        """How often the connection was lost and sought again."""
        self._options = ConnectOptions(
            client_id or "py-" + secrets.token_hex(8), clean_session, keep_alive_s, will, reconnect
        )
        self._timing = timing
        self._limits = limits
        self._core = ClientCore(timing, limits)
        self._transport: asyncio.DatagramTransport | None = None
        self._is_blocked = False  # too much waits for the kernel
        self._timer: asyncio.TimerHandle | None = None
        self._opening: asyncio.Future[None] | None = None
        self._waking: asyncio.Future[None] | None = None
        self._leaving: asyncio.Future[None] | None = None
        self._sleeping: asyncio.Future[None] | None = None
        self._operations: dict[int, asyncio.Future[events.Done]] = {}
        self._subscriptions: list[Subscription] = []
        self._unclaimed: deque[Message] = deque(maxlen=MOST_UNCLAIMED)

    # --- connection

    @property
    def client_id(self) -> str:
        return self._options.client_id

    @property
    def state(self) -> State:
        return self._core.state

    @property
    def drops(self) -> Counter[str]:
        """Datagrams from the broker's address that had no effect, by reason: malformed ones, unexpected ones,
        ``no_room`` for messages that found full queues; ``unsent`` for datagrams that the kernel had no room for,
        ``errors`` of the socket beside them."""
        return self._core.drops

    async def connect(self) -> None:
        """Raises NotConnected when nobody listens there, ConnectionLost when nobody answers (with the usual Timing
        after 40 s), Rejected when the broker refuses, OSError for a host that is not known."""
        if self._transport is not None:
            raise NotConnected("connect() while connected: disconnect() first")
        loop = asyncio.get_running_loop()
        found = await loop.getaddrinfo(self.host, self.port, type=socket.SOCK_DGRAM)
        addresses = list(dict.fromkeys((family, place) for family, *_, place in found))
        for address in addresses:  # "localhost" may be ::1, where perhaps nobody listens, and 127.0.0.1
            try:
                return await self._connect_to(*address)
            except OSError as error:
                may_go_on = isinstance(error, _NobodyListens) or not isinstance(error, RomanoError)
                if address == addresses[-1] or not may_go_on:
                    raise

    async def _connect_to(self, family: int, address: _Address) -> None:
        loop = asyncio.get_running_loop()
        own = socket.socket(family, socket.SOCK_DGRAM)
        try:
            own.setblocking(False)
            own.connect(address)
        except OSError:
            own.close()
            raise
        self._transport, _ = await loop.create_datagram_endpoint(lambda: _Protocol(self), sock=own)
        self._is_blocked = False
        self._core = ClientCore(self._timing, self._limits)
        self._opening = loop.create_future()
        try:
            self._core.connect(loop.time(), self._options)
            self._carry_out()
            await self._opening
        except BaseException:
            self._close(None)
            raise
        finally:
            self._opening = None

    async def disconnect(self, patience_s: float = 2.0) -> None:
        """Says goodbye, so that no will is published, and waits ``patience_s`` seconds at most for the answer. Whatever
        was still asked for fails with NotConnected; subscriptions end."""
        if self._transport is None:
            return
        loop = asyncio.get_running_loop()
        self._leaving = loop.create_future()
        try:
            self._core.disconnect(loop.time())
            self._carry_out()
            async with asyncio.timeout(patience_s):
                await self._leaving
        except TimeoutError:
            _log.info("%s did not answer DISCONNECT", self._where())
        finally:
            self._leaving = None
            self._close(None)

    async def __aenter__(self) -> Client:
        await self.connect()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.disconnect()

    # --- messages

    async def publish(self, topic: Topic, data: bytes | str = b"", qos: int = 0, retain: bool = False) -> None:
        """Returns when the message was sent (QoS -1, 0), acknowledged (1), or completed (2).

        ``topic``: a name (registered at the broker by itself), a ShortTopic or a PredefinedTopic. ``retain``: the
        broker keeps it for later subscribers; with empty ``data`` it forgets the one that it kept. A message of QoS 1
        or 2 waits for a lost connection to come back; one of QoS 0 raises NotConnected then.

        Raises Congestion and other Rejected, InvalidTopic, QueueFull, TooLong (65,498 octets of data at most),
        NotConnected; ValueError for a QoS that is none.
        """
        octets = data.encode() if isinstance(data, str) else bytes(data)
        self._check_open()
        operation = self._core.publish(self._now(), topic, octets, qos, retain)
        await self._end_of(operation, f"PUBLISH on {topic!r}")

    async def subscribe(self, topic: Topic, qos: int = 1, room: int = 1000) -> Subscription:
        """Messages on a name, a filter (``+`` a level, ``#`` the rest), a ShortTopic or a PredefinedTopic, at ``qos``
        at most.

        ``room``: messages that may wait unread; see Subscription. Several subscriptions may match a message: each gets
        it. Raises Congestion and other Rejected, InvalidTopic, QueueFull, NotConnected, ValueError.
        """
        subscription = Subscription(topic, room, self._leave)
        self._check_open()
        asked = max([qos, *(other.granted for other in self._subscriptions if other.topic == topic)])
        operation = self._core.subscribe(self._now(), topic, asked)
        self._subscriptions.append(subscription)
        self._hand_over_unclaimed(subscription)
        try:
            done = await self._end_of(operation, f"SUBSCRIBE to {topic!r}")
        except BaseException:
            self._subscriptions.remove(subscription)
            raise
        subscription.granted = done.granted
        return subscription

    def _leave(self, subscription: Subscription) -> asyncio.Future[events.Done] | None:
        """Tells the broker, unless others here want the same topic: the end of that."""
        if subscription.is_over:
            return None
        subscription.end()
        self._subscriptions.remove(subscription)
        if any(other.topic == subscription.topic for other in self._subscriptions):
            return None
        return self._begin(self._core.unsubscribe(self._now(), subscription.topic))

    async def register(self, name: str) -> int:
        """The topic's id. publish() does this by itself; of use before a message that must not wait.

        Raises Congestion and other Rejected, InvalidTopic, QueueFull, NotConnected.
        """
        self._check_open()
        return (await self._end_of(self._core.register(self._now(), name), f"REGISTER of {name!r}")).topic_id

    async def update_will(self, will: Will | None) -> None:
        """Replaces the will, or deletes it. Raises Rejected, QueueFull, NotConnected."""
        self._check_open()
        for operation in self._core.update_will(self._now(), will):
            await self._end_of(operation, "the new will")

    # --- sleep

    async def sleep(self, duration_s: int) -> None:
        """The broker keeps all messages from now on; they are collected at least every ``duration_s`` (1 to 65535)
        seconds, and by collect(). Nothing can be published or asked for until wake_up(). Raises NotConnected,
        ValueError."""
        self._core.sleep(self._now(), duration_s)
        await self._until_asleep()

    async def collect(self) -> None:
        """Collects what the broker keeps for the sleeper, now. Raises NotConnected when not asleep."""
        self._core.collect(self._now())
        await self._until_asleep()

    async def wake_up(self) -> None:
        """Ends the sleep. Raises NotConnected, ConnectionLost, Rejected."""
        self._core.wake_up(self._now())
        self._waking = asyncio.get_running_loop().create_future()
        try:
            self._carry_out()
            await self._waking
        finally:
            self._waking = None

    async def _until_asleep(self) -> None:
        self._sleeping = asyncio.get_running_loop().create_future()
        try:
            self._carry_out()
            await self._sleeping
        finally:
            self._sleeping = None

    # --- around the core

    def _now(self) -> float:
        return asyncio.get_running_loop().time()

    def _where(self) -> str:
        return f"the broker at {self.host} port {self.port}"

    def _check_open(self) -> None:
        if self._transport is None:
            raise NotConnected(f"not connected to {self._where()}: connect() first, or `async with` the client")

    def _begin(self, operation: int) -> asyncio.Future[events.Done]:
        """Carries the core's actions out; the future is the operation's end."""
        future: asyncio.Future[events.Done] = asyncio.get_running_loop().create_future()
        self._operations[operation] = future
        future.add_done_callback(lambda ended: self._forget(operation, ended))
        self._carry_out()
        return future

    def _forget(self, operation: int, ended: asyncio.Future[events.Done]) -> None:
        self._operations.pop(operation, None)
        if ended.cancelled():
            self._core.cancel(operation)
        else:
            ended.exception()  # nobody may be waiting for it

    async def _end_of(self, operation: int, what: str) -> events.Done:
        future = self._begin(operation)
        if future.done():
            await asyncio.sleep(0)  # who publishes without a pause lets others have their turn
        try:
            return await future
        except _Failure as failure:
            raise rejection(what, failure.return_code, self._core.paused_for(self._now())) from None

    def _carry_out(self) -> None:
        while actions := self._core.take_actions():
            for action in actions:
                if isinstance(action, events.Send):
                    self._send(action.datagram)
                elif isinstance(action, events.Received):
                    self._deliver(action)
                else:
                    self._heed(action)
        self._set_timer()

    def _send(self, datagram: bytes) -> None:
        if self._transport is None:
            return
        if self._is_blocked:
            self._core.drops["unsent"] += 1  # as a network would
        else:
            self._transport.sendto(datagram)

    def _deliver(self, received: events.Received) -> None:
        message = Message(received.topic, received.data, received.qos, received.retain, received.dup)
        wanting = [subscription for subscription in self._subscriptions if subscription.wants(message.topic)]
        if received.qos > 0 and not all(subscription.has_room for subscription in wanting):
            return self._core.decline(received)
        self._core.accept(received)
        for subscription in wanting:
            subscription.put(message)
        if not wanting and not self._options.clean_session:
            self._unclaimed.append(message)

    def _hand_over_unclaimed(self, subscription: Subscription) -> None:
        """The broker sends what it kept for a session before the program has said again what it subscribes to."""
        waiting = list(self._unclaimed)
        self._unclaimed.clear()
        for message in waiting:
            subscription.put(message) if subscription.wants(message.topic) else self._unclaimed.append(message)

    def _heed(self, event: events.Event) -> None:
        if isinstance(event, events.Done):
            self._settle(event.operation, event)
        elif isinstance(event, events.Failed):
            self._settle(event.operation, _Failure(event.return_code))
        elif isinstance(event, events.Connected):
            _log.debug("connected to %s", self._where())
            _resolve(self._opening)
            _resolve(self._waking)
        elif isinstance(event, events.Asleep):
            _resolve(self._sleeping)
        elif isinstance(event, events.Interrupted):
            self.interruptions += 1
            _log.warning("connection to %s interrupted: %s", self._where(), event.reason)
            _resolve(self._sleeping, ConnectionLost(event.reason))
        elif isinstance(event, events.SubscriptionLost):
            self._lose_subscription(event)
        elif isinstance(event, events.Disconnected) and not event.by_broker:
            _resolve(self._leaving)
        elif isinstance(event, events.Refused):
            self._fail(rejection("CONNECT", event.return_code, self._timing.t_wait))
        else:
            attempts = f"{self._timing.n_retry + 1} attempts, {self._timing.t_retry:g} s each"
            reason = "ended the session" if isinstance(event, events.Disconnected) else f"did not answer ({attempts})"
            self._fail(ConnectionLost(f"{self._where()} {reason}"))

    def _lose_subscription(self, event: events.SubscriptionLost) -> None:
        why = rejection(f"SUBSCRIBE to {event.topic!r} after a new connection", event.return_code)
        for subscription in [s for s in self._subscriptions if s.topic == event.topic]:
            subscription.end(why)
            self._subscriptions.remove(subscription)

    def _settle(self, operation: int, result: events.Done | _Failure) -> None:
        future = self._operations.get(operation)
        if future is None or future.done():
            return
        if isinstance(result, _Failure):
            future.set_exception(result)
        else:
            future.set_result(result)

    def _fail(self, why: Exception) -> None:
        """The connection is over, and not by our doing."""
        if self._opening is not None:
            return _resolve(self._opening, why)
        self._close(why)

    def _close(self, why: Exception | None) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._transport is not None:
            self._transport.close()
            self._transport = None
        for operation in list(self._operations):
            self._core.cancel(operation)
            future = self._operations[operation]
            if not future.done():
                future.set_exception(why or NotConnected("disconnect() before it was answered"))
        for subscription in self._subscriptions:
            subscription.end(why)
        self._subscriptions.clear()
        for waiting in (self._opening, self._waking, self._sleeping):
            _resolve(waiting, why or NotConnected("disconnect() came before"))
        _resolve(self._leaving)

    def _set_timer(self) -> None:
        """One timer for the core. It is left alone when it comes too early, which is harmless."""
        wakeup = self._core.next_wakeup()
        if self._transport is None or (self._timer is not None and self._timer.when() <= wakeup):
            return
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if wakeup != float("inf"):
            self._timer = asyncio.get_running_loop().call_at(wakeup, self._on_timer)

    def _on_timer(self) -> None:
        self._timer = None
        self._core.on_tick(self._now())
        self._carry_out()

    def _on_datagram(self, datagram: bytes) -> None:
        if self._transport is None:
            return
        self._core.on_datagram(self._now(), datagram)
        self._carry_out()

    def _on_error(self, error: OSError) -> None:
        """ICMP says that nobody listens. Who begins wants to know; later it may be a broker that is about to come
        back."""
        self._core.drops["errors"] += 1
        if self._opening is not None and isinstance(error, ConnectionRefusedError):
            why = f"no broker serves at {self.host} port {self.port}: nobody listens there"
            _resolve(self._opening, _NobodyListens(why))


class _NobodyListens(NotConnected):
    pass


class _Failure(Exception):
    def __init__(self, return_code: int) -> None:
        self.return_code = return_code


class _Protocol(asyncio.DatagramProtocol):
    """The socket is connected: what does not come from the broker's address does not come here."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def datagram_received(self, data: bytes, addr: object) -> None:
        self._client._on_datagram(data)

    def pause_writing(self) -> None:
        self._client._is_blocked = True

    def resume_writing(self) -> None:
        self._client._is_blocked = False

    def error_received(self, exc: Exception) -> None:
        if isinstance(exc, OSError):
            self._client._on_error(exc)


def _resolve(future: asyncio.Future[None] | None, error: Exception | None = None) -> None:
    if future is None or future.done():
        return
    if error is None:
        future.set_result(None)
    else:
        future.set_exception(error)
