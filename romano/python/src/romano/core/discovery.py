"""Which brokers there are: MQTT-SN 1.2 section 6.1, the client's side.

Listens to ADVERTISE and GWINFO and searches with SEARCHGW, whose datagrams go to the discovery group.
"""

from __future__ import annotations

import ipaddress
import random
from dataclasses import dataclass

from ..mqttsn.codec import Malformed, decode, encode
from ..mqttsn.messages import Advertise, Gwinfo, Searchgw
from .timers import NEVER


@dataclass(frozen=True)
class Gateway:
    """A broker that discovery found. MQTT-SN calls it a gateway."""

    id: int
    host: str
    port: int
    expires: float
    """On the owner's clock: N_ADV missed ADVERTISEs from the last one on."""


class DiscoveryCore:
    MOST = 100
    """Gateways that are noted; further ones are dropped and counted."""

    def __init__(self, t_searchgw: float = 5.0, t_adv: float = 900.0, n_adv: int = 3, seed: int | None = None) -> None:
        self.gateways: dict[tuple[int, str, int], Gateway] = {}
        """By id and address: two brokers with one id are two."""
        self.drops = 0
        self._t_searchgw = t_searchgw
        self._t_adv = t_adv
        self._n_adv = n_adv
        self._random = random.Random(seed)
        self._search_at = NEVER
        self._interval = t_searchgw

    def search(self, now: float) -> None:
        """Searches after a random wait (6.1d), then ever more rarely, until a gateway is heard."""
        self._interval = self._t_searchgw
        self._search_at = now + self._random.uniform(0, self._t_searchgw)

    def on_datagram(self, now: float, host: str, port: int, datagram: bytes) -> None:
        """What came from there, on the discovery group or directly. Other messages are ignored."""
        self._forget_expired(now)
        message = decode(datagram)
        if isinstance(message, Malformed):
            self.drops += 1
        elif isinstance(message, Advertise):
            self._note(message.gateway_id, host, port, now + message.duration_s * self._n_adv)
        elif isinstance(message, Gwinfo):
            place = read_address(message.address, port) if message.address else (host, port)
            if place is not None:
                self._note(message.gateway_id, *place, now + self._t_adv * self._n_adv)
        elif isinstance(message, Searchgw) and self._search_at != NEVER:
            self._search_more_rarely(now)  # somebody else's search counts as our own (6.1d)

    def on_tick(self, now: float) -> bytes | None:
        """A datagram for the discovery group, if one is due."""
        self._forget_expired(now)
        if now < self._search_at:
            return None
        self._search_more_rarely(now)
        return encode(Searchgw(radius=0))

    def next_wakeup(self) -> float:
        return min([self._search_at, *(gateway.expires for gateway in self.gateways.values())])

    def _note(self, id: int, host: str, port: int, expires: float) -> None:
        self._search_at = NEVER
        key = (id, host, port)
        if key not in self.gateways and len(self.gateways) >= self.MOST:
            self.drops += 1
            return
        self.gateways[key] = Gateway(id, host, port, expires)

    def _search_more_rarely(self, now: float) -> None:
        self._search_at = now + self._interval
        self._interval = min(2 * self._interval, self._t_adv)

    def _forget_expired(self, now: float) -> None:
        self.gateways = {key: gateway for key, gateway in self.gateways.items() if gateway.expires > now}


def read_address(octets: bytes, default_port: int) -> tuple[str, int] | None:
    """GwAdd: an address, with a port or without, and perhaps a length octet in front. None when it is none."""
    if len(octets) % 2 == 1:
        octets = octets[1:]
    size = 4 if len(octets) < 16 else 16
    if len(octets) not in (size, size + 2):
        return None
    port = int.from_bytes(octets[size:], "big") if len(octets) > size else default_port
    return str(ipaddress.ip_address(octets[:size])), port
