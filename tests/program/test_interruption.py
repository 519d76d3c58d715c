#!/usr/bin/python3
"""A run that is interrupted ends in order: exit code 130, everything computed so far is on disk and can be read."""
import json
import os
import shutil
import signal
import time
import unittest

import h5py

from program import ROOT, ProgramTest, finish, ranks_of, read_history, start

INPUT = ROOT / "input/beam_small.yaml"


class Interruption(ProgramTest):
    def going(self, ranks, environment=None, *options):
        shutil.rmtree(self.directory / "out", ignore_errors=True)
        process = start(["run", INPUT, "--output", "out", "--set", "time.end=1000", *options], self.directory, ranks, environment)
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
        self.addCleanup(signal.signal, signal.SIGHUP, signal.signal(signal.SIGHUP, signal.SIG_DFL))  # nohup before the tests
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGXCPU, signal.SIGUSR2):
            with self.subTest(number.name):
                process = self.going(1)
                process.send_signal(number)
                done = finish(process, 30)
                self.assertEqual(done.returncode, 130, done.stderr)
                history = self.assert_files_are_whole()
                self.assertIn(f"interrupted after step {history['step'][-1]:.0f}", done.stderr)

    def test_nohup(self):
        self.addCleanup(signal.signal, signal.SIGHUP, signal.signal(signal.SIGHUP, signal.SIG_IGN))
        process = self.going(1)
        process.send_signal(signal.SIGHUP)
        rows = self.num_rows()
        while self.num_rows() < rows + 3:
            self.assertIsNone(process.poll(), "ended by SIGHUP")
            time.sleep(0.02)
        process.send_signal(signal.SIGTERM)
        done = finish(process, 30)
        self.assertEqual(done.returncode, 130, done.stderr)

    def test_who_reads_along_ends_first(self):
        """As `tee` does at Ctrl-C."""
        process = self.going(1)
        process.stdout.close()
        process.stdout = None
        rows = self.num_rows()
        while self.num_rows() < rows + 3:
            self.assertIsNone(process.poll(), "ended by SIGPIPE")
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        self.assertEqual(finish(process, 30).returncode, 130)
        self.assert_files_are_whole()

    def num_rows(self):
        return (self.directory / "out/history.csv").read_text().count("\n")

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
        # mpirun has an exit code of its own and, unless the signal is SIGUSR2, waits for a while, passes it on, waits
        # again and kills the ranks. A busy machine may need more than the usual second to get to the end of the step.
        # While it waits, mpirun reads nothing (the run is quiet, else it might stand still) and may end before it has
        # passed on what the ranks wrote: what they left on disk decides.
        patient = {"OMPI_MCA_odls_base_sigkill_timeout": "3"}
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR2):
            with self.subTest(number.name):
                process = self.going(2, patient, "--quiet")
                process.send_signal(number)
                done = finish(process, 60)
                if number == signal.SIGUSR2:
                    self.assertEqual(done.returncode, 130)
                    self.assertEqual(done.stderr.count("interrupted after step"), 1, done.stderr)
                else:
                    self.assertIn(done.returncode, (1, 130))
                    self.assertLessEqual(done.stderr.count("interrupted after step"), 1, done.stderr)
                history = self.assert_files_are_whole()
                summary = json.loads((self.directory / "out/summary.json").read_text())
                self.assertEqual(summary["outcome"], "interrupted")

    def test_a_run_that_is_killed_leaves_readable_files(self):
        process = self.going(1)
        process.kill()
        finish(process, 30)
        history = read_history(self.directory / "out")
        with h5py.File(self.directory / "out/result.h5") as file:
            self.assertGreaterEqual(len(file["frames"]), len(history["step"]) - 1)


if __name__ == "__main__":
    unittest.main()
