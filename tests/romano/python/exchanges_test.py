"""MQTT-SN 1.2 sections 6.4 to 6.10: register, publish, subscribe, receive."""

import unittest

from chart import Chart
from romano import InvalidTopic, PredefinedTopic, QueueFull, ShortTopic, TooLong, Will
from romano.core.events import Done, Failed, Received
from romano.core.timing import Limits
from romano.mqttsn import messages as m
from romano.mqttsn.types import Qos


class Connected(Chart):
    def setUp(self) -> None:
        super().setUp()
        self.connect()

    def sent_id(self) -> int:
        """The message id of the one message that was sent."""
        return self.sent_one().msg_id  # type: ignore[attr-defined, no-any-return]

    def register(self, name: str, topic_id: int) -> None:
        self.core.register(self.now, name)
        self.hears(m.Regack(topic_id, self.sent_id(), 0))
        self.events()


class Publishing(Connected):
    def test_a_name_is_registered_first_and_once(self) -> None:
        operation = self.core.publish(self.now, "a/b", b"x", qos=1)
        register = self.sent_one()
        assert isinstance(register, m.Register)
        self.assertEqual((register.topic_id, register.topic_name), (0, b"a/b"))
        self.hears(m.Regack(9, register.msg_id, 0))
        publish = self.sent_one()
        assert isinstance(publish, m.Publish)
        self.assertEqual((publish.flags, publish.topic_id, publish.data), (0x20, 9, b"x"))
        self.hears(m.Puback(9, publish.msg_id, 0))
        self.assertEqual(self.events(), [Done(operation)])
        self.core.publish(self.now, "a/b", b"y", qos=1)
        self.assertIsInstance(self.sent_one(), m.Publish)

    def test_qos_1_is_repeated_with_dup_under_its_message_id(self) -> None:
        self.register("a", 1)
        self.core.publish(self.now, "a", b"x", qos=1, retain=True)
        msg_id = self.sent_id()
        self.runs(10)
        self.assertEqual(self.sent(), [m.Publish(0xB0, 1, msg_id, b"x")])

    def test_qos_2_is_pubrec_pubrel_pubcomp(self) -> None:
        self.register("a", 1)
        operation = self.core.publish(self.now, "a", b"x", qos=2)
        msg_id = self.sent_id()
        self.hears(m.Puback(1, msg_id, 0))  # never belongs to QoS 2 (6.6a)
        self.assertEqual(self.sent(), [])
        for _ in range(2):
            self.hears(m.Pubrec(msg_id))
            self.assertEqual(self.sent(), [m.Pubrel(msg_id)])
        self.runs(10)
        self.assertEqual(self.sent(), [m.Pubrel(msg_id)])
        self.assertEqual(self.events(), [])
        self.hears(m.Pubcomp(msg_id))
        self.assertEqual(self.events(), [Done(operation)])

    def test_qos_0_goes_between_the_messages_of_an_open_exchange(self) -> None:
        self.register("a", 1)
        self.core.publish(self.now, "a", b"1", qos=1)
        self.sent()
        operation = self.core.publish(self.now, "a", b"0")
        self.assertEqual(self.sent(), [m.Publish(0, 1, 0, b"0")])
        self.assertEqual(self.events(), [Done(operation)])

    def test_qos_0_stays_behind_qos_0_that_waits_for_an_id(self) -> None:
        self.register("a", 1)
        self.core.publish(self.now, "b", b"first")
        register = self.sent_id()
        self.core.publish(self.now, "a", b"second")
        self.assertEqual(self.sent(), [])
        self.hears(m.Regack(2, register, 0))
        self.assertEqual(self.sent(), [m.Publish(0, 2, 0, b"first"), m.Publish(0, 1, 0, b"second")])

    def test_one_exchange_is_open_at_a_time(self) -> None:
        self.register("a", 1)
        for data in (b"1", b"2"):
            self.core.publish(self.now, "a", data, qos=1)
        self.hears(m.Puback(1, self.sent_id(), 0))
        self.assertEqual(self.sent_one().data, b"2")  # type: ignore[attr-defined]

    def test_an_unknown_id_is_registered_anew_once(self) -> None:
        self.register("a", 1)
        operation = self.core.publish(self.now, "a", b"x", qos=1)
        self.hears(m.Puback(1, self.sent_id(), 2))
        self.hears(m.Regack(7, self.sent_id(), 0))
        publish = self.sent_one()
        assert isinstance(publish, m.Publish)
        self.assertEqual((publish.flags, publish.topic_id), (0x20, 7))
        self.hears(m.Puback(7, publish.msg_id, 2))
        self.assertEqual(self.events(), [Failed(operation, 2)])

    def test_puback_2_at_qos_0_makes_the_next_one_register(self) -> None:
        self.register("a", 1)
        self.core.publish(self.now, "a", b"x")
        self.sent()
        self.hears(m.Puback(1, 0, 2))
        self.core.publish(self.now, "a", b"y")
        self.assertIsInstance(self.sent_one(), m.Register)

    def test_congestion_is_told_and_nothing_is_asked_for_t_wait(self) -> None:
        self.register("a", 1)
        first = self.core.publish(self.now, "a", b"1", qos=1)
        second = self.core.publish(self.now, "a", b"2", qos=1)
        self.hears(m.Puback(1, self.sent_id(), 1))
        self.assertEqual(self.events(), [Failed(first, 1), Failed(second, 1)])
        self.assertEqual(self.core.paused_for(self.now), 300)
        third = self.core.publish(self.now, "a", b"3")
        self.assertEqual((self.sent(), self.events()), ([], [Failed(third, 1)]))
        self.now += 300
        self.core.publish(self.now, "a", b"4")
        self.assertEqual(self.sent(), [m.Publish(0, 1, 0, b"4")])

    def test_short_and_predefined_topics_need_no_register(self) -> None:
        self.core.publish(self.now, ShortTopic("ab"), b"x")
        self.core.publish(self.now, PredefinedTopic(5), b"x")
        self.assertEqual(self.sent(), [m.Publish(0x02, 0x6162, 0, b"x"), m.Publish(0x01, 5, 0, b"x")])

    def test_qos_minus_1_needs_no_connection_but_a_topic_without_register(self) -> None:
        self.core.disconnect(self.now)
        self.sent()
        self.hears(m.Disconnect())
        self.core.publish(self.now, PredefinedTopic(5), b"x", qos=-1)
        self.assertEqual(self.sent(), [m.Publish(0x61, 5, 0, b"x")])
        with self.assertRaises(InvalidTopic):
            self.core.publish(self.now, "a", b"x", qos=-1)

    def test_a_name_whose_id_the_broker_gave_away_is_registered_again(self) -> None:
        self.register("a", 1)
        self.hears(m.Register(1, 1, b"b"))
        self.sent()
        self.core.publish(self.now, "a", b"x")
        self.assertIsInstance(self.sent_one(), m.Register)

    def test_a_cancelled_qos_0_message_holds_nobody_up(self) -> None:
        self.register("a", 1)
        self.core.publish(self.now, "a", b"1", qos=1)
        self.assertTrue(self.core.cancel(self.core.publish(self.now, "b", b"waits for an id")))
        self.sent()
        self.core.publish(self.now, "a", b"0")
        self.assertEqual(self.sent(), [m.Publish(0, 1, 0, b"0")])

    def test_what_cannot_be_said_is_refused_at_once(self) -> None:
        with self.assertRaises(InvalidTopic):
            self.core.publish(self.now, "a/+", b"x")
        with self.assertRaises(ValueError):
            self.core.publish(self.now, "a", b"x", qos=3)
        for topic, data in (("a", bytes(65499)), ("a" * 65502, b"")):
            with self.assertRaises(TooLong):
                self.core.publish(self.now, topic, data, qos=1)
        self.assertEqual(self.sent(), [])

    def test_an_operation_that_was_not_begun_can_be_cancelled(self) -> None:
        self.register("a", 1)
        begun = self.core.publish(self.now, "a", b"1", qos=1)
        waiting = self.core.publish(self.now, "a", b"2", qos=1)
        self.assertTrue(self.core.cancel(waiting))
        self.assertFalse(self.core.cancel(begun))
        self.hears(m.Puback(1, self.sent_id(), 0))
        self.assertEqual(self.sent(), [])


