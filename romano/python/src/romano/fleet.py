"""The robots of all brokers: who is there, and what they are told to do."""

from __future__ import annotations

import asyncio
import logging
import secrets
from collections.abc import AsyncIterator
from dataclasses import dataclass
from types import TracebackType

from . import command, message
from .client import Client
from .errors import CannotSay, NoAnswer, NotConnected, Rejected, UnknownRobot
from .message import Heartbeat, Location, Malformed, RomanoMessage, SensorData, is_romano_id
from .node_entry import ENTRIES, Robot, parse_entry, robot_of
from .subscription import Message, Subscription

COMMON = "common"
"""The topic that all robots subscribe to."""
MOST_ROBOTS = 10_000
"""As many as a broker keeps. Further ones are not listed."""
_log = logging.getLogger("romano")
SETTLED_S = 0.2
"""Entries come in one burst; it is over after so much silence."""


@dataclass(frozen=True)
class Change:
    """What became known of a robot. Exactly one of the three is the case."""

    id: str
    robot: Robot | None = None
    """As it is from now on: it came, its state or its home changed."""
    is_gone: bool = False
    is_heartbeat: bool = False


class Fleet:
    """The robots as one connected client sees them.

        async with romano.Client("127.0.0.1") as client, romano.Fleet(client) as fleet:
            for robot in fleet.robots:
                print(robot.id, robot.state, robot.home)
            await fleet.move("abcd1234", "front", mm=100)

    ``robot`` in a command is an id, or a topic that several robots listen to, such as ``fleet.COMMON``.
    """

    def __init__(self, client: Client) -> None:
        self.client = client
        self._robots: dict[str, Robot] = {}
        self._entries: Subscription | None = None
        self._reader: asyncio.Task[None] | None = None
        self._heard = 0

    async def watch(self) -> None:
        """Begins; `async with` does it too. Returns when the robots that are known now are listed. Raises as
        Client.subscribe() does."""
        self._entries = await self.client.subscribe(ENTRIES, qos=1, room=MOST_ROBOTS)
        self._reader = asyncio.create_task(self._read(self._entries))
        heard = -1
        while heard != self._heard:
            heard = self._heard
            await asyncio.sleep(SETTLED_S)

    def close(self) -> None:
        """Ends; the client stays connected."""
        if self._reader is not None:
            self._reader.cancel()
        if self._entries is not None:
            self._entries.close()

    async def __aenter__(self) -> Fleet:
        await self.watch()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    # --- who is there

    @property
    def robots(self) -> list[Robot]:
        """All robots of all brokers, by id, as they are now."""
        return [self._robots[id] for id in sorted(self._robots)]

    def robot(self, id: str) -> Robot:
        """Raises UnknownRobot."""
        if id not in self._robots:
            raise UnknownRobot(f"no robot {id} is known to the broker at {self.client.host} port {self.client.port}")
        return self._robots[id]

    async def changes(self) -> AsyncIterator[Change]:
        """Robots that come, change and go, and heartbeats, as they are told. Begins with those that are there."""
        known: dict[str, Robot] = {}
        async with (
            await self.client.subscribe(ENTRIES, qos=1, room=MOST_ROBOTS) as entries,
            await self.client.subscribe(COMMON, qos=0) as common,
        ):
            queue: asyncio.Queue[Message | BaseException] = asyncio.Queue(maxsize=1)
            readers = [asyncio.create_task(_forward(source, queue)) for source in (entries, common)]
            try:
                while True:
                    heard = await queue.get()
                    if isinstance(heard, StopAsyncIteration):
                        return
                    if isinstance(heard, BaseException):
                        raise heard
                    change = _change(known, heard)
                    if change is not None:
                        yield change
            finally:
                for reader in readers:
                    reader.cancel()

    async def _read(self, entries: Subscription) -> None:
        try:
            async for entry in entries:
                self._heard += 1
                _change(self._robots, entry)
        except (NotConnected, Rejected) as end:
            _log.warning("robots are listed as they were: %s", end)

    # --- what they are told

    async def move(
        self,
        robot: str,
        movement: str,
        *,
        mm: float | None = None,
        deg: float | None = None,
        ms: float | None = None,
        speed_percent: int = 30,
        qos: int = 2,
    ) -> None:
        """Moves a robot. Returns when the broker has the message (QoS 1, 2), not when the robot has moved: see ask().

        ``movement``: front, back, left, right with ``mm`` (millimetres), rotate-left, rotate-right with ``deg``
        (degrees). Robots with the authors' firmware drive front and back for ``ms`` (milliseconds) at ``speed_percent``
        of their power. ``qos``: at 2 no robot carries a movement out twice.

        Raises UnknownRobot, CannotSay, and as Client.publish() does.
        """
        data = command.move_message(self._form(robot), movement, mm=mm, deg=deg, ms=ms, speed_percent=speed_percent)
        await self.client.publish(robot, data, qos)

    async def subscribe_robot(self, robot: str, topic: str, qos: int = 2) -> None:
        """Tells a robot to listen to ``topic`` too. Raises as move() does."""
        await self.client.publish(robot, command.subscribe_message(self._form(robot), topic), qos)

    async def unsubscribe_robot(self, robot: str, topic: str, qos: int = 2) -> None:
        """Tells a robot to listen to ``topic`` no more. Raises as move() does."""
        await self.client.publish(robot, command.unsubscribe_message(self._form(robot), topic), qos)

    async def request(self, robot: str, topic: str, kind: str, qos: int = 2) -> None:
        """Tells a robot to publish that kind of data ("location", "battery"…) on ``topic``. Raises as move() does."""
        await self.client.publish(robot, command.request_message(self._form(robot), topic, kind), qos)

    async def ask(self, robot: str, kind: str, timeout_s: float = 5.0) -> RomanoMessage | bytes:
        """Requests that kind of data and waits for the answer: a ROMANO message, or octets that are none.

        Messages of one publisher on one topic arrive in order: the answer says that the robot has had all commands
        before. Raises NoAnswer after ``timeout_s`` seconds, else as move() does.
        """
        topic = "answer-" + secrets.token_hex(4)  # 15 octets: what the authors' firmware can name
        async with await self.client.subscribe(topic, qos=2, room=10) as answers:
            await self.request(robot, topic, kind)
            try:
                answer = await answers.get(timeout_s)
            except TimeoutError:
                raise NoAnswer(
                    f"the broker has the message, but {robot} did not answer within {timeout_s:g} s"
                ) from None
        decoded = message.decode(answer.data)
        return answer.data if isinstance(decoded, Malformed) else decoded

    async def location(self, robot: str, timeout_s: float = 5.0) -> Location:
        """Where a robot is. Raises CannotSay when it answers something else; else as ask() does."""
        answer = await self.ask(robot, "location", timeout_s)
        if isinstance(answer, SensorData) and isinstance(answer.reading, Location):
            return answer.reading
        raise CannotSay(f"{robot} was asked for its location and answered {answer!r}")

    def _form(self, robot: str) -> str:
        return self.robot(robot).form if is_romano_id(robot) else command.BINARY


def _change(known: dict[str, Robot], heard: Message) -> Change | None:
    """Puts what was heard into ``known``. None when it is nothing new."""
    if not isinstance(heard.topic, str):
        return None
    if heard.topic == COMMON:
        beat = message.decode(heard.data)
        return Change(beat.sender, is_heartbeat=True) if isinstance(beat, Heartbeat) else None
    id = robot_of(heard.topic)
    if id is None:
        return None
    if not heard.data:
        return Change(id, is_gone=True) if known.pop(id, None) is not None else None
    robot = parse_entry(id, heard.data)
    before = known.get(id)
    if robot is None or (before is None and len(known) >= MOST_ROBOTS):
        return None
    known[id] = robot
    is_news = before is None or (before.state, before.home) != (robot.state, robot.home)
    return Change(id, robot) if is_news else None


async def _forward(source: Subscription, queue: asyncio.Queue[Message | BaseException]) -> None:
    """What comes in, and in the end why nothing comes any more."""
    try:
        while True:
            await queue.put(await source.__anext__())
    except asyncio.CancelledError:
        raise
    except Exception as end:
        await queue.put(end)
