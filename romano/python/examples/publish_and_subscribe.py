#!/usr/bin/env python3
"""Messages between two clients, and what happens when a broker says no.

Start a broker first, then this:

    romano-broker --listen 127.0.0.1:1883 &
    python3 publish_and_subscribe.py [HOST [PORT]]

The parts between the lines with %% are cells for editors that know them. In a notebook write `await main()` instead of
the last two lines.
"""

# %% Where the broker is. Any MQTT-SN 1.2 broker will do.
import asyncio
import sys

import romano

HOST = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
PORT = int(sys.argv[2]) if len(sys.argv) > 2 else 1883


# %% Publish and subscribe. A client is connected within `async with`; if it were to vanish without a goodbye, the
# broker would publish its will.
async def messages() -> None:
    async with (
        romano.Client(HOST, PORT) as listener,
        romano.Client(HOST, PORT, will=romano.Will("robots/gone", b"abcd1234")) as robot,
    ):
        # "+" stands for one level of a topic. At QoS 2 each message arrives exactly once.
        poses = await listener.subscribe("robots/+/pose", qos=2)

        # QoS 0 is sent and forgotten, 1 is repeated until the broker has it, 2 also keeps the repetitions apart.
        # `await` ends when that is done, so errors appear where they belong.
        for qos in (0, 1, 2):
            await robot.publish("robots/abcd1234/pose", f"x={qos} y=2", qos=qos)
        for _ in range(3):
            message = await poses.get(timeout_s=5)
            print(f"{message.topic}: {message.text} (QoS {int(message.qos)})")


# %% Retained messages. The broker keeps one on each topic for whoever subscribes later.
async def retained() -> None:
    async with romano.Client(HOST, PORT) as client:
        await client.publish("robots/abcd1234/name", "Ada", qos=1, retain=True)
        async with await client.subscribe("robots/+/name") as names:
            message = await names.get(timeout_s=5)
            print(f"{message.topic}: {message.text} ({'kept' if message.retain else 'live'})")
        await client.publish("robots/abcd1234/name", "", qos=1, retain=True)  # forget it


# %% Refusals are exceptions. What the network sends never is: it is dropped and counted in `client.drops`.
async def refusals() -> None:
    async with romano.Client(HOST, PORT) as client:
        try:
            await client.subscribe(romano.PredefinedTopic(4711))  # this broker was not told of such a topic
        except romano.InvalidTopicId as refused:
            print("refused:", refused)
        try:
            await client.publish("robots/+/pose", "x=1")
        except romano.InvalidTopic as refused:
            print("refused:", refused)
        print("dropped:", sum(client.drops.values()))


# %% All of it.
async def main() -> None:
    await messages()
    await retained()
    await refusals()


if __name__ == "__main__":
    asyncio.run(main())
