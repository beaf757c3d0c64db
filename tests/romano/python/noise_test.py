"""The asyncio shell against a broker that is hostile: noise, floods, answers twice."""

import asyncio
import random
import unittest
from typing import cast

from programs import QUICK
from romano import Client, State
from romano.mqttsn import messages as m
from romano.mqttsn.codec import Malformed, decode, encode
from romano.mqttsn.types import MsgType

DATAGRAMS = 20_000
AT_ONCE = 50
"""Datagrams that a socket's buffer is sure to hold."""


class HostileBroker(asyncio.DatagramProtocol):
    """Takes everybody in, acknowledges everything, and says each thing twice."""

    def __init__(self) -> None:
        self.client: tuple[str, int] | None = None
        self.heard: list[m.Message] = []

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(asyncio.DatagramTransport, transport)

    def say(self, message: m.Message | bytes, times: int = 2) -> None:
        for _ in range(times):
            self.transport.sendto(message if isinstance(message, bytes) else encode(message), self.client)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        self.client = addr
        message = decode(data)
        assert not isinstance(message, Malformed), data
        self.heard.append(message)
        if isinstance(message, m.Connect):
            self.say(m.Connack(0))
        elif isinstance(message, m.Subscribe):
            self.say(m.Suback(0x40, 1, message.msg_id, 0))
        elif isinstance(message, m.Register):
            self.say(m.Regack(2, message.msg_id, 0))
        elif isinstance(message, m.Publish):
            self.say(m.Puback(message.topic_id, message.msg_id, 0))
        elif isinstance(message, m.Disconnect):
            self.say(m.Disconnect())


class Noise(unittest.IsolatedAsyncioTestCase):
    async def asyncSetUp(self) -> None:
        self.complaints: list[dict[str, object]] = []
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(lambda _, context: self.complaints.append(context))
        transport, self.broker = await loop.create_datagram_endpoint(HostileBroker, local_addr=("127.0.0.1", 0))
        self.addCleanup(transport.close)
        self.client = Client("127.0.0.1", transport.get_extra_info("sockname")[1], timing=QUICK)
        await self.client.connect()
        self.addAsyncCleanup(self.client.disconnect)

    async def asyncTearDown(self) -> None:
        self.assertEqual(self.complaints, [], "exceptions out of the loop")

    async def works(self) -> None:
        async with asyncio.timeout(30):
            await self.client.publish("a", "x", qos=1)

    async def test_a_flood_of_noise_between_two_messages(self) -> None:
        source = random.Random(34)
        types = [type for type in MsgType if type is not MsgType.DISCONNECT]
        for at in range(DATAGRAMS):
            body = source.randbytes(source.randrange(12))
            framed = bytes((len(body) + 2, source.choice(types))) + body
            self.broker.say(source.choice((framed, body, framed[:-1] or b"\0")), times=1)
            if at % AT_ONCE == 0:
                await self.works()
        await self.works()
        self.assertGreater(sum(self.client.drops.values()), DATAGRAMS / 10)
        self.assertEqual(self.client.interruptions, 0)

    async def test_qos_2_said_twice_arrives_once(self) -> None:
        heard = await self.client.subscribe("a", qos=2)
        for msg_id in range(1, 101):
            self.broker.say(m.Publish(0x40, 1, msg_id, b"%d" % msg_id))
            self.broker.say(m.Pubrel(msg_id))
            if msg_id % 10 == 0:
                await self.works()
        self.assertEqual([int(message.text) for message in heard.drain()], list(range(1, 101)))
        self.assertEqual(sum(isinstance(message, m.Pubcomp) for message in self.broker.heard), 200)

    async def test_a_broker_that_throws_it_out_again_and_again(self) -> None:
        loop = asyncio.get_running_loop()
        begin = loop.time()
        for _ in range(100):
            self.broker.say(m.Disconnect())
            await asyncio.sleep(0.002)
        while self.client.state is not State.CONNECTED:
            await asyncio.sleep(0.01)
        connects = sum(isinstance(message, m.Connect) for message in self.broker.heard)
        pause = QUICK.reconnect_most / 2  # at least, but for the first
        self.assertLessEqual(connects, 3 + (loop.time() - begin) / pause)
        await self.works()

    async def test_a_flood_of_messages_that_nobody_reads_takes_no_more_memory_than_its_queue(self) -> None:
        heard = await self.client.subscribe("a", qos=2, room=100)
        for at in range(5000):
            self.broker.say(m.Publish(0x00, 1, 0, bytes(100)), times=1)
            if at % AT_ONCE == 0:
                await self.works()
        self.assertEqual(len(heard.drain()), 100)
        self.assertGreater(heard.dropped, 1000)


if __name__ == "__main__":
    unittest.main()
