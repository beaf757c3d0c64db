"""MQTT-SN 1.2 sections 5.2 to 5.4: octets by hand, every size, every truncation."""

import unittest

from romano.errors import TooLong
from romano.mqttsn import messages as m
from romano.mqttsn.codec import Malformed, decode, encode
from romano.mqttsn.types import MsgType, Qos, TopicIdType, flags_octet, qos_in, topic_type_in

# What the specification's tables say, octet by octet.
VECTORS = [
    (m.Advertise(7, 900), "05 00 07 0384"),
    (m.Searchgw(0), "03 01 00"),
    (m.Gwinfo(7, b""), "03 02 07"),
    (m.Gwinfo(7, b"\x7f\0\0\1"), "07 02 07 7f000001"),
    (m.Connect(0x0C, 1, 60, b"r7"), "08 04 0c 01 003c 7237"),
    (m.Connack(1), "03 05 01"),
    (m.Willtopicreq(), "02 06"),
    (m.Willtopic(0x30, b"w"), "04 07 30 77"),
    (m.Willtopic(0, b""), "02 07"),
    (m.Willmsgreq(), "02 08"),
    (m.Willmsg(b"bye"), "05 09 627965"),
    (m.Register(0, 5, b"a/b"), "09 0a 0000 0005 612f62"),
    (m.Regack(1, 5, 0), "07 0b 0001 0005 00"),
    (m.Publish(0x20, 1, 9, b"x"), "08 0c 20 0001 0009 78"),
    (m.Publish(0, 1, 0, b""), "07 0c 00 0001 0000"),
    (m.Puback(1, 9, 2), "07 0d 0001 0009 02"),
    (m.Pubcomp(9), "04 0e 0009"),
    (m.Pubrec(9), "04 0f 0009"),
    (m.Pubrel(9), "04 10 0009"),
    (m.Subscribe(0x40, 3, b"a/+"), "08 12 40 0003 612f2b"),
    (m.Suback(0x40, 0, 3, 0), "08 13 40 0000 0003 00"),
    (m.Unsubscribe(0, 4, b"a"), "06 14 00 0004 61"),
    (m.Unsuback(4), "04 15 0004"),
    (m.Pingreq(), "02 16"),
    (m.Pingreq(b"r7"), "04 16 7237"),
    (m.Pingresp(), "02 17"),
    (m.Disconnect(), "02 18"),
    (m.Disconnect(300), "04 18 012c"),
    (m.Willtopicupd(0, b"w"), "04 1a 00 77"),
    (m.Willtopicresp(0), "03 1b 00"),
    (m.Willmsgupd(b""), "02 1c"),
    (m.Willmsgresp(3), "03 1d 03"),
]


class Codec(unittest.TestCase):
    def test_each_message_is_the_octets_of_the_specification_and_back(self) -> None:
        for message, octets in VECTORS:
            with self.subTest(octets):
                self.assertEqual(encode(message), bytes.fromhex(octets))
                self.assertEqual(decode(bytes.fromhex(octets)), message)

    def test_each_type_of_the_specification_has_a_vector(self) -> None:
        self.assertEqual({message.TYPE for message, _ in VECTORS}, set(MsgType))

    def test_a_truncated_message_is_dropped_at_each_octet(self) -> None:
        for message, octets in VECTORS:
            whole = bytes.fromhex(octets)
            for size in range(len(whole)):
                with self.subTest(octets, size=size):
                    self.assertIs(decode(whole[:size]), Malformed.LENGTH if size else Malformed.EMPTY)

    def test_a_message_whose_size_is_not_in_the_table_is_dropped(self) -> None:
        for octets in ("02 00", "02 05", "04 05 0000", "03 06 00", "03 0e 00", "05 0e 000000", "05 12 00 0001",
                       "07 13 00 0000 00 00", "03 17 00", "03 18 00", "05 18 000000", "06 0c 00 0001 00"):  # fmt: skip
            self.assertIs(decode(bytes.fromhex(octets)), Malformed.SIZE, octets)

    def test_reserved_types_are_dropped(self) -> None:
        for type in set(range(256)) - set(MsgType):
            self.assertIs(decode(bytes((2, type))), Malformed.RESERVED_TYPE)

    def test_the_length_is_a_claim_and_the_datagram_the_truth(self) -> None:
        for octets in ("00", "03 17", "01", "01 00 04", "01 0000 17", "02 17 00", "01 0005 17"):
            self.assertIs(decode(bytes.fromhex(octets)), Malformed.LENGTH, octets)

    def test_the_long_form_begins_at_256_octets_and_is_read_below(self) -> None:
        short = encode(m.Publish(0, 1, 0, bytes(248)))
        self.assertEqual((len(short), short[0]), (255, 255))
        long = encode(m.Publish(0, 1, 0, bytes(249)))
        self.assertEqual((len(long), long[:4].hex()), (258, "0101020c"))
        self.assertEqual(decode(long), m.Publish(0, 1, 0, bytes(249)))
        self.assertEqual(decode(bytes.fromhex("01 0004 17")), m.Pingresp())

    def test_pahos_message_of_255_octets_is_read(self) -> None:
        body = bytes.fromhex("00 0001 0000") + bytes(248)
        self.assertEqual(decode(b"\x01\x00\xff\x0c" + body), m.Publish(0, 1, 0, bytes(248)))

    def test_what_udp_does_not_carry_is_refused(self) -> None:
        encode(m.Publish(0, 1, 0, bytes(65498)))
        with self.assertRaises(TooLong):
            encode(m.Publish(0, 1, 0, bytes(65499)))

    def test_flags_are_the_bits_of_section_5_3_4(self) -> None:
        self.assertEqual(flags_octet(dup=True, qos=2, retain=True, topic_type=TopicIdType.SHORT), 0b1101_0010)
        self.assertEqual(flags_octet(qos=-1, will=True, clean_session=True), 0b0110_1100)
        for qos in Qos:
            self.assertIs(qos_in(flags_octet(qos=qos)), qos)
        for type in TopicIdType:
            self.assertIs(topic_type_in(flags_octet(topic_type=type)), type)
