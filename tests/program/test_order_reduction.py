#!/usr/bin/python3
"""Steps far above the waves of a stiff body: which order each method has left, as docs/work-precision.md tells."""
import csv
import unittest

from program import ROOT, ProgramTest

INPUT = ROOT / "input/convergence/stiff_body.yaml"


class OrderReduction(ProgramTest):
    def study(self, methods, levels):
        """Rows of each method; all numbers but its name."""
        done = self.call("converge", INPUT, "--in", "time", "--levels", levels, "--methods", ",".join(methods), "--no-check",
                         "--output", "out", timeout=400)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(self.directory / "out/convergence.csv", encoding="ascii", newline="") as file:
            rows = list(csv.DictReader(file))
        table = {}
        for row in rows:
            table.setdefault(row.pop("method"), []).append({name: float(value) for name, value in row.items()})
        self.assertEqual({name: len(rows) for name, rows in table.items()}, dict.fromkeys(methods, levels))
        return table

    def test_orders_that_are_left(self):
        table = self.study(["backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33"], levels=3)
        # Between steps of 20 and 10 ms; the margins are for a reference of finite accuracy, itself by dirk33.
        bounds = {  # lowest and highest order of displacement, of velocity
            "backward-euler": (0.85, 1.1, 0.85, 1.1),
            "bdf2": (1.5, 2.2, 1.8, 2.2),
            "bdf3": (2.6, 3.4, 2.6, 4.0),
            "dirk22": (1.1, 1.6, 0.8, 1.4),
            "dirk23": (1.9, 2.3, 1.0, 1.5),
            "dirk33": (1.1, 1.9, 1.2, 2.2),
        }
        for method, (low_u, high_u, low_v, high_v) in bounds.items():
            with self.subTest(method):
                row = table[method][-1]
                self.assertTrue(low_u < row["order_displacement"] < high_u, row)
                self.assertTrue(low_v < row["order_velocity"] < high_v, row)
        # What the orders come to: velocities of bdf3 are better than those of any method of several stages.
        for method in ("dirk22", "dirk23", "dirk33"):
            self.assertLess(table["bdf3"][-1]["error_velocity"], 0.2 * table[method][-1]["error_velocity"], method)


if __name__ == "__main__":
    unittest.main()
