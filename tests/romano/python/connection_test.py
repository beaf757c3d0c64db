"""MQTT-SN 1.2 sections 6.2 (connect), 6.11 (keep-alive), 6.12 (disconnect), 6.13 (retransmission), 6.14 (sleep)."""

import unittest

from chart import Chart
from romano import NotConnected, PredefinedTopic, State, Will
from romano.core.connection import ConnectOptions
from romano.core.events import Asleep, Connected, Disconnected, Interrupted, Lost, Received, Refused, SubscriptionLost
from romano.mqttsn import messages as m


class Connecting(Chart):
    def test_without_a_will_connack_is_all(self) -> None:
        self.core.connect(self.now, ConnectOptions("me", keep_alive_s=30))
        self.assertEqual(self.sent(), [m.Connect(0x04, 1, 30, b"me")])
        self.hears(m.Connack(0))
        self.assertEqual(self.events(), [Connected()])
        self.assertIs(self.core.state, State.CONNECTED)

    def test_a_will_is_prompted_for_and_a_prompt_may_come_twice(self) -> None:
        will = Will("gone/me", b"bye", qos=1, retain=True)
        self.core.connect(self.now, ConnectOptions("me", will=will))
        self.assertEqual(self.sent(), [m.Connect(0x0C, 1, 60, b"me")])
        for _ in range(2):
            self.hears(m.Willtopicreq())
            self.assertEqual(self.sent(), [m.Willtopic(0x30, b"gone/me")])
        self.hears(m.Willmsgreq())
        self.assertEqual(self.sent(), [m.Willmsg(b"bye")])
        self.hears(m.Connack(0))
        self.assertEqual(self.events(), [Connected()])

    def test_each_step_is_repeated_n_retry_times_and_then_the_broker_is_lost(self) -> None:
        self.core.connect(self.now, ConnectOptions("me"))
        self.runs(9.9)
        self.assertEqual(len(self.sent()), 1)
        self.runs(30)
        self.assertEqual(self.sent(), [m.Connect(0x04, 1, 60, b"me")] * 3)
        self.assertEqual(self.events(), [])
        self.runs(0.2)
        self.assertEqual(self.events(), [Lost()])
        self.assertIs(self.core.state, State.DISCONNECTED)

    def test_a_refusal_is_told_with_its_code(self) -> None:
        self.core.connect(self.now, ConnectOptions("me"))
        self.hears(m.Connack(1))
        self.assertEqual(self.events(), [Refused(1)])

    def test_nothing_else_is_sent_before_connack(self) -> None:
        self.core.connect(self.now, ConnectOptions("me"))
        self.core.subscribe(self.now, "a")
        self.assertEqual(self.sent(), [m.Connect(0x04, 1, 60, b"me")])
        self.hears(m.Connack(0))
        self.assertIsInstance(self.sent_one(), m.Subscribe)

    def test_settings_that_the_wire_cannot_say_are_refused(self) -> None:
        for options in ({"client_id": ""}, {"client_id": "x" * 256}, {"client_id": "a", "keep_alive_s": 65536}):
            with self.assertRaises(ValueError):
                ConnectOptions(**options)  # type: ignore[arg-type]


class KeepAlive(Chart):
    def test_a_ping_is_due_after_three_quarters_of_the_period(self) -> None:
        self.connect(keep_alive_s=60)
        self.runs(44)
        self.assertEqual(self.sent(), [])
        self.runs(2)
        self.assertEqual(self.sent(), [m.Pingreq()])
        self.hears(m.Pingresp())
        self.runs(44)
        self.assertEqual(self.sent(), [])

    def test_an_answered_request_puts_it_off_and_qos_0_does_not(self) -> None:
        self.connect(keep_alive_s=60)
        self.core.register(self.now, "a")
        (register,) = self.sent()
        self.now += 40
        self.hears(m.Regack(1, register.msg_id, 0))  # type: ignore[attr-defined]
        self.runs(30)
        self.assertEqual(self.sent(), [])
        self.core.publish(self.now, "a", b"x")
        self.sent()
        self.runs(16)
        self.assertEqual(self.sent(), [m.Pingreq()])

    def test_the_brokers_ping_is_answered(self) -> None:
        self.connect()
        self.hears(m.Pingreq())
        self.assertEqual(self.sent(), [m.Pingresp()])

    def test_pings_without_answer_end_the_connection(self) -> None:
        self.connect(keep_alive_s=60, reconnect=False)
        self.runs(45 + 40 + 1)
        self.assertEqual(self.sent(), [m.Pingreq()] * 4)
        self.assertEqual(self.events(), [Lost()])

    def test_keep_alive_0_never_pings(self) -> None:
        self.connect(keep_alive_s=0)
        self.runs(100_000)
        self.assertEqual(self.sent(), [])


