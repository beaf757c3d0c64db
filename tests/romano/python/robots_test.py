"""Real robots at a real broker: who is there, and what they are told to do."""

import asyncio
import signal
import unittest

from programs import QUICK, Broker, Robot
from romano import CannotSay, Change, Client, Fleet, NoAnswer, UnknownRobot
from romano.message import Location, NormalData

PATIENCE = 30.0


class Robots(unittest.IsolatedAsyncioTestCase):
    async def asyncSetUp(self) -> None:
        self.broker = Broker("--name", "home")
        self.addAsyncCleanup(self.broker.kill)
        await self.broker.start()
        self.client = self.broker.client()
        await self.client.connect()
        self.addAsyncCleanup(self.client.disconnect)

    async def robot(self, id: str, *options: str) -> Robot:
        robot = Robot(self.broker, id, *options)
        self.addAsyncCleanup(robot.kill)
        await robot.start()
        await robot.line("established")
        return robot

    async def test_the_list_has_all_robots_and_heeds_those_that_come_and_go(self) -> None:
        await self.robot("abcd1234")
        async with Fleet(self.client) as fleet:
            self.assertEqual(
                [(r.id, r.state, r.home, r.form) for r in fleet.robots], [("abcd1234", "connected", "home", "binary")]
            )
            second = await self.robot("00000002", "--heartbeat", "1")
            await self.until(lambda: [r.id for r in fleet.robots] == ["00000002", "abcd1234"])
            await self.until(lambda: fleet.robot("00000002").heartbeat is not None)
            await second.kill(signal.SIGINT)
            await self.until(lambda: [r.id for r in fleet.robots] == ["abcd1234"])
            with self.assertRaises(UnknownRobot):
                await fleet.move("00000002", "front", mm=1)

    async def test_changes_are_told_as_they_come(self) -> None:
        await self.robot("abcd1234")
        async with Fleet(self.client) as fleet:
            changes = fleet.changes()
            async with asyncio.timeout(PATIENCE):
                first = await anext(changes)
                self.assertEqual((first.id, first.robot), ("abcd1234", fleet.robot("abcd1234")))
                second = await self.robot("00000002", "--heartbeat", "1")
                while (await anext(changes)) != Change("00000002", is_heartbeat=True):
                    pass
                await second.kill(signal.SIGINT)
                while (await anext(changes)) != Change("00000002", is_gone=True):
                    pass
            await changes.aclose()

    async def test_a_robot_moves_and_says_where_it_is(self) -> None:
        await self.robot("abcd1234")
        async with Fleet(self.client) as fleet:
            await fleet.move("abcd1234", "front", mm=100)
            self.assertEqual(await fleet.location("abcd1234", PATIENCE), Location(100, 0, 0))
            await fleet.move("abcd1234", "rotate-left", deg=90)
            self.assertEqual(await fleet.location("abcd1234", PATIENCE), Location(100, 0, 90000))
            await fleet.move("common", "back", mm=50)
            self.assertEqual(await fleet.location("abcd1234", PATIENCE), Location(100, -50, 90000))
            self.assertEqual(await fleet.ask("abcd1234", "colour", PATIENCE), NormalData(b"colour"))
            with self.assertRaises(CannotSay):
                await fleet.move("abcd1234", "up", mm=1)

    async def test_robots_that_were_told_to_subscribe_hear_their_teams_topic(self) -> None:
        await self.robot("abcd1234")
        async with Fleet(self.client) as fleet:
            await fleet.subscribe_robot("abcd1234", "team/red")
            await fleet.location("abcd1234", PATIENCE)  # by now it has asked for it
            while (await fleet.location("abcd1234", PATIENCE)).x_mm == 0:
                await fleet.move("team/red", "front", mm=10)
            await fleet.unsubscribe_robot("abcd1234", "team/red")

    async def test_who_does_not_answer_is_named(self) -> None:
        robot = await self.robot("abcd1234")
        async with Fleet(self.client) as fleet:
            assert robot.process is not None
            robot.process.send_signal(signal.SIGSTOP)
            with self.assertRaisesRegex(NoAnswer, "abcd1234 did not answer within 0.3 s"):
                await fleet.location("abcd1234", 0.3)
            robot.process.send_signal(signal.SIGCONT)

    async def test_a_fleet_outlives_its_client(self) -> None:
        client = Client(self.broker.host, self.broker.port, timing=QUICK)
        await client.connect()
        async with Fleet(client) as fleet:
            await client.disconnect()
            self.assertEqual(fleet.robots, [])

    async def until(self, holds: object) -> None:
        async with asyncio.timeout(PATIENCE):
            while not self.holds(holds):
                await asyncio.sleep(0.02)

    def holds(self, condition: object) -> bool:
        try:
            return bool(condition())  # type: ignore[operator]
        except UnknownRobot:
            return False


if __name__ == "__main__":
    unittest.main()
