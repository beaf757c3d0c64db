"""The examples run as their comments say, with real brokers, robots and sweeps."""

import asyncio
import os
import tempfile
import unittest
from pathlib import Path

from programs import Broker, Program, Robot, example

ROMANO = os.environ.get("ROMANO_PROGRAM", "romano")
PATIENCE = 60.0

SWEEP = """
output = "{folder}/results"
duration = 1
publish_within = 20
[axes]
brokers = 1
robots = 3
rate = 10
qos = 1
"""


class Examples(unittest.IsolatedAsyncioTestCase):
    async def output(self, *command: str) -> str:
        program = Program(*command)
        self.addAsyncCleanup(program.kill)
        await program.start()
        assert program.process is not None
        async with asyncio.timeout(PATIENCE):
            out, _ = await program.process.communicate()
        self.assertEqual(program.process.returncode, 0, out.decode())
        return out.decode()

    async def broker(self) -> Broker:
        broker = Broker("--name", "home")
        self.addAsyncCleanup(broker.kill)
        await broker.start()
        return broker

    async def test_publish_and_subscribe(self) -> None:
        broker = await self.broker()
        said = await self.output(*example("publish_and_subscribe.py"), broker.host, str(broker.port))
        for qos in (0, 1, 2):
            self.assertIn(f"robots/abcd1234/pose: x={qos} y=2 (QoS {qos})", said)
        self.assertIn("Ada (kept)", said)
        self.assertEqual(said.count("refused:"), 2)
        self.assertIn("dropped: 0", said)

    async def test_move_a_robot(self) -> None:
        broker = await self.broker()
        here = (broker.host, str(broker.port))
        self.assertIn("no robots here", await self.output(*example("move_a_robot.py"), *here))
        robot = Robot(broker, "abcd1234")
        self.addAsyncCleanup(robot.kill)
        await robot.start()
        await robot.line("established")
        said = await self.output(*example("move_a_robot.py"), *here)
        self.assertIn("robot abcd1234: connected, home home", said)
        corners = [line.split("at ")[1] for line in said.splitlines() if "is at" in line]
        self.assertEqual(corners, [f"x={x} mm, y={y} mm" for x, y in ((200, 0), (200, 200), (0, 200), (0, 0))])

    async def test_read_a_sweep(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "small.toml").write_text(SWEEP.format(folder=folder))
            await self.output(ROMANO, "sweep", str(Path(folder) / "small.toml"))
            said = await self.output(*example("read_a_sweep.py"), f"{folder}/results")
        self.assertIn("1 of 1 runs are ok", said)
        self.assertRegex(said, r"1 brokers: delay [0-9.]+ ms \(median of 1 runs\)")
        self.assertRegex(said, r"cell 1: ([0-9]+) of \1 messages arrived")


if __name__ == "__main__":
    unittest.main()
