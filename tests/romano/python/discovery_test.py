"""MQTT-SN 1.2 section 6.1: the client's side of discovery."""

import unittest

from romano import Gateway
from romano.core.discovery import DiscoveryCore, read_address
from romano.mqttsn.codec import encode
from romano.mqttsn.messages import Advertise, Gwinfo, Searchgw


class Discovery(unittest.TestCase):
    def setUp(self) -> None:
        self.core = DiscoveryCore(t_searchgw=5, t_adv=900, n_adv=3, seed=1)
        self.core.search(100)

    def test_it_searches_after_a_random_wait_and_then_ever_more_rarely(self) -> None:
        first = self.core.next_wakeup()
        self.assertTrue(100 <= first <= 105)
        self.assertIsNone(self.core.on_tick(first - 0.01) if first > 100 else None)
        times = []
        for _ in range(10):
            times.append(self.core.next_wakeup())
            self.assertEqual(self.core.on_tick(times[-1]), encode(Searchgw(0)))
        self.assertEqual([round(b - a) for a, b in zip(times, times[1:])], [5, 10, 20, 40, 80, 160, 320, 640, 900])

    def test_somebody_elses_search_counts_as_ones_own(self) -> None:
        self.core.on_datagram(100, "10.0.0.9", 5000, encode(Searchgw(0)))
        self.assertEqual(self.core.next_wakeup(), 105)

    def test_a_gateway_ends_the_search_and_expires_after_n_adv_missed_advertisements(self) -> None:
        self.core.on_datagram(100, "10.0.0.1", 1883, encode(Advertise(7, 60)))
        self.assertEqual(list(self.core.gateways.values()), [Gateway(7, "10.0.0.1", 1883, 280)])
        self.assertEqual(self.core.next_wakeup(), 280)
        self.core.on_tick(280)
        self.assertEqual(self.core.gateways, {})

    def test_another_clients_gwinfo_says_the_address(self) -> None:
        self.core.on_datagram(100, "10.0.0.9", 1883, encode(Gwinfo(7, bytes((10, 0, 0, 1)) + b"\x27\x10")))
        self.assertEqual(list(self.core.gateways.values())[0].port, 10000)

    def test_addresses_come_with_a_port_or_without_and_with_their_length_in_front(self) -> None:
        v4, v6 = bytes((10, 0, 0, 1)), bytes(15) + b"\1"
        for octets, place in ((v4, ("10.0.0.1", 1883)), (b"\4" + v4, ("10.0.0.1", 1883)), (v4 + b"\0\x05", ("10.0.0.1", 5)),
                              (v6, ("::1", 1883)), (b"\x12" + v6 + b"\0\x05", ("::1", 5)), (b"\1\2\3", None), (v6 + v6, None)):  # fmt: skip
            self.assertEqual(read_address(octets, 1883), place)

    def test_what_is_no_message_is_counted_and_gateways_are_bounded(self) -> None:
        self.core.on_datagram(100, "10.0.0.1", 1883, b"\xff\xff")
        self.assertEqual(self.core.drops, 1)
        for port in range(1000):
            self.core.on_datagram(100, "10.0.0.1", 1000 + port, encode(Advertise(1, 60)))
        self.assertEqual((len(self.core.gateways), self.core.drops), (100, 901))


if __name__ == "__main__":
    unittest.main()
