"""ROMANO messages: octets by hand, round trips, every truncation, any octets. The commands in both of their forms."""

import random
import unittest

from romano import CannotSay, InvalidTopic, TooLong
from romano.command import BINARY, LEGACY, move_message, request_message, subscribe_message, unsubscribe_message

from romano.message import (
    ApplicationData, Battery, ConnectedNodes, ConnectionAck, ConnectionRequest, Gyroscope, Heartbeat, LineReflectance,
    Location, Malformed, MovementControl, MqttPublishRequest, MqttSubscribe, MqttUnsubscribe, NormalData, OwnMovement,
    OwnSensor, Proximity, RemoteControl, RequestConnectedNodes, RssiReport, SensorData, Speed, UdpSendGo, UdpSendReq, decode,
    encode,
)  # fmt: skip
from romano.node_entry import Robot, parse_entry, robot_of

ID = "6162636431323334"  # abcd1234

VECTORS = [
    (NormalData(b"x"), "00 03 78"),
    (MqttSubscribe("line"), "01 06 6c696e65"),
    (MqttPublishRequest("t/x", b"location"), "02 0e 05 742f78 6c6f636174696f6e"),
    (ConnectedNodes(()), "03 02"),
    (ConnectedNodes(("abcd1234", "00000002")), f"03 12 {ID} 3030303030303032"),
    (RequestConnectedNodes("abcd1234"), f"04 0a {ID}"),
    (RssiReport("abcd1234", -60), f"05 0b {ID} c4"),
    (SensorData(Gyroscope(1, -1, 2)), "06 10 0000 00000001 ffffffff 00000002"),
    (SensorData(Proximity(300)), "06 08 0001 0000012c"),
    (SensorData(Location(1000, -2, 90000)), "06 10 0002 000003e8 fffffffe 00015f90"),
    (SensorData(Speed(100, -5)), "06 0c 0003 00000064 fffffffb"),
    (SensorData(Battery(3700)), "06 06 0004 0e74"),
    (SensorData(LineReflectance((1, 2, 3, 4, 65535))), "06 0e 0005 0001 0002 0003 0004 ffff"),
    (SensorData(OwnSensor(0x8001, b"\1")), "06 05 8001 01"),
    (MovementControl("front", 100), "07 08 0000 00000064"),
    (MovementControl("rotate-right", 90000), "07 08 0005 00015f90"),
    (OwnMovement(0x8001, b"\x0a\x0b"), "07 06 8001 0a0b"),
    (RemoteControl(b"\1"), "08 03 01"),
    (MqttUnsubscribe("line"), "09 06 6c696e65"),
    (Heartbeat("abcd1234"), f"0a 0a {ID}"),
    (ConnectionRequest("abcd1234"), f"0b 0a {ID}"),
    (ConnectionAck(), "0c 02"),
    (UdpSendReq(), "11 02"),
    (UdpSendGo(), "12 02"),
    (ApplicationData(0x13, b"x"), "13 03 78"),
]


class Messages(unittest.TestCase):
    def test_each_message_is_the_octets_of_the_table_and_back(self) -> None:
        for message, octets in VECTORS:
            with self.subTest(octets):
                self.assertEqual(encode(message).hex(" "), bytes.fromhex(octets).hex(" "))
                self.assertEqual(decode(bytes.fromhex(octets)), message)

    def test_a_truncated_message_is_malformed_whatever_its_length_says(self) -> None:
        for _, octets in VECTORS:
            whole = bytes.fromhex(octets)
            for size in range(len(whole)):
                cut = whole[:size]
                self.assertIs(decode(cut), Malformed.HEADER if size < 2 else Malformed.LENGTH)
                if size >= 2:
                    decode(bytes((cut[0], size)) + cut[2:])  # never raises

    def test_what_fields_may_not_hold(self) -> None:
        for octets, reason in [
            ("0d 02", Malformed.RESERVED_TYPE), ("10 02", Malformed.RESERVED_TYPE), ("01 02", Malformed.SIZE),
            ("0c 03 00", Malformed.SIZE), ("07 08 0006 00000000", Malformed.VALUE), ("07 07 0000 000000", Malformed.SIZE),
            ("06 06 0006 0000", Malformed.VALUE), ("06 06 0000 0000", Malformed.SIZE), ("0a 0a 4142434431323334", Malformed.VALUE),
            ("0a 03 61", Malformed.SIZE), ("02 04 02 61", Malformed.VALUE), ("02 04 04 61", Malformed.VALUE),
            ("02 03 03", Malformed.SIZE), ("03 03 61", Malformed.SIZE), ("01 03 ff", Malformed.VALUE),
        ]:  # fmt: skip
            self.assertIs(decode(bytes.fromhex(octets)), reason, octets)

    def test_any_octets_are_a_message_or_none_and_what_is_one_encodes_to_itself(self) -> None:
        source = random.Random(34)
        for _ in range(50_000):
            body = source.randbytes(source.choice((0, 1, 2, 4, 6, 8, 9, 10, 14, 16, 40)))
            data = bytes((source.randrange(0x16), len(body) + 2 - (source.random() < 0.05))) + body
            message = decode(data)
            if not isinstance(message, Malformed):
                self.assertEqual(encode(message), data)

    def test_what_no_message_can_say_is_refused(self) -> None:
        with self.assertRaises(TooLong):
            encode(NormalData(bytes(254)))
        with self.assertRaises(TooLong):
            encode(MqttPublishRequest("t" * 300, b""))
        for message in (Heartbeat("ABCD1234"), MovementControl("up", 1), MovementControl("front", -1), OwnMovement(5, b""),
                        SensorData(Battery(70000)), RssiReport("abcd1234", 128), ApplicationData(0x12, b""), MqttSubscribe("")):  # fmt: skip
            with self.assertRaises(ValueError, msg=str(message)):
                encode(message)


