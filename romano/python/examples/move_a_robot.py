#!/usr/bin/env python3
"""The robots of all brokers: list them, move one in a square, and ask where it is.

Start a broker and a simulated robot first, then this:

    romano-broker --listen 127.0.0.1:1883 &
    romano-robot --id abcd1234 --broker 127.0.0.1:1883 &
    python3 move_a_robot.py [HOST [PORT]]

In a notebook write `await main()` instead of the last two lines.
"""

# %% Where a broker is; any one of a cluster.
import asyncio
import sys

import romano

HOST = sys.argv[1] if len(sys.argv) > 1 else "127.0.0.1"
PORT = int(sys.argv[2]) if len(sys.argv) > 2 else 1883


# %% Who is there. A broker lists the robots of its whole cluster, with the broker that serves each.
def show(fleet: romano.Fleet) -> None:
    for robot in fleet.robots:
        print(f"robot {robot.id}: {robot.state}, home {robot.home}")


# %% Move. A command goes at QoS 2, so no robot drives a way twice. `await` ends when the broker has the command; the
# robot itself answers when it is asked something, and it answers in order.
async def square(fleet: romano.Fleet, robot: str, side_mm: int) -> None:
    for _ in range(4):
        await fleet.move(robot, "front", mm=side_mm)
        await fleet.move(robot, "rotate-left", deg=90)
        location = await fleet.location(robot, timeout_s=10)
        print(f"robot {robot} is at x={location.x_mm} mm, y={location.y_mm} mm")


# %% All of it. Two things are entered one after the other: the client, and what it sees of the robots.
async def main() -> None:
    async with romano.Client(HOST, PORT) as client, romano.Fleet(client) as fleet:
        show(fleet)
        if not fleet.robots:
            print("no robots here: start one with romano-robot --broker HOST:PORT")
            return
        await square(fleet, fleet.robots[0].id, side_mm=200)

        # A topic that robots listen to moves all of them at once; every robot listens to "common".
        await fleet.move("common", "back", mm=50)


if __name__ == "__main__":
    asyncio.run(main())
