"""How long a client waits, and how much it holds: fixed when it is made."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Timing:
    """Times in seconds and counts, as MQTT-SN 1.2 section 7.2 recommends them."""

    t_retry: float = 10.0
    """From a request to its repetition."""
    n_retry: int = 3
    """Repetitions after the first sending; then the broker counts as lost."""
    t_wait: float = 300.0
    """Pause after "congestion"."""
    reconnect_most: float = 30.0
    """The longest pause between two attempts to connect again; they begin at once and double."""

    def __post_init__(self) -> None:
        if self.t_retry <= 0 or self.t_wait < 0 or self.reconnect_most <= 0 or self.n_retry < 0:
            raise ValueError(f"{self}: times must be above 0, counts not below")


@dataclass(frozen=True)
class Limits:
    """Bounds of all that grows. What happens at each of them stands there."""

    operations: int = 1000
    """Requests that wait for the broker: further ones raise QueueFull."""
    topics: int = 10_000
    """Topic ids that are known: a REGISTER of the broker beyond is refused with "congestion", and so are one's own."""
    subscriptions: int = 1000
    """Subscriptions that are made again after a connection was lost: further ones raise QueueFull."""
    unreleased: int = 100
    """Messages of QoS 2 between PUBREC and PUBREL: the oldest is forgotten."""