class Commands(unittest.TestCase):
    def test_a_robot_hears_the_papers_messages(self) -> None:
        self.assertEqual(decode(move_message(BINARY, "front", mm=100)), MovementControl("front", 100))
        self.assertEqual(decode(move_message(BINARY, "rotate-left", deg=90)), MovementControl("rotate-left", 90000))
        self.assertEqual(decode(request_message(BINARY, "t", "location")), MqttPublishRequest("t", b"location"))
        self.assertEqual(decode(subscribe_message(BINARY, "line/#")), MqttSubscribe("line/#"))
        self.assertEqual(decode(unsubscribe_message(BINARY, "line")), MqttUnsubscribe("line"))

    def test_the_authors_firmware_hears_its_ascii(self) -> None:
        self.assertEqual(move_message(LEGACY, "front", ms=500), b"70401f400001e")
        self.assertEqual(move_message(LEGACY, "back", ms=500, speed_percent=50), b"70401f40000ce")
        self.assertEqual(move_message(LEGACY, "rotate-right", deg=90), b"7020000ffa61e")
        self.assertEqual(subscribe_message(LEGACY, "line"), b"1line")
        self.assertEqual(request_message(LEGACY, "line", "location"), b"24line0location")

    def test_what_a_robot_cannot_do_is_said_in_words(self) -> None:
        for form, movement, amount, words in [
            (BINARY, "up", {"mm": 1}, "must be one of"), (BINARY, "front", {"deg": 1}, "give mm="),
            (BINARY, "front", {}, "give mm="), (BINARY, "rotate-left", {"mm": 1}, "give deg="),
            (BINARY, "front", {"mm": 1, "deg": 1}, "nothing else"), (BINARY, "front", {"mm": -1}, "from 0 to 4294967295"),
            (LEGACY, "front", {"mm": 1}, "drives by time"), (LEGACY, "left", {"ms": 1}, "sideways"),
            (LEGACY, "front", {"ms": 70000}, "from 0 to 65535"), (LEGACY, "front", {"ms": 1, "speed_percent": 0}, "1 to 100"),
        ]:  # fmt: skip
            with self.assertRaisesRegex(CannotSay, words):
                move_message(form, movement, **amount)  # type: ignore[arg-type]
        with self.assertRaises(CannotSay):
            unsubscribe_message(LEGACY, "line")
        with self.assertRaises(CannotSay):
            subscribe_message(LEGACY, "a-topic-too-long")
        with self.assertRaises(InvalidTopic):
            request_message(BINARY, "a/+", "location")


class Entries(unittest.TestCase):
    TEXT = b"form=binary state=silent heartbeat_unix_ms=1790000000123 home=r1 client=a b"

    def test_an_entry_is_read(self) -> None:
        robot = parse_entry("abcd1234", self.TEXT)
        self.assertEqual(robot, Robot("abcd1234", "silent", "r1", "binary", "a b", 1790000000123))
        assert robot is not None and robot.heartbeat is not None
        self.assertEqual(robot.heartbeat.isoformat(), "2026-09-21T14:13:20.123000+00:00")

    def test_what_is_no_entry_is_none(self) -> None:
        for data in (b"", b"\xff", self.TEXT.replace(b"silent", b"dead"), self.TEXT.replace(b"17", b"-17"), self.TEXT[5:],
                     self.TEXT.replace(b"1790000000123", b"1" * 5000)):  # fmt: skip
            self.assertIsNone(parse_entry("abcd1234", data))
        for topic in ("$ROMANO/nodes/", "$ROMANO/nodes/ABCD1234", "nodes/abcd1234", "$ROMANO/nodes/abcd1234/x"):
            self.assertIsNone(robot_of(topic))
        self.assertEqual(robot_of("$ROMANO/nodes/abcd1234"), "abcd1234")

    def test_a_heartbeat_beyond_all_calendars_is_none(self) -> None:
        robot = parse_entry("abcd1234", self.TEXT.replace(b"1790000000123", b"9" * 20))
        assert robot is not None
        self.assertIsNone(robot.heartbeat)


if __name__ == "__main__":
    unittest.main()