class Bounds(Connected):
    limits = Limits(operations=2, topics=2, subscriptions=1, unreleased=2)

    def test_requests_beyond_the_limit_are_refused(self) -> None:
        for _ in range(2):
            self.core.publish(self.now, "a", b"x", qos=1)
        with self.assertRaises(QueueFull):
            self.core.publish(self.now, "a", b"x", qos=1)

    def test_subscriptions_beyond_the_limit_are_refused(self) -> None:
        self.core.subscribe(self.now, "a/+")
        self.hears(m.Suback(0, 0, self.sent_id(), 0))
        with self.assertRaises(QueueFull):
            self.core.subscribe(self.now, "b/+")

    def test_topic_ids_beyond_the_limit_are_refused_either_way(self) -> None:
        self.register("a", 1)
        self.hears(m.Register(2, 7, b"b"))
        self.assertEqual(self.sent(), [m.Regack(2, 7, 0)])
        self.hears(m.Register(3, 8, b"c"))
        self.assertEqual(self.sent(), [m.Regack(3, 8, 1)])
        operation = self.core.publish(self.now, "d", b"x", qos=1)
        self.assertEqual((self.sent(), self.events()), ([], [Failed(operation, 1)]))
        self.hears(m.Register(2, 9, b"other"))  # in the place of b
        self.assertEqual(self.sent(), [m.Regack(2, 9, 0)])

    def test_the_oldest_unreleased_message_is_forgotten(self) -> None:
        self.register("a", 1)
        for msg_id in (1, 2, 3, 3, 1):
            self.hears(m.Publish(0x40, 1, msg_id, b"x"))
        self.assertEqual([e.msg_id for e in self.events() if isinstance(e, Received)], [1, 2, 3, 1])


