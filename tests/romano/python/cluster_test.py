"""A broker of a cluster is killed, another takes its address over, and a Python client notices nothing."""

import asyncio
import unittest

from programs import Broker, Domain


class TakeOver(unittest.IsolatedAsyncioTestCase):
    async def test_a_client_whose_broker_is_killed_goes_on_without_an_interruption(self) -> None:
        domain = Domain()
        self.addCleanup(domain.free)
        brokers = [self.broker(domain.id, number) for number in (1, 2)]
        await asyncio.gather(*(broker.start() for broker in brokers))
        client = brokers[0].client(keep_alive_s=5)
        other = brokers[1].client()
        for each in (client, other):
            await each.connect()
            self.addAsyncCleanup(each.disconnect)
        async with asyncio.timeout(60):
            facts = await other.subscribe("$SYS/brokers/+", qos=1)
            while '"members":["r1","r2"]' not in (await facts.get()).text:
                pass
        heard = await client.subscribe("a", qos=2)

        async def talk() -> None:
            for at in range(300):
                await client.publish("a", str(at), qos=2)
                await asyncio.sleep(0.005)

        talking = asyncio.create_task(talk())
        await asyncio.sleep(0.5)
        await brokers[0].kill()
        async with asyncio.timeout(60):
            await talking
            got = [int((await heard.get()).text) for _ in range(300)]
        self.assertEqual(got, list(range(300)))
        self.assertEqual(client.interruptions, 0)

    def broker(self, domain: int, number: int) -> Broker:
        broker = Broker(
            "--name", f"r{number}", "--domain", str(domain), "--interface", "lo", "--rank", str(3 - number),
            "--detection-timeout-ms", "300", host=f"127.77.{domain}.{number}",
        )  # fmt: skip
        self.addAsyncCleanup(broker.kill)
        return broker


if __name__ == "__main__":
    unittest.main()
