"""Grafana's board shows what brokers really export: its names and labels are looked up on the pages of real brokers."""

import asyncio
import json
import os
import re
import socket
import tempfile
import unittest
import urllib.request
from pathlib import Path

from programs import Broker, Domain, free_port

BOARD = Path(os.environ["ROMANO_DASHBOARD"])
METRIC = re.compile(r"\b(?:romano|process)_\w+")
OF_PROMETHEUS = {"instance", "job", "le"}
"""Labels that Prometheus adds to each metric, or a histogram has."""


def labels_by_metric(page: str) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for line in page.splitlines():
        if line and not line.startswith("#"):
            name, _, rest = line.partition(" ")[0].partition("{")
            found.setdefault(name, set()).update(re.findall(r'(\w+)="', rest))
    return found


class Dashboard(unittest.IsolatedAsyncioTestCase):
    async def asyncSetUp(self) -> None:
        self.board = json.loads(BOARD.read_text())
        self.panels = [panel for panel in self.board["panels"] if panel["type"] != "row"]

    async def page(self, *options: str, host: str = "127.0.0.1", has: str = "romano_broker_info") -> str:
        """Of a broker with these options, as soon as it has that metric."""
        endpoint = f"127.0.0.1:{free_port(kind=socket.SOCK_STREAM)}"
        broker = Broker("--metrics", endpoint, *options, host=host)
        self.addAsyncCleanup(broker.kill)
        await broker.start()
        async with asyncio.timeout(60):
            while has not in (text := await asyncio.to_thread(read, f"http://{endpoint}/metrics")):
                await asyncio.sleep(0.2)
        return text

    async def exported(self) -> dict[str, set[str]]:
        """Of a lone broker with a store, and of one of a cluster of two with an uplink."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        domain = Domain()
        self.addCleanup(domain.free)
        of_lone = await self.page("--store", f"{folder.name}/store.db")
        cluster = ("--domain", str(domain.id), "--interface", "lo", "--detection-timeout-ms", "1000")
        uplink = ("--uplink", "mqtt://127.0.0.1:1", "--uplink-network", "test", "--uplink-topic", "a/#")
        host = f"127.77.{domain.id}"
        await self.page(*cluster, "--name", "r1", host=f"{host}.1")
        of_member = await self.page(
            *cluster, *uplink, "--name", "r2", host=f"{host}.2", has="romano_cluster_peer_alive"
        )
        return labels_by_metric(of_lone + of_member)

    async def test_every_metric_and_label_of_an_expression_is_exported(self) -> None:
        exported = await self.exported()
        for panel in self.panels:
            for target in panel["targets"]:
                text, names = target["expr"], METRIC.findall(target["expr"])
                with self.subTest(panel=panel["title"], expr=text):
                    self.assertTrue(names, "an expression without a metric")
                    self.assertEqual([name for name in names if name not in exported], [])
                    known = OF_PROMETHEUS.union(*(exported[name] for name in names))
                    used = set(re.findall(r"(\w+)=~?\"", text)) | set(re.findall(r"{{(\w+)}}", target["legendFormat"]))
                    for group in re.findall(r"\b(?:by|on) \(([^)]*)\)", text):
                        used |= {label.strip() for label in group.split(",")}
                    self.assertEqual(used - known, set())
        for query in (v["definition"] for v in self.board["templating"]["list"] if v["type"] == "query"):
            self.assertIn(METRIC.findall(query)[0], exported)

    async def test_load_and_condition_of_each_broker_are_shown(self) -> None:
        by_broker = [
            t["expr"] for panel in self.panels for t in panel["targets"] if "{{instance}}" in t["legendFormat"]
        ]
        for metric in ("romano_cluster_condition", "process_cpu_seconds_total", "romano_longest_turn_seconds"):
            self.assertTrue(any(metric in expr for expr in by_broker), metric)

    async def test_every_panel_has_a_title_and_a_unit(self) -> None:
        self.assertGreater(len(self.panels), 10)
        for panel in self.panels:
            self.assertTrue(panel["title"], panel)
            self.assertTrue(panel["fieldConfig"]["defaults"]["unit"], panel["title"])
        titles = [panel["title"] for panel in self.board["panels"]]
        self.assertEqual(sorted(set(titles)), sorted(titles))

    async def test_the_board_fits_any_grafana(self) -> None:
        for panel in self.panels:  # no source of data of somebody's own
            for place in (panel, *panel["targets"]):
                self.assertEqual(place["datasource"], {"type": "prometheus", "uid": "${datasource}"})
        ids = [panel["id"] for panel in self.board["panels"]]
        self.assertEqual(len(set(ids)), len(ids))
        cells = [(x, y) for panel in self.board["panels"] for p in [panel["gridPos"]]
                 for x in range(p["x"], p["x"] + p["w"]) for y in range(p["y"], p["y"] + p["h"])]  # fmt: skip
        self.assertEqual(len(set(cells)), len(cells), "panels that overlap")
        self.assertLess(max(x for x, _ in cells), 24)


def read(url: str) -> str:
    with urllib.request.urlopen(url, timeout=30) as response:
        text: str = response.read().decode()
    return text


if __name__ == "__main__":
    unittest.main()
