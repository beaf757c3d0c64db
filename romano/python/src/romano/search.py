"""Finding brokers in the network: the sockets and the time around ``core.discovery``."""

from __future__ import annotations

import asyncio
import ipaddress
import logging
import socket
import struct
from typing import Any

from .core.discovery import DiscoveryCore, Gateway

GROUP_IPV4 = "225.1.1.1"
GROUP_IPV6 = "ff02::225:1:1:1"
_log = logging.getLogger("romano")


async def find_brokers(
    within_s: float = 3.0, *, local: str | None = None, group: str | None = None, port: int = 1883, first: bool = False
) -> list[Gateway]:
    """Brokers that answer SEARCHGW, or advertise themselves, within so many seconds; perhaps none.

    ``local``: an own IPv4 address, whose network is searched, or an own interface's name, which searches IPv6; None:
    IPv4 in the system's choice. ``group``, ``port``: where brokers listen (``romano-broker --discovery-group``).
    ``first``: return as soon as one has answered.

    A broker that serves all addresses of its machine is told by the one that it answered from.
    Raises OSError when the search cannot be sent, ValueError for a ``group`` that is none.
    """
    is_ipv6 = local is not None and not _is_address(local)
    where = ipaddress.ip_address(group or (GROUP_IPV6 if is_ipv6 else GROUP_IPV4))
    if not where.is_multicast or is_ipv6 != (where.version == 6):
        raise ValueError(f"group {where}: must be a multicast address of the family of `local`")
    loop = asyncio.get_running_loop()
    core = DiscoveryCore(t_searchgw=min(1.0, within_s / 4))
    heard = asyncio.Event()
    transports = []
    try:
        asker = _socket(where, local)
        asker.bind(("", 0))
        for own in (asker, _listener(where, port, local)):
            if own is not None:
                transport, _ = await loop.create_datagram_endpoint(lambda: _Ear(core, heard, local), sock=own)
                transports.append(transport)
        core.search(loop.time())
        end = loop.time() + within_s
        while (now := loop.time()) < end and not (first and core.gateways):
            search = core.on_tick(now)
            if search is not None:
                transports[0].sendto(search, (str(where), port))
            heard.clear()
            try:
                async with asyncio.timeout_at(min(end, core.next_wakeup())):
                    await heard.wait()
            except TimeoutError:
                pass
    finally:
        for transport in transports:
            transport.close()
    return list(core.gateways.values())


class _Ear(asyncio.DatagramProtocol):
    def __init__(self, core: DiscoveryCore, heard: asyncio.Event, local: str | None) -> None:
        self._core = core
        self._heard = heard
        self._local = local

    def datagram_received(self, data: bytes, addr: tuple[Any, ...]) -> None:
        host, port, *ipv6 = addr
        if any(ipv6):  # an address of one network: only with its interface it leads there
            host = f"{host}%{self._local}"
        self._core.on_datagram(asyncio.get_running_loop().time(), host, port, data)
        self._heard.set()


def _is_address(text: str) -> bool:
    try:
        return ipaddress.ip_address(text).version == 4
    except ValueError:
        return False


def _socket(group: ipaddress.IPv4Address | ipaddress.IPv6Address, local: str | None) -> socket.socket:
    """That sends to the group by way of ``local``."""
    own = socket.socket(socket.AF_INET if group.version == 4 else socket.AF_INET6, socket.SOCK_DGRAM)
    own.setblocking(False)
    try:
        if group.version == 6:
            own.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, socket.if_nametoindex(local or ""))
        elif local is not None:
            own.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(local))
    except OSError:
        own.close()
        raise
    return own


def _listener(
    group: ipaddress.IPv4Address | ipaddress.IPv6Address, port: int, local: str | None
) -> socket.socket | None:
    """For what brokers say to the group. None when this machine does not allow it: they answer the asker as well."""
    own = _socket(group, local)
    try:
        own.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        own.bind((str(group), port))
        if group.version == 4:
            request = group.packed + socket.inet_aton(local or "0.0.0.0")
            own.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, request)
        else:
            request = group.packed + struct.pack("@I", socket.if_nametoindex(local or ""))
            own.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, request)
    except OSError as error:
        _log.debug("discovery does not listen to %s: %s", group, error)
        own.close()
        return None
    return own
