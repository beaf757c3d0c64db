"""The client and a real romano-broker."""

import asyncio
import socket
import unittest
import unittest.mock

from programs import BROKER, QUICK, Broker, Program, free_port

from romano import (
    Client, Congestion, ConnectionLost, InvalidTopicId, Message, NotConnected, PredefinedTopic, ShortTopic, State,
    Subscription, Timing, TooLong, Will, find_brokers,
)  # fmt: skip

PATIENCE = 30.0


async def texts(subscription: Subscription, count: int) -> list[str]:
    return [(await subscription.get(PATIENCE)).text for _ in range(count)]


class WithBroker(unittest.IsolatedAsyncioTestCase):
    options: tuple[str, ...] = ()

    async def asyncSetUp(self) -> None:
        self.complaints: list[dict[str, object]] = []
        asyncio.get_running_loop().set_exception_handler(lambda _, context: self.complaints.append(context))
        self.broker = Broker(*self.options)
        self.addAsyncCleanup(self.broker.kill)
        await self.broker.start()

    async def asyncTearDown(self) -> None:
        self.assertEqual(self.complaints, [], "exceptions out of the loop")

    async def client(self, **options: object) -> Client:
        client = self.broker.client(**options)
        await client.connect()
        self.addAsyncCleanup(client.disconnect)
        return client


class Messages(WithBroker):
    options = ("--predefined", "5=robots/stop")

    async def test_each_qos_both_ways(self) -> None:
        alice, bob = await self.client(), await self.client()
        heard = await bob.subscribe("robots/+/pose", qos=2)
        self.assertEqual(heard.granted, 2)
        for qos in (0, 1, 2):
            await alice.publish("robots/r1/pose", f"qos {qos}", qos=qos)
        self.assertEqual(await texts(heard, 3), ["qos 0", "qos 1", "qos 2"])

    async def test_retained_messages_come_with_a_new_subscription_also_to_a_wildcard(self) -> None:
        alice = await self.client()
        await alice.publish("room/a", "kept", qos=1, retain=True)
        async with await alice.subscribe("room/+") as heard:
            self.assertEqual(await heard.get(PATIENCE), Message("room/a", b"kept", qos=1, retain=True))
        await alice.publish("room/a", "", qos=1, retain=True)
        again = await alice.subscribe("room/+")
        await alice.publish("room/b", "live", qos=1)
        self.assertEqual(await texts(again, 1), ["live"])

    async def test_short_and_predefined_topics_and_qos_minus_1(self) -> None:
        alice = await self.client()
        short, predefined = await alice.subscribe(ShortTopic("ab")), await alice.subscribe(PredefinedTopic(5))
        by_name = await (await self.client()).subscribe("robots/#")
        for qos in (-1, 0, 1):
            await alice.publish(ShortTopic("ab"), str(qos), qos=qos)
            await alice.publish(PredefinedTopic(5), str(qos), qos=qos)
        for heard in (short, predefined, by_name):
            self.assertEqual(await texts(heard, 3), ["-1", "0", "1"])
        with self.assertRaises(InvalidTopicId):
            await alice.publish(PredefinedTopic(6), qos=1)
        with self.assertRaises(InvalidTopicId):
            await alice.subscribe(PredefinedTopic(6))

    async def test_long_messages_in_the_three_octet_form(self) -> None:
        alice = await self.client()
        heard = await alice.subscribe("long", qos=2)
        for size in (247, 248, 249, 250, 1000, 65498):
            data = bytes(at % 251 for at in range(size))
            await alice.publish("long", data, qos=2)
            self.assertEqual((await heard.get(PATIENCE)).data, data)
        with self.assertRaises(TooLong):
            await alice.publish("long", bytes(65499), qos=2)

    async def test_two_subscriptions_that_match_get_a_message_each_and_go_one_by_one(self) -> None:
        alice = await self.client()
        first, second, wide = [await alice.subscribe(topic) for topic in ("a/b", "a/b", "a/#")]
        await alice.publish("a/b", "1", qos=1)
        self.assertEqual(await texts(first, 1), ["1"])
        await first.unsubscribe()
        await alice.publish("a/b", "2", qos=1)
        self.assertEqual(await texts(second, 2), ["1", "2"])
        self.assertEqual(await texts(wide, 2), ["1", "2"])
        self.assertEqual(first.drain(), [])

    async def test_a_reader_without_room_loses_qos_0_and_gets_qos_1_later(self) -> None:
        await self.broker.kill()
        self.broker = Broker("--retry-ms", "200", "--max-pacing-ms", "0")
        self.addAsyncCleanup(self.broker.kill)
        await self.broker.start()
        alice, slow = await self.client(), await self.client()
        heard = await slow.subscribe("flow", qos=1, room=2)
        for at in range(6):
            await alice.publish("flow", str(at), qos=1)
        while len(heard._messages) < 2 or not slow.drops["no_room"]:
            await asyncio.sleep(0.01)
        await alice.publish("flow", "zero", qos=0)
        while not heard.dropped:
            await asyncio.sleep(0.01)
        self.assertEqual(await texts(heard, 6), [str(at) for at in range(6)])

    async def test_a_thousand_messages_at_once_keep_their_order(self) -> None:
        alice, bob = await self.client(), await self.client()
        heard = await bob.subscribe("many", qos=2)
        await asyncio.gather(*(alice.publish("many", str(at), qos=1) for at in range(900)))
        self.assertEqual(await texts(heard, 900), [str(at) for at in range(900)])


