#!/usr/bin/env python3
"""What a sweep measured, as a table: delays and failovers for each number of brokers.

Run a sweep first, then this:

    romano sweep experiments/demo.toml          # leaves results/demo
    python3 read_a_sweep.py results/demo
"""

# %% A results folder. It may belong to a sweep that is still running.
import sys
from statistics import median

import romano

FOLDER = sys.argv[1] if len(sys.argv) > 1 else "results/demo"


# %% Rows and columns in plain Python. `None` stands where a run had nothing to measure.
def delays(sweep: romano.Sweep) -> None:
    fine = sweep.runs.where(status="ok")
    print(f"{len(fine)} of {len(sweep.runs)} runs are ok")
    for brokers in sorted({row["brokers"] for row in fine}, key=str):
        runs = fine.where(brokers=brokers)
        p50 = [value for value in runs["delay_p50_ms"] if isinstance(value, (int, float))]
        if p50:
            print(f"{brokers} brokers: delay {median(p50):.1f} ms (median of {len(p50)} runs)")


# %% Every single message of one cell.
def slowest(sweep: romano.Sweep, cell: int) -> None:
    samples = sweep.samples(cell)
    arrived = [row for row in samples if isinstance(row["delay_ms"], (int, float))]
    print(f"cell {cell}: {len(arrived)} of {len(samples)} messages arrived")
    for row in sorted(arrived, key=lambda row: float(row["delay_ms"] or 0))[-3:]:
        print(f"    {row['delay_ms']:.1f} ms, sent {row['sent_s']:.2f} s after the start at QoS {row['qos']}")


# %% With pandas (Debian: python3-pandas) the same is a data frame, and the rest is what you know.
def frames(sweep: romano.Sweep) -> None:
    try:
        frame = sweep.runs.to_pandas()
    except ImportError:
        print("(pandas is not installed)")
        return
    print(frame.groupby(["brokers", "fault"])[["delay_p50_ms", "delay_p99_ms", "delivery_ratio"]].mean())


# %% All of it.
def main() -> None:
    try:
        sweep = romano.Sweep(FOLDER)
    except romano.NoSweep as refused:
        sys.exit(f"read_a_sweep.py: {refused}")
    delays(sweep)
    if len(sweep.runs):
        slowest(sweep, int(sweep.runs["cell"][0] or 0))
    frames(sweep)


if __name__ == "__main__":
    main()
