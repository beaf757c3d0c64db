"""Results folders of `romano sweep`, also while it runs; as tables and as data frames."""

import importlib.util
import tempfile
import unittest
from pathlib import Path

from romano import NoSweep, Sweep, Table

RUNS = (
    "cell,brokers,rate_per_s,qos,acks,status,strikes,delay_p50_ms\n"
    "1,1,10,0+1,1,ok,,2\n"
    "2,3,0.5,1,all,ok,1,1.25\n"
    '3,3,10,1,1,"no leader, in time",,\n'
)


class Sweeps(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "samples").mkdir()
        (self.folder / "runs.csv").write_text(RUNS)
        (self.folder / "manifest.json").write_text('{"cells": 3}')
        (self.folder / "samples" / "cell-0002.csv").write_text(
            "publisher,sequence,sent_s,delay_ms\n0,1,0.5,1.5\n0,2,1,\n"
        )

    def test_columns_have_the_types_of_what_they_hold(self) -> None:
        runs = Sweep(self.folder).runs
        self.assertEqual(runs["brokers"], [1, 3, 3])
        self.assertEqual(runs["rate_per_s"], [10.0, 0.5, 10.0])
        self.assertEqual(runs["qos"], ["0+1", "1", "1"])
        self.assertEqual(runs["strikes"], [None, 1, None])
        self.assertEqual(runs["delay_p50_ms"], [2.0, 1.25, None])
        self.assertEqual(runs["status"][2], "no leader, in time")

    def test_rows_and_their_choice(self) -> None:
        chosen = Sweep(self.folder).runs.where(status="ok", brokers=3)
        self.assertEqual([row["cell"] for row in chosen], [2])
        with self.assertRaises(KeyError):
            chosen.where(broker=3)

    def test_samples_and_manifest(self) -> None:
        sweep = Sweep(self.folder)
        self.assertEqual(sweep.samples(2)["delay_ms"], [1.5, None])
        self.assertEqual(sweep.manifest, {"cells": 3})
        with self.assertRaisesRegex(NoSweep, r"lists cells \[1, 2, 3\]"):
            sweep.samples(9)

    def test_a_row_that_is_being_written_is_left_out(self) -> None:
        (self.folder / "runs.csv").write_text(RUNS[:-5])
        self.assertEqual(len(Sweep(self.folder).runs), 2)

    def test_of_a_running_sweep_the_last_row_of_a_cell_counts(self) -> None:
        head, *rows = RUNS.splitlines(keepends=True)
        (self.folder / "runs.csv").write_text(head + rows[2] + rows[0] + rows[1] + "3,3,10,1,1,ok,2,4\n")
        runs = Sweep(self.folder).runs
        self.assertEqual((runs["cell"], runs["status"]), ([1, 2, 3], ["ok", "ok", "ok"]))
        self.assertEqual(runs["delay_p50_ms"], [2.0, 1.25, 4.0])

    def test_a_table_without_rows_has_its_columns(self) -> None:
        (self.folder / "runs.csv").write_text(RUNS.splitlines(keepends=True)[0])
        self.assertEqual((len(Sweep(self.folder).runs), Sweep(self.folder).runs["cell"]), (0, []))

    def test_what_is_no_result_is_refused_in_one_sentence(self) -> None:
        with self.assertRaisesRegex(NoSweep, "no runs.csv"):
            Sweep(self.folder / "samples")
        for text, words in ((b"", "columns"), (b"\xff\n", "no text"), (b"a,b\n1\n", "row 2: has 1 fields")):
            (self.folder / "runs.csv").write_bytes(text)
            with self.assertRaisesRegex(NoSweep, words):
                Sweep(self.folder)
        (self.folder / "runs.csv").write_text(RUNS)
        (self.folder / "manifest.json").write_text("[")
        with self.assertRaises(NoSweep):
            _ = Sweep(self.folder).manifest

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "python3-pandas is not installed")
    def test_data_frames_have_the_types_too(self) -> None:
        frame = Sweep(self.folder).runs.to_pandas()
        self.assertEqual(
            {name: str(frame[name].dtype) for name in ("cell", "strikes", "delay_p50_ms", "qos")},
            {"cell": "int64", "strikes": "Int64", "delay_p50_ms": "float64", "qos": "object"},
        )
        self.assertEqual(frame.groupby("brokers").delay_p50_ms.mean().to_dict(), {1: 2.0, 3: 1.25})
        self.assertEqual(len(Table({"a": []}).to_pandas()), 0)


if __name__ == "__main__":
    unittest.main()