class Sessions(WithBroker):
    async def test_a_name_with_several_addresses_is_tried_at_each(self) -> None:
        # As "localhost" has them: ::1 and 127.0.0.1.
        found = [
            (socket.AF_INET, socket.SOCK_DGRAM, 17, "", (host, self.broker.port))
            for host in ("127.77.0.9", "127.0.0.1")
        ]
        with unittest.mock.patch("socket.getaddrinfo", return_value=found):
            client = await self.client()
        await client.publish("a", "x", qos=1)

    async def test_the_will_of_a_client_that_vanishes_is_published_and_that_of_one_that_says_goodbye_is_not(
        self,
    ) -> None:
        heard = await (await self.client()).subscribe("gone")
        polite = await self.client(will=Will("gone", b"polite", qos=1), keep_alive_s=1)
        await polite.disconnect()
        lost = await self.client(will=Will("gone", b"first", qos=1), keep_alive_s=1)
        await lost.update_will(Will("gone", b"lost", qos=1))
        lost._close(None)  # as kill -9 does
        self.assertEqual(await texts(heard, 1), ["lost"])

    async def test_a_kept_session_has_its_messages_before_the_program_asks_for_them(self) -> None:
        sleeper = self.broker.client(client_id="kept", clean_session=False)
        await sleeper.connect()
        await sleeper.subscribe("mail", qos=1)
        await sleeper.disconnect()
        await (await self.client()).publish("mail", "while away", qos=1)
        back = await self.client(client_id="kept", clean_session=False)
        await back.publish("other", "x", qos=1)  # by now it has come
        self.assertEqual(await texts(await back.subscribe("mail"), 1), ["while away"])

    async def test_a_sleeper_collects_what_came_meanwhile(self) -> None:
        sleeper, alice = await self.client(), await self.client()
        heard = await sleeper.subscribe("mail", qos=1)
        await sleeper.sleep(60)
        self.assertIs(sleeper.state, State.ASLEEP)
        await alice.publish("mail", "1", qos=1)
        self.assertEqual(heard.drain(), [])
        await sleeper.collect()
        self.assertEqual([message.text for message in heard.drain()], ["1"])
        await sleeper.wake_up()
        await alice.publish("mail", "2", qos=1)
        self.assertEqual(await texts(heard, 1), ["2"])

    async def test_keep_alive_keeps_a_silent_session(self) -> None:
        heard = await (await self.client(keep_alive_s=2)).subscribe("a")
        await asyncio.sleep(5)  # the broker gives a silent client up after 3 s
        await (await self.client()).publish("a", "still here", qos=1)
        self.assertEqual(await texts(heard, 1), ["still here"])

    async def test_what_waits_fails_when_the_program_leaves(self) -> None:
        alice = await self.client()
        heard = await alice.subscribe("a")
        await self.broker.kill()
        waiting = asyncio.create_task(alice.publish("a", "x", qos=1))
        await asyncio.sleep(0)
        await alice.disconnect(patience_s=0.1)
        with self.assertRaises(NotConnected):
            await waiting
        with self.assertRaises(StopAsyncIteration):
            await heard.__anext__()
        with self.assertRaises(NotConnected):
            await alice.publish("a", "x")

    async def test_a_publish_that_nobody_waits_for_any_more_is_not_sent(self) -> None:
        alice = await self.client()
        heard = await alice.subscribe("a", qos=1)
        await alice.publish("a", "0", qos=1)
        first = asyncio.create_task(alice.publish("a", "1", qos=1))
        second = asyncio.create_task(alice.publish("a", "2", qos=1))
        await asyncio.sleep(0)
        second.cancel()
        await first
        await alice.publish("a", "3", qos=1)
        self.assertEqual(await texts(heard, 3), ["0", "1", "3"])


