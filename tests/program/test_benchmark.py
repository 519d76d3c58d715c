#!/usr/bin/python3
"""The benchmarks of whole runs print their tables; timings decide nothing here."""
import subprocess
import sys
import unittest

from program import ROOT, ProgramTest


class Benchmark(ProgramTest):
    def test_pliant_alone(self):
        done = subprocess.run([ROOT / "tools/bench.sh", "--sizes", "S", "--repeats", "1", "--peers"], capture_output=True,
                              text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split("|")[1:-1] for line in done.stdout.splitlines() if line.startswith("| beam")]
        self.assertEqual([row[3].strip() for row in rows], ["1", "2"])
        for row in rows:
            seconds, newton, megabytes = map(float, row[4:])
            self.assertGreater(seconds, 0)
            self.assertGreaterEqual(newton, 1)
            self.assertGreater(megabytes, 10)

    def test_counts_on_more_ranks(self):
        done = subprocess.run([sys.executable, ROOT / "tools/scaling.py", "--bodies", "S", "--solvers", "amg", "--ranks", "1", "3"],
                              capture_output=True, text=True, timeout=300, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in done.stdout.splitlines() if line.startswith("| S")]
        self.assertEqual([row[:4] for row in rows], [["S", "6,480", "amg", "1"], ["S", "6,480", "amg", "3"]])
        self.assertEqual(rows[0][4:7], ["1", "0", "0"])
        load, ghosts, neighbours = map(float, rows[1][4:7])
        self.assertTrue(1 <= load < 1.1, load)
        # A beam of 31 x 7 x 7 nodes in three pieces: two cuts, on both sides of which a layer of about 49 nodes is doubled.
        self.assertTrue(0.05 < ghosts < 0.3, ghosts)
        self.assertTrue(1 <= neighbours <= 2, neighbours)
        for row in rows:
            newton, linear, fullest, memory = map(float, row[7:])
            self.assertGreaterEqual(newton, 1)
            self.assertGreaterEqual(linear, 1)
            self.assertTrue(10 < fullest <= memory, row)


if __name__ == "__main__":
    unittest.main()
