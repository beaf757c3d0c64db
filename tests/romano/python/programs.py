"""Real programs for tests: brokers and robots on addresses of their own."""

import asyncio
import fcntl
import os
import signal
import socket
import sys
from pathlib import Path

from romano import Client, Timing

BROKER = os.environ.get("ROMANO_BROKER", "romano-broker")
ROBOT = os.environ.get("ROMANO_ROBOT", "romano-robot")
QUICK = Timing(t_retry=0.5, n_retry=20, t_wait=4.0, reconnect_most=0.5)
"""A machine that runs many tests at once answers late, but it does answer."""


def free_port(host: str = "127.0.0.1", kind: int = socket.SOCK_DGRAM) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind((host, 0))
        port: int = probe.getsockname()[1]
        return port


class Program:
    """A process that ends with the test."""

    def __init__(self, *arguments: str) -> None:
        self.arguments = arguments
        self.process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        self.process = await asyncio.create_subprocess_exec(*self.arguments, stdout=asyncio.subprocess.PIPE)

    async def line(self, words: str, timeout_s: float = 60) -> str:
        """The next line of its output with these words."""
        assert self.process is not None and self.process.stdout is not None
        async with asyncio.timeout(timeout_s):
            while text := (await self.process.stdout.readline()).decode():
                if words in text:
                    return text
        raise AssertionError(f"{self.arguments} ended and never said {words!r}")

    async def kill(self, how: int = signal.SIGKILL) -> None:
        if self.process is None or self.process.returncode is not None:
            return
        self.process.send_signal(how)
        await self.process.communicate()


class Broker(Program):
    """Alone, on a free port of 127.0.0.1; the same port after a restart."""

    def __init__(self, *options: str, host: str = "127.0.0.1") -> None:
        self.host, self.port = host, free_port(host)
        super().__init__(BROKER, "--listen", f"{self.host}:{self.port}", "--log-level", "error", *options)

    async def start(self) -> None:
        await super().start()
        await self.line("serving")

    def client(self, **options: object) -> Client:
        return Client(self.host, self.port, **{"timing": QUICK, **options})  # type: ignore[arg-type]


class Robot(Program):
    def __init__(self, broker: Broker, id: str, *options: str) -> None:
        super().__init__(ROBOT, "--id", id, "--broker", f"{broker.host}:{broker.port}", *options)


class Domain:
    """A DDS domain id that no other test on this machine uses (tests/overlay/dds/test_domain.h)."""

    def __init__(self) -> None:
        for self.id in range(88, 101):
            self._lock = os.open(f"/tmp/romano-test-domain-{self.id}", os.O_RDWR | os.O_CREAT, 0o666)
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except OSError:
                os.close(self._lock)
        raise AssertionError("no DDS domain is free")

    def free(self) -> None:
        os.close(self._lock)


def example(name: str) -> list[str]:
    examples = Path(__file__).parents[3] / "romano" / "python" / "examples"
    return [sys.executable, str(examples / name)]
