"""What the package raises. Everything derives from :class:`RomanoError`.

Nothing of this is ever raised because of what the network sends: such datagrams are dropped and counted.
"""

from __future__ import annotations


class RomanoError(Exception):
    """The base of all errors of this package."""


class InvalidTopic(RomanoError, ValueError):
    """A topic that cannot be used so: empty, ill-formed, with a wildcard where a name is wanted."""


class TooLong(RomanoError, ValueError):
    """A message that no datagram holds, or a ROMANO message of more than 255 octets."""


class QueueFull(RomanoError):
    """Too many requests wait for the broker already (``Limits.operations``)."""


class NotConnected(RomanoError, ConnectionError):
    """There is no connection, and what was asked for cannot wait for one."""


class ConnectionLost(NotConnected):
    """The broker did not answer after all repetitions, or ended the session."""


class Rejected(RomanoError):
    """The broker answered with a return code other than "accepted" (MQTT-SN 1.2 section 5.3.10)."""

    def __init__(self, message: str, return_code: int) -> None:
        super().__init__(message)
        self.return_code = return_code
        """As on the wire: 1 congestion, 2 invalid topic id, 3 not supported; others are reserved."""


class Congestion(Rejected):
    """Return code 1: the broker has no room, or is overloaded.

    The client asks nothing of this broker for T_WAIT; what is asked meanwhile fails in the same way at once.
    """

    def __init__(self, message: str, retry_after_s: float) -> None:
        super().__init__(message, 1)
        self.retry_after_s = retry_after_s
        """Seconds until it may be asked again."""


class InvalidTopicId(Rejected):
    """Return code 2: the broker does not know the predefined topic id."""

    def __init__(self, message: str) -> None:
        super().__init__(message, 2)


class NotSupported(Rejected):
    """Return code 3: the request must not be repeated as it is."""

    def __init__(self, message: str) -> None:
        super().__init__(message, 3)


class UnknownRobot(RomanoError, LookupError):
    """No robot of that id is known to the broker."""


class NoAnswer(RomanoError, TimeoutError):
    """The broker has the message, but the robot did not answer in time."""


class CannotSay(RomanoError, ValueError):
    """A command that this robot's form of ROMANO has no words for."""


class NoSweep(RomanoError, ValueError):
    """A folder or file that is no result of ``romano sweep``."""


def rejection(what: str, return_code: int, retry_after_s: float = 0.0) -> Rejected:
    """The exception for a return code of the broker."""
    if return_code == 1:
        wait = f"; it may be asked again in {retry_after_s:.0f} s" if retry_after_s > 0 else ""
        return Congestion(f"{what}: the broker has no room (congestion){wait}", retry_after_s)
    if return_code == 2:
        return InvalidTopicId(f"{what}: the broker does not know this topic id")
    if return_code == 3:
        return NotSupported(f"{what}: the broker does not support this")
    return Rejected(f"{what}: the broker refused with return code {return_code}", return_code)