class Disconnecting(Chart):
    def test_it_is_over_when_the_broker_answers(self) -> None:
        self.connect()
        self.core.disconnect(self.now)
        self.assertEqual(self.sent(), [m.Disconnect()])
        self.hears(m.Disconnect())
        self.assertEqual(self.events(), [Disconnected(by_broker=False)])

    def test_it_is_over_also_when_nobody_answers(self) -> None:
        self.connect()
        self.core.disconnect(self.now)
        self.runs(41)
        self.assertEqual(self.events(), [Disconnected(by_broker=False)])

    def test_by_the_broker_it_is_an_end_only_without_reconnect(self) -> None:
        self.connect(reconnect=False)
        self.hears(m.Disconnect())
        self.assertEqual(self.events(), [Disconnected(by_broker=True)])


class Reconnecting(Chart):
    def subscribe(self, filter: str, code: int = 0) -> None:
        self.core.subscribe(self.now, filter, 1)
        (request,) = self.sent()
        self.hears(m.Suback(0x20, 0, request.msg_id, code))  # type: ignore[attr-defined]

    def test_the_session_goes_on_with_its_subscriptions(self) -> None:
        self.connect(clean_session=True)
        self.subscribe("a/+")
        self.subscribe("b/+")
        self.events()
        self.hears(m.Disconnect())
        self.runs(0)
        self.assertIsInstance(self.events()[0], Interrupted)
        self.assertEqual(self.sent(), [m.Connect(0, 1, 60, b"me")])  # CleanSession 0: nothing is to be lost
        self.hears(m.Connack(0))
        first = self.sent_one()
        assert isinstance(first, m.Subscribe)
        self.assertEqual(first.topic, b"a/+")
        self.hears(m.Suback(0x20, 0, first.msg_id, 0))
        second = self.sent_one()
        assert isinstance(second, m.Subscribe)
        self.assertEqual(second.topic, b"b/+")
        self.hears(m.Suback(0x20, 0, second.msg_id, 3))
        self.assertEqual(self.events()[-1], SubscriptionLost("b/+", 3))

    def test_what_was_unsubscribed_stays_so(self) -> None:
        self.connect()
        self.subscribe("a/+")
        self.core.unsubscribe(self.now, "a/+")
        (request,) = self.sent()
        self.hears(m.Unsuback(request.msg_id))  # type: ignore[attr-defined]
        self.hears(m.Disconnect())
        self.runs(0)
        self.sent()
        self.hears(m.Connack(0))
        self.assertEqual(self.sent(), [])

    def test_an_open_publish_goes_on_under_its_message_id_so_that_it_arrives_once(self) -> None:
        self.connect()
        self.core.register(self.now, "a")
        self.hears(m.Regack(1, self.sent_one().msg_id, 0))  # type: ignore[attr-defined]
        self.core.publish(self.now, "a", b"x", qos=2)
        publish = self.sent_one()
        assert isinstance(publish, m.Publish)
        self.runs(41)
        self.assertEqual([type(s) for s in self.sent()], [m.Publish] * 3 + [m.Connect])
        self.hears(m.Connack(0))
        self.assertEqual(self.sent(), [m.Publish(publish.flags | 0x80, 1, publish.msg_id, b"x")])

    def test_a_clean_session_begins_an_open_publish_anew(self) -> None:
        self.connect()
        self.core.publish(self.now, PredefinedTopic(5), b"x", qos=1)
        first = self.sent_one()
        assert isinstance(first, m.Publish)
        self.connect(clean_session=True)
        again = self.sent_one()
        assert isinstance(again, m.Publish)
        self.assertEqual((again.flags, again.msg_id != first.msg_id), (first.flags, True))

    def test_subscriptions_are_made_again_once_however_often_the_connection_is_lost(self) -> None:
        self.connect()
        self.subscribe("a/+")
        self.subscribe("b/+")
        for _ in range(3):
            self.hears(m.Disconnect())
            self.runs(2)
            self.sent()
            self.hears(m.Connack(0))
        filters = []
        while sent := self.sent():
            (request,) = sent
            assert isinstance(request, m.Subscribe)
            filters.append(request.topic)
            self.hears(m.Suback(0, 0, request.msg_id, 0))
        self.assertEqual(filters, [b"a/+", b"b/+"])

    def test_a_new_connection_ends_the_pause_of_the_last_one(self) -> None:
        self.connect()
        self.core.publish(self.now, PredefinedTopic(5), b"x", qos=1)
        publish = self.sent_one()
        self.hears(m.Puback(5, publish.msg_id, 1))  # type: ignore[attr-defined]
        self.hears(m.Disconnect())
        self.runs(0)
        self.sent()
        self.hears(m.Connack(0))
        self.assertEqual(self.core.paused_for(self.now), 0)

    def test_attempts_become_rarer_and_never_end(self) -> None:
        self.connect(keep_alive_s=0)
        self.hears(m.Disconnect())
        self.runs(3600)
        connects = self.sent()
        self.assertEqual(set(connects), {m.Connect(0, 1, 0, b"me")})
        self.assertTrue(3600 / 70 * 4 <= len(connects) <= 3600 / 40 * 4, len(connects))
        self.assertEqual([type(e) for e in self.events()], [Interrupted])

    def test_a_broker_that_takes_us_in_only_to_throw_us_out_is_not_asked_in_a_loop(self) -> None:
        self.connect()
        connects = 0
        for _ in range(600):  # a minute
            self.runs(0.1)
            connects += len([s for s in self.sent() if isinstance(s, m.Connect)])
            self.hears(m.Connack(0))
            self.hears(m.Disconnect())
        self.assertTrue(3 <= connects <= 10, connects)

    def test_after_congestion_it_waits_for_t_wait(self) -> None:
        self.connect()
        self.hears(m.Disconnect())
        self.runs(0)
        self.hears(m.Connack(1))
        self.sent()
        self.runs(299)
        self.assertEqual(self.sent(), [])
        self.runs(2)
        self.assertIsInstance(self.sent_one(), m.Connect)

    def test_topic_ids_of_a_broker_that_forgot_them_are_asked_for_again(self) -> None:
        self.connect()
        self.core.register(self.now, "a")
        self.hears(m.Regack(1, self.sent_one().msg_id, 0))  # type: ignore[attr-defined]
        self.hears(m.Disconnect())
        self.runs(0)
        self.sent()
        self.hears(m.Connack(0))
        self.core.publish(self.now, "a", b"x", qos=1)
        publish = self.sent_one()
        self.hears(m.Puback(1, publish.msg_id, 2))  # type: ignore[attr-defined]
        self.assertIsInstance(self.sent_one(), m.Register)