class Refusals(WithBroker):
    options = ("--max-sessions", "1", "--max-subscriptions", "1")

    async def test_congestion_is_an_exception_that_says_when_to_come_back(self) -> None:
        alice = await self.client()
        with self.assertRaises(Congestion):
            await self.broker.client().connect()
        await alice.subscribe("a")
        with self.assertRaises(Congestion) as refused:
            await alice.subscribe("b")
        self.assertTrue(0 < refused.exception.retry_after_s <= QUICK.t_wait, refused.exception)
        with self.assertRaises(Congestion):
            await alice.publish("a", "x")
        await asyncio.sleep(refused.exception.retry_after_s + 0.05)
        await alice.publish("a", "x", qos=1)

    async def test_nobody_listens_and_nobody_answers(self) -> None:
        await self.broker.kill()
        with self.assertRaisesRegex(NotConnected, "nobody listens there"):
            await self.broker.client().connect()
        silent, _ = await asyncio.get_running_loop().create_datagram_endpoint(
            asyncio.DatagramProtocol, local_addr=("127.0.0.1", self.broker.port)
        )
        self.addCleanup(silent.close)
        with self.assertRaisesRegex(ConnectionLost, "3 attempts"):
            await self.broker.client(timing=Timing(t_retry=0.05, n_retry=2)).connect()


class Crashes(WithBroker):
    async def test_kill_9_and_restart_are_an_interruption_and_nothing_else(self) -> None:
        alice, bob = await self.client(), await self.client(keep_alive_s=2)
        heard = await bob.subscribe("a/+", qos=2)
        await alice.publish("a/b", "before", qos=2)
        self.assertEqual(await texts(heard, 1), ["before"])
        await self.broker.kill()
        waiting = asyncio.create_task(alice.publish("a/b", "meanwhile", qos=2))
        await asyncio.sleep(0.2)
        self.assertFalse(waiting.done())
        await self.broker.start()
        async with asyncio.timeout(PATIENCE):
            await waiting
            while bob.interruptions == 0 or bob.state is not State.CONNECTED:
                await asyncio.sleep(0.01)
            await bob.register("a/b")  # behind the subscriptions that are made again
        heard.drain()
        await alice.publish("a/b", "after", qos=2)
        self.assertEqual(await texts(heard, 1), ["after"])
        self.assertEqual((alice.interruptions, bob.interruptions), (1, 1))

    async def test_without_reconnect_everything_ends_with_the_connection(self) -> None:
        alice = await self.client(reconnect=False, keep_alive_s=1, timing=Timing(t_retry=0.1, n_retry=2))
        heard = await alice.subscribe("a")
        await self.broker.kill()
        with self.assertRaises(ConnectionLost):
            await heard.get(PATIENCE)
        with self.assertRaises(NotConnected):
            await alice.publish("a", "x", qos=1)


class Searching(unittest.IsolatedAsyncioTestCase):
    async def test_a_broker_answers_a_search_in_its_group(self) -> None:
        broker = Broker("--discovery-group", "225.77.1.1:17883")
        self.addAsyncCleanup(broker.kill)
        await broker.start()
        found = await find_brokers(PATIENCE, local="127.0.0.1", group="225.77.1.1", port=17883, first=True)
        self.assertEqual([(gateway.host, gateway.port) for gateway in found], [(broker.host, broker.port)])

    async def test_an_address_of_one_network_is_found_and_reached_by_its_interface(self) -> None:
        with open("/proc/net/if_inet6") as interfaces:
            names = [line.split()[5] for line in interfaces if line.startswith("fe80")]
        if not names:
            self.skipTest("no interface here has a link-local address")
        port = free_port()
        broker = Program(
            BROKER, "--allow-plain", "--listen", f"[::]:{port}", "--discovery-group", f"[ff02::77:1]:{port}"
        )
        self.addAsyncCleanup(broker.kill)
        await broker.start()
        await broker.line("serving")
        found = await find_brokers(PATIENCE, local=names[0], group="ff02::77:1", port=port, first=True)
        self.assertRegex(found[0].host, f"^fe80::.*%{names[0]}$")
        async with Client(found[0].host, found[0].port, timing=QUICK) as client:
            await client.publish("a", "x", qos=1)

    async def test_where_nobody_is_nobody_is_found(self) -> None:
        self.assertEqual(await find_brokers(0.2, local="127.0.0.1", group="225.77.1.2", port=17884), [])
        with self.assertRaises(ValueError):
            await find_brokers(0.2, group="127.0.0.1")


if __name__ == "__main__":
    unittest.main()
