"""Whatever the network sends is dropped and counted: nothing raises, nothing grows without end."""

import random
import unittest

from chart import Chart
from romano import State
from romano.core.connection import ConnectOptions
from romano.core.events import Received
from romano.core.timing import Limits
from romano.mqttsn import messages as m
from romano.mqttsn.codec import encode
from romano.mqttsn.types import MsgType

DATAGRAMS = 50_000


class Hostile(Chart):
    limits = Limits(operations=20, topics=50, subscriptions=10, unreleased=10)

    def setUp(self) -> None:
        super().setUp()
        self.source = random.Random(34)

    def any_datagram(self) -> bytes:
        """Noise, a frame around noise, or a message with small numbers, which meets what the client waits for."""
        source = self.source
        kind = source.random()
        if kind < 0.2:
            return source.randbytes(source.randrange(40))
        body = source.randbytes(source.randrange(16))
        if kind < 0.8:
            body = bytes(source.choice((0, 0, 0, 1, 2, 3, 0x20, 0x40, 0xFF)) for _ in range(source.randrange(10)))
        type = source.choice(list(MsgType))
        if source.random() < 0.1:
            return b"\x01" + (len(body) + 4).to_bytes(2, "big") + bytes((type,)) + body
        return bytes((len(body) + 2, type)) + body

    def test_tens_of_thousands_of_datagrams_in_every_state(self) -> None:
        accepted = 0
        states = set()
        for at in range(DATAGRAMS):
            if at % 50 == 0 or self.core.state is State.DISCONNECTED:
                self.core.connect(self.now, ConnectOptions("me", clean_session=at % 100 == 0))
                if at % 7:
                    self.hears(m.Connack(0))
            self.ask_something()
            self.hears(self.any_datagram())
            self.sent()
            accepted += sum(isinstance(event, Received) for event in self.events())
            states.add(self.core.state)
            self.runs(self.source.choice((0, 0, 0, 0.1, 20)))
        self.assertGreaterEqual(len(states), 6)
        self.assertGreater(accepted, 10)
        self.assertGreater(sum(self.core.drops.values()), DATAGRAMS / 4)
        self.assertLessEqual(len(self.core._topics), self.limits.topics)
        self.assertLessEqual(len(self.core._receiver._unreleased), self.limits.unreleased)
        self.assertLessEqual(len(self.core._requests._queue), self.limits.operations + self.limits.subscriptions)

    def ask_something(self) -> None:
        calls = [
            lambda: self.core.publish(self.now, "a", b"x", self.source.randrange(3)),
            lambda: self.core.subscribe(self.now, self.source.choice(("a", "b/+")), 2),
            lambda: self.core.unsubscribe(self.now, "a"),
            lambda: self.core.sleep(self.now, 30),
            lambda: self.core.collect(self.now),
            lambda: self.core.wake_up(self.now),
            lambda: self.core.disconnect(self.now),
        ]
        weights = [20, 5, 5, 1, 1, 1, 0.2]
        if self.source.random() < 0.3:
            try:
                self.source.choices(calls, weights)[0]()
            except Exception as refused:
                self.assertTrue(type(refused).__module__.startswith("romano"), repr(refused))

    def test_every_octet_of_every_message_changed(self) -> None:
        for message in (
            m.Register(3, 1, b"a"),
            m.Publish(0x40, 3, 1, b"x"),
            m.Suback(0, 3, 1, 0),
            m.Connack(0),
            m.Disconnect(),
        ):
            for at in range(len(encode(message))):
                for octet in range(256):
                    if self.core.state is not State.CONNECTED:
                        self.connect()
                    changed = bytearray(encode(message))
                    changed[at] = octet
                    self.hears(bytes(changed))
                    self.sent()


if __name__ == "__main__":
    unittest.main()