class Subscribing(Connected):
    def test_a_name_gets_an_id_and_messages_on_it_are_told_by_name(self) -> None:
        operation = self.core.subscribe(self.now, "a", 2)
        request = self.sent_one()
        assert isinstance(request, m.Subscribe)
        self.assertEqual((request.flags, request.topic), (0x40, b"a"))
        self.hears(m.Suback(0x20, 4, request.msg_id, 0))
        self.assertEqual(self.events(), [Done(operation, 4, Qos.AT_LEAST_ONCE)])
        self.hears(m.Publish(0x10, 4, 0, b"x"))
        (received,) = self.events()
        assert isinstance(received, Received)
        self.assertEqual((received.topic, received.data, received.retain), ("a", b"x", True))

    def test_it_is_repeated_with_dup(self) -> None:
        self.core.subscribe(self.now, "a/+", 1)
        msg_id = self.sent_id()
        self.runs(10)
        self.assertEqual(self.sent(), [m.Subscribe(0xA0, msg_id, b"a/+")])

    def test_refusals_are_told_with_their_codes(self) -> None:
        for code in (1, 2, 3, 77):
            with self.subTest(code):
                self.setUp()
                operation = self.core.subscribe(self.now, PredefinedTopic(5))
                self.hears(m.Suback(0, 0, self.sent_id(), code))
                self.assertEqual(self.events(), [Failed(operation, code)])

    def test_unsubscribe(self) -> None:
        operation = self.core.unsubscribe(self.now, ShortTopic("ab"))
        request = self.sent_one()
        assert isinstance(request, m.Unsubscribe)
        self.assertEqual((request.flags, request.topic), (0x02, b"ab"))
        self.hears(m.Unsuback(request.msg_id))
        self.assertEqual(self.events(), [Done(operation)])

    def test_answers_that_nobody_waits_for_are_dropped_and_counted(self) -> None:
        self.core.subscribe(self.now, "a/+")
        msg_id = self.sent_id()
        for answer in (m.Suback(0, 0, msg_id + 1, 0), m.Unsuback(msg_id), m.Puback(0, msg_id, 0), m.Pubcomp(msg_id),
                       m.Regack(1, msg_id, 0), m.Connack(0), m.Willtopicreq(), m.Subscribe(0, 1, b"x")):  # fmt: skip
            self.hears(answer)
        self.assertEqual((self.core.drops["unexpected"], self.events(), self.sent()), (8, [], []))


