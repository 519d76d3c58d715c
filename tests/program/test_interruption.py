#!/usr/bin/python3
"""A run that is interrupted ends in order: exit code 130, everything computed so far is on disk and can be read."""
import os
import shutil
import signal
import time
import unittest

import h5py

from program import ROOT, ProgramTest, finish, ranks_of, read_history, start

INPUT = ROOT / "input/beam_small.yaml"


class Interruption(ProgramTest):
    def going(self, ranks):
        shutil.rmtree(self.directory / "out", ignore_errors=True)
        process = start(["run", INPUT, "--output", "out", "--set", "time.end=1000"], self.directory, ranks)
        history = self.directory / "out/history.csv"
        deadline = time.monotonic() + 60
        while not history.exists() or history.read_text().count("\n") < 4:
            self.assertIsNone(process.poll(), "ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        return process

    def assert_files_are_whole(self):
        history = read_history(self.directory / "out")
        self.assertGreaterEqual(len(history["step"]), 3)
        with h5py.File(self.directory / "out/result.h5") as file:
            self.assertEqual(len(file["frames"]), len(history["step"]))
            for frame in file["frames"].values():
                self.assertEqual(frame["displacement"].shape, file["mesh/coordinates"].shape)
        return history

    def test_signals(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                process = self.going(1)
                process.send_signal(number)
                done = finish(process, 30)
                self.assertEqual(done.returncode, 130, done.stderr)
                history = self.assert_files_are_whole()
                self.assertIn(f"interrupted after step {history['step'][-1]:.0f}", done.stderr)

    def test_a_signal_to_one_rank_stops_all(self):
        process = self.going(2)
        ranks = ranks_of(process.pid)
        self.assertEqual(len(ranks), 2)
        os.kill(ranks[1], signal.SIGTERM)
        done = finish(process, 30)
        self.assertEqual(done.returncode, 130, done.stderr)
        self.assertEqual(done.stderr.count("interrupted after step"), 1)
        self.assert_files_are_whole()

    def test_signals_to_mpirun(self):
        # mpirun passes the signal on, waits for a while, and has an exit code of its own.
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                process = self.going(2)
                process.send_signal(number)
                done = finish(process, 30)
                self.assertNotEqual(done.returncode, 0)
                self.assertEqual(done.stderr.count("interrupted after step"), 1, done.stderr)
                self.assert_files_are_whole()

    def test_a_run_that_is_killed_leaves_readable_files(self):
        process = self.going(1)
        process.kill()
        finish(process, 30)
        history = read_history(self.directory / "out")
        with h5py.File(self.directory / "out/result.h5") as file:
            self.assertGreaterEqual(len(file["frames"]), len(history["step"]) - 1)


if __name__ == "__main__":
    unittest.main()
