"""MQTT 3.1.1 section 4.7, to which MQTT-SN 1.2 section 6 leaves names and filters; and section 6.7."""

import unittest

from romano import InvalidTopic, PredefinedTopic, ShortTopic
from romano.mqttsn import topic as t
from romano.mqttsn.types import TopicIdType


class Topics(unittest.TestCase):
    def test_names_have_no_wildcard_and_no_nul(self) -> None:
        for name in ("a", "/", "a//b", "$SYS/x", "ä", " "):
            self.assertTrue(t.is_valid_name(name), name)
        for name in ("", "a/+", "#", "a+b", "\0", "\ud800"):
            self.assertFalse(t.is_valid_name(name), name)

    def test_wildcards_fill_their_level_and_the_hash_is_last(self) -> None:
        for filter in ("a", "+", "#", "a/#", "+/+", "a/+/b", "/#"):
            self.assertTrue(t.is_valid_filter(filter), filter)
        for filter in ("", "a#", "#/a", "a+", "+a/b", "a/#/b", "##", "a\0"):
            self.assertFalse(t.is_valid_filter(filter), filter)

    def test_matching(self) -> None:
        for filter, name, does in [
            ("a", "a", True), ("a", "b", False), ("+", "a", True), ("+", "a/b", False), ("a/+", "a", False),
            ("a/+", "a/", True), ("a/#", "a", True), ("a/#", "a/b/c", True), ("a/#", "ab", False), ("#", "x/y", True),
            ("+/+", "/x", True), ("#", "$SYS/x", False), ("+/x", "$SYS/x", False), ("$SYS/#", "$SYS/x", True),
            ("+/#", "a", True), ("a/b", "a", False), ("a", "a/b", False), ("/#", "/", True),
        ]:  # fmt: skip
            self.assertIs(t.matches(filter, name), does, (filter, name))

    def test_short_names_have_two_octets(self) -> None:
        self.assertEqual(t.to_wire(ShortTopic("ab")), b"ab")
        for name in ("a", "abc", "", "+a", "ää"):
            with self.assertRaises(InvalidTopic):
                ShortTopic(name)

    def test_predefined_ids_are_not_the_reserved_ones(self) -> None:
        self.assertEqual(t.to_wire(PredefinedTopic(0x1234)), b"\x12\x34")
        for id in (0, 0xFFFF, -1, 70000):
            with self.assertRaises(InvalidTopic):
                PredefinedTopic(id)

    def test_ids_from_the_network_that_name_nothing(self) -> None:
        self.assertEqual(t.fixed_topic(TopicIdType.SHORT, 0x6162), "ab")
        self.assertEqual(t.fixed_topic(TopicIdType.PREDEFINED, 5), PredefinedTopic(5))
        for type, id in [(TopicIdType.SHORT, 0), (TopicIdType.SHORT, 0x612B), (TopicIdType.SHORT, 0xFFFE),
                         (TopicIdType.PREDEFINED, 0), (TopicIdType.PREDEFINED, 0xFFFF), (TopicIdType.RESERVED, 1)]:  # fmt: skip
            self.assertIsNone(t.fixed_topic(type, id), (type, id))
