#!/usr/bin/python3
"""The benchmark of whole runs prints its table; timings decide nothing here."""
import subprocess
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


if __name__ == "__main__":
    unittest.main()