class Sleeping(Chart):
    def setUp(self) -> None:
        super().setUp()
        self.connect()
        self.core.sleep(self.now, 100)
        self.assertEqual(self.sent(), [m.Disconnect(100)])
        self.hears(m.Disconnect())
        self.assertEqual(self.events(), [Asleep()])

    def test_it_collects_its_messages_in_time_by_its_client_id(self) -> None:
        self.runs(74)
        self.assertEqual(self.sent(), [])
        self.runs(2)
        self.assertEqual(self.sent(), [m.Pingreq(b"me")])
        self.hears(m.Register(5, 1, b"a"))
        self.assertEqual(self.sent(), [m.Regack(5, 1, 0)])
        self.hears(m.Publish(0x20, 5, 2, b"x"))
        self.assertEqual(self.sent(), [m.Puback(5, 2, 0)])
        self.hears(m.Pingresp())
        self.assertEqual([type(e) for e in self.events()], [Received, Asleep])

    def test_whatever_comes_while_it_collects_puts_the_repetition_off(self) -> None:
        self.core.collect(self.now)
        self.sent()
        for _ in range(3):
            self.runs(9)
            self.hears(m.Publish(0x01, 5, 0, b"x"))
        self.assertEqual(self.sent(), [])

    def test_a_broker_that_does_not_answer_lets_it_sleep_on(self) -> None:
        self.core.collect(self.now)
        self.runs(41)
        self.assertEqual(self.sent(), [m.Pingreq(b"me")] * 4)
        self.assertEqual(self.events(), [Asleep()])

    def test_requests_wait_until_it_wakes_up_in_its_session(self) -> None:
        self.core.publish(self.now, "a", b"x", qos=1)
        self.assertEqual(self.sent(), [])
        self.core.wake_up(self.now)
        self.assertEqual(self.sent(), [m.Connect(0, 1, 60, b"me")])
        self.hears(m.Connack(0))
        self.assertIsInstance(self.sent_one(), m.Register)

    def test_qos_0_does_not_wait(self) -> None:
        with self.assertRaises(NotConnected):
            self.core.publish(self.now, "a", b"x")


if __name__ == "__main__":
    unittest.main()