class Receiving(Connected):
    def setUp(self) -> None:
        super().setUp()
        self.hears(m.Register(5, 1, "röm/a".encode()))
        self.assertEqual(self.sent(), [m.Regack(5, 1, 0)])

    def received(self) -> list[bytes]:
        return [e.data for e in self.events() if isinstance(e, Received)]

    def test_register_in_the_middle_of_an_own_exchange(self) -> None:
        self.core.subscribe(self.now, "a/+")
        msg_id = self.sent_id()
        self.hears(m.Register(6, msg_id, b"a/x"))  # the two sides number their requests each by itself
        self.assertEqual(self.sent(), [m.Regack(6, msg_id, 0)])
        self.hears(m.Suback(0, 0, msg_id, 0))
        self.assertIsInstance(self.events()[-1], Done)

    def test_each_qos_has_its_answer(self) -> None:
        for flags, answer in ((0x00, []), (0x20, [m.Puback(5, 3, 0)]), (0x40, [m.Pubrec(3)])):
            self.hears(m.Publish(flags, 5, 3, b"x"))
            self.assertEqual(self.sent(), answer)
        self.assertEqual(self.received(), [b"x"] * 3)

    def test_a_qos_2_message_comes_once_until_it_is_released(self) -> None:
        for flags in (0x40, 0x40, 0xC0):  # repeated by the network, and by the broker
            self.hears(m.Publish(flags, 5, 3, b"x"))
        self.assertEqual(self.sent(), [m.Pubrec(3)] * 3)
        for _ in range(2):  # PUBCOMP was lost
            self.hears(m.Pubrel(3))
        self.assertEqual(self.sent(), [m.Pubcomp(3)] * 2)
        self.hears(m.Publish(0x40, 5, 3, b"y"))
        self.assertEqual(self.received(), [b"x", b"y"])

    def test_unknown_ids_are_told_at_qos_0_too(self) -> None:
        self.hears(m.Publish(0, 99, 0, b"x"))
        self.assertEqual(self.sent(), [m.Puback(99, 0, 2)])
        self.hears(m.Publish(0x23, 5, 1, b"x"))  # the reserved kind of topic
        self.assertEqual(self.sent(), [m.Puback(5, 1, 3)])
        self.assertEqual(self.received(), [])

    def test_short_names_come_as_names_and_predefined_ids_as_such(self) -> None:
        self.hears(m.Publish(0x02, 0x6162, 0, b"x"))
        self.hears(m.Publish(0x01, 7, 0, b"x"))
        self.assertEqual([e.topic for e in self.events() if isinstance(e, Received)], ["ab", PredefinedTopic(7)])

    def test_names_that_are_none_are_refused(self) -> None:
        for message, code in ((m.Register(0, 1, b"a"), 2), (m.Register(0xFFFF, 1, b"a"), 2), (m.Register(1, 1, b""), 3),
                              (m.Register(1, 1, b"\xff"), 3), (m.Register(1, 1, b"a/#"), 3)):  # fmt: skip
            self.hears(message)
            self.assertEqual(self.sent(), [m.Regack(message.topic_id, 1, code)])


class Declining(Receiving):
    """The application has no room."""

    has_room = False

    def on_received(self, received: Received) -> None:
        if self.has_room:
            self.core.accept(received)
        else:
            self.core.decline(received)

    test_each_qos_has_its_answer = None  # type: ignore[assignment]
    test_a_qos_2_message_comes_once_until_it_is_released = None  # type: ignore[assignment]

    def test_what_is_not_accepted_is_not_acknowledged_and_taken_when_it_comes_again(self) -> None:
        for flags in (0x20, 0x40):
            self.has_room = False
            self.hears(m.Publish(flags, 5, 3, b"x"))
            self.assertEqual(self.sent(), [])
            self.has_room = True
            self.hears(m.Publish(flags | 0x80, 5, 3, b"x"))
            self.assertEqual(len(self.sent()), 1)
        self.assertEqual(self.core.drops["no_room"], 2)


class WillUpdates(Connected):
    def test_message_and_topic_are_replaced_one_after_the_other(self) -> None:
        operations = self.core.update_will(self.now, Will("w", b"bye", qos=1))
        self.assertEqual(self.sent(), [m.Willmsgupd(b"bye")])
        self.hears(m.Willmsgresp(0))
        self.assertEqual(self.sent(), [m.Willtopicupd(0x20, b"w")])
        self.hears(m.Willtopicresp(0))
        self.assertEqual(self.events(), [Done(operation) for operation in operations])

    def test_an_empty_topic_deletes_it(self) -> None:
        self.core.update_will(self.now, None)
        self.assertEqual(self.sent(), [m.Willtopicupd(0, b"")])


if __name__ == "__main__":
    unittest.main()
