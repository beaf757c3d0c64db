"""A client core against a scripted broker: tests read like a sequence chart."""

import unittest

from romano.core.client import ClientCore
from romano.core.connection import ConnectOptions
from romano.core.events import Event, Received, Send
from romano.core.timing import Limits, Timing
from romano.mqttsn.codec import decode, encode
from romano.mqttsn.messages import Connack, Message


class Chart(unittest.TestCase):
    """``self.core`` at ``self.now``; what it sent and told since the last look."""

    timing = Timing(t_retry=10, n_retry=3, t_wait=300, reconnect_most=30)
    limits = Limits()

    def setUp(self) -> None:
        self.core = ClientCore(self.timing, self.limits, seed=1)
        self.now = 1000.0
        self.told: list[Event] = []
        self._sent: list[Message] = []

    def connect(self, **options: object) -> None:
        self.core.connect(self.now, ConnectOptions("me", **options))  # type: ignore[arg-type]
        self.sent()
        self.hears(Connack(0))
        self.events()

    def look(self) -> None:
        for action in self.core.take_actions():
            if isinstance(action, Send):
                message = decode(action.datagram)
                assert isinstance(message, Message), action
                self._sent.append(message)
            else:
                self.told.append(action)
                if isinstance(action, Received):
                    self.on_received(action)

    def on_received(self, received: Received) -> None:
        self.core.accept(received)

    def sent(self) -> list[Message]:
        self.look()
        self.look()  # what accept() sends
        sent, self._sent = self._sent, []
        return sent

    def sent_one(self) -> Message:
        (message,) = self.sent()
        return message

    def events(self) -> list[Event]:
        self.look()
        told, self.told = self.told, []
        return told

    def hears(self, message: Message | bytes) -> None:
        self.core.on_datagram(self.now, message if isinstance(message, bytes) else encode(message))
        self.look()

    def runs(self, seconds: float) -> None:
        """Ticks when the core wants them, until so much later."""
        end = self.now + seconds
        while (wakeup := self.core.next_wakeup()) <= end:
            self.now = max(self.now, wakeup)
            self.core.on_tick(self.now)
            self.look()
        self.now = end
