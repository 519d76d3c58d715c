#!/usr/bin/python3
"""What the machine does to a run: full disks, vanished files, killed ranks, little memory. One message, nothing lost, no hang."""
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np

from program import ProgramTest, finish, long_test, ranks_of, read_history, start, swept, write_box

BODY = """
title: a machine with faults
mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}}]
constraints: [{surface: left, displacement: [0, 0, "0.02*sin(20*t)"]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 5 ms, end: 1000}
output: {fields: [displacement, cauchy_stress]}
checkpoint: {every: 5}
"""
NOISE = ("PETSC ERROR", "Traceback", "terminate called", "Segmentation", "PetscFailure", "HDF5-DIAG", "MPI_ABORT")


class FaultTest(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "box.msh", (5, 2, 2), (0.5, 0.1, 0.1))
        self.input = self.write("input.yaml", BODY)
        self.out = self.directory / "disk/out"
        self.out.parent.mkdir()

    def going(self, ranks, rows, *arguments):
        """A run that has written so many rows of its history."""
        process = start(["run", self.input, "--quiet", "--output", self.out, *arguments], self.directory, ranks)
        history = self.out / "history.csv"
        deadline = time.monotonic() + 60
        while not history.exists() or history.read_text().count("\n") <= rows:
            self.assertIsNone(process.poll(), "ended by itself")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        return process

    def told(self, done, code):
        """The one message of a run that ended with this code."""
        told = re.sub(r"-{20,}\n.*?-{20,}\n", "", done.stderr, flags=re.DOTALL)  # mpirun's own
        lines = [line for line in told.splitlines() if line]
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        self.assertEqual(len(lines), 1, done.stderr)
        for noise in NOISE:
            self.assertNotIn(noise, done.stdout + done.stderr)
        return lines[0]

    def checkpoints(self):
        return sorted(self.out.glob("checkpoint-*.h5"))

    def assert_whole(self):
        """Whatever is listed can be read, rows have all their columns; returns them."""
        history = read_history(self.out)
        np.testing.assert_array_equal(history["step"], np.arange(len(history["step"])))
        series = xml.etree.ElementTree.parse(self.out / "result.xdmf")
        frames = series.findall(".//Grid[@GridType='Uniform']")
        self.assertGreater(len(frames), 0)
        with h5py.File(self.out / "result.h5") as file:
            for frame in frames:
                for item in frame.iter("DataItem"):
                    self.assertTrue(np.isfinite(file[item.text.strip().split(":")[1]][()]).all())
        for file in self.checkpoints():
            self.assertEqual(self.call("info", file).returncode, 0)
        return history


class Files(FaultTest):
    def test_a_full_disk(self):
        """A file system of a megabyte, which fills; with more room the run goes on."""
        disk = self.out.parent
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "tmpfs", disk], check=False, capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("a small file system cannot be mounted here")
        self.addCleanup(subprocess.run, ["umount", disk], check=True)
        # What does not fit is a frame, a checkpoint, or a row of the history: whatever is written most.
        kinds = (("frames", 1, ()), ("frames", 2, ()), ("checkpoints", 2, ("output.every=1000", "checkpoint.every=1")),
                 ("rows", 1, ("output.every=1000", "checkpoint.every=100000")))
        for kind, ranks, settings in swept(kinds, kinds[::2]):
            with self.subTest(kind, ranks=ranks):
                self.fill(disk, settings, ranks, leave=80 if kind == "rows" else 0)

    def fill(self, disk, settings, ranks, leave):
        for file in disk.iterdir():
            shutil.rmtree(file) if file.is_dir() else file.unlink()
        subprocess.run(["mount", "-o", "remount,size=1m", disk], check=True)
        changes = [a for setting in settings for a in ("--set", setting)]
        process = self.going(ranks, 12, *changes)
        if settings:  # these write too little to wait for: something else takes the room
            with open(disk / "ballast", "wb", buffering=0) as ballast:
                room = os.statvfs(disk)
                block = b"\0" * 4096
                for _ in range(room.f_bavail - leave * 1024 // room.f_bsize):
                    try:
                        ballast.write(block)
                    except OSError:
                        break
        message = self.told(finish(process, 60), 4)
        self.assertIn("No space left on device", message)
        self.assertIn(str(self.out), message)
        rows = self.assert_whole()
        self.assertIn(f"step {rows['step'][-1]:.0f}", message)
        if not self.checkpoints():
            self.assertIn("no checkpoint", message)
            return
        command = re.search(r"pliant (resume \S+)", message).group(1).split()
        subprocess.run(["mount", "-o", "remount,size=16m", disk], check=True)
        last = int(self.checkpoints()[-1].stem.rsplit("-", 1)[1])
        done = self.call(*command, "--quiet", "--set", f"time.end={0.005 * (last + 6)}", ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stderr)
        again = self.assert_whole()
        self.assertEqual(again["step"][-1], last + 6)

    def test_what_vanishes(self):
        """The directory, or a file that is written to."""
        cases = (("", 1), ("result.h5", 2), ("", 2), ("history.csv", 1))
        for name, ranks in swept(cases, cases[:2]):
            with self.subTest(name or "the directory", ranks=ranks):
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.going(ranks, 12)
                gone = self.out / name if name else self.out
                gone.rename(self.directory / "taken")
                message = self.told(finish(process, 60), 4)
                self.assertIn(str(self.out), message)
                if not name:
                    self.assertIn("is gone", message)
                    self.assertNotIn("resume", message)
                    shutil.rmtree(self.directory / "taken")
                    continue
                (self.directory / "taken").unlink()
                command = re.search(r"pliant (resume \S+)", message).group(1).split()
                last = int(self.checkpoints()[-1].stem.rsplit("-", 1)[1])
                done = self.call(*command, "--quiet", "--set", f"time.end={0.005 * (last + 3)}", ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(read_history(self.out)["step"][-1], last + 3)

    def test_a_limit_of_the_size_of_files(self):
        """`ulimit -f`, from one moment to the next."""
        process = self.going(1, 12)
        size = (self.out / "result.h5").stat().st_size
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (size, size))
        message = self.told(finish(process, 60), 4)
        self.assertIn("File too large", message)
        self.assertIn(f"rows up to step {self.assert_whole()['step'][-1]:.0f}", message)

    def test_read_only_from_now_on(self):
        """A mount over the directory that may not be written to: what is opened from then on."""
        for ranks in swept((1, 2), (1,)):
            with self.subTest(ranks=ranks):
                view = self.directory / f"view-{ranks}"
                view.mkdir()
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.going(ranks, 12)
                mounted = subprocess.run(["mount", "--bind", self.out, view], check=False, capture_output=True)
                if mounted.returncode != 0:
                    process.kill()
                    finish(process, 60)
                    self.skipTest("directories cannot be mounted here")
                self.addCleanup(subprocess.run, ["umount", view], check=True)
                # Read-only where nobody writes, then put over the directory: done at once.
                subprocess.run(["mount", "-o", "remount,bind,ro", view], check=True)
                subprocess.run(["mount", "--bind", view, self.out], check=True)
                self.addCleanup(subprocess.run, ["umount", "--quiet", self.out], check=False)
                message = self.told(finish(process, 60), 4)
                self.assertIn(str(self.out), message)
                self.assertIn("Read-only file system", message)
                subprocess.run(["umount", self.out], check=True)
                last = int(self.assert_whole()["step"][-1])
                self.assertIn(f"rows up to step {last}", message)
                command = re.search(r"pliant (resume \S+)", message).group(1).split()
                done = self.call(*command, "--quiet", "--set", f"time.end={0.005 * (last + 3)}", ranks=ranks)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(self.assert_whole()["step"][-1], last + 3)


class Ranks(FaultTest):
    def test_a_killed_rank(self):
        """mpirun says so, once, and all ends at once."""
        for victim in swept((0, 1), (0,)):
            with self.subTest(victim):
                shutil.rmtree(self.out, ignore_errors=True)
                process = self.going(2, 12)
                ranks = ranks_of(process.pid)
                self.assertEqual(len(ranks), 2)
                os.kill(ranks[victim], signal.SIGKILL)
                done = finish(process, 60)
                self.assertNotEqual(done.returncode, 0)
                self.assertEqual(done.stderr.count("exited on signal 9"), 1, done.stderr)
                for noise in NOISE:
                    self.assertNotIn(noise, done.stdout + done.stderr)
                self.assertEqual(ranks_of(process.pid), [])
                last = int(self.checkpoints()[-1].stem.rsplit("-", 1)[1])
                done = self.call("resume", self.out, "--quiet", "--set", f"time.end={0.005 * (last + 3)}", ranks=2)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(read_history(self.out)["step"][-1], last + 3)

    @long_test
    def test_killed_at_any_moment(self):
        """Twenty times on two ranks and on three: all ends at once, what is listed can be read, and the run goes on."""
        seed = random.randrange(2**32)
        print("seed", seed)
        chance = random.Random(seed)
        longest = 0.0
        for number in range(40):
            num_ranks = 2 + number % 2
            with self.subTest(number, ranks=num_ranks):
                shutil.rmtree(self.out, ignore_errors=True)
                # Most of the time goes into files: it is there that a kill may do harm.
                process = self.going(num_ranks, chance.randrange(8, 20), "--set", "checkpoint.every=1")
                ranks = ranks_of(process.pid)
                self.assertEqual(len(ranks), num_ranks)
                time.sleep(chance.uniform(0.0, 0.2))
                os.kill(chance.choice(ranks), signal.SIGKILL)
                killed = time.monotonic()
                done = finish(process, 60)
                longest = max(longest, time.monotonic() - killed)
                self.assertNotEqual(done.returncode, 0)
                self.assertEqual(done.stderr.count("exited on signal 9"), 1, done.stderr)
                for noise in NOISE:
                    self.assertNotIn(noise, done.stdout + done.stderr)
                self.assertEqual(ranks_of(process.pid), [])
                self.assert_whole()
                last = int(self.checkpoints()[-1].stem.rsplit("-", 1)[1])
                done = self.call("resume", self.out, "--quiet", "--set", f"time.end={0.005 * (last + 3)}", ranks=num_ranks)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(self.assert_whole()["step"][-1], last + 3)
        print(f"ended within {longest:.1f} s")
        self.assertLess(longest, 10.0)


class Memory(FaultTest):
    """MUMPS is allowed a megabyte per rank (ICNTL(23)), less than the factors take."""

    LIMIT = ("--", "-mat_mumps_icntl_23", "1")

    def setUp(self):
        super().setUp()
        write_box(self.directory / "box.msh", (20, 6, 6), (0.5, 0.1, 0.1))

    def run_with(self, *settings, limit=(), ranks=1):
        arguments = [a for setting in ("time.end=0.02", "output.every=1", *settings) for a in ("--set", setting)]
        return self.call("run", self.input, "--quiet", "--output", self.out, *arguments, *limit, ranks=ranks)

    def test_multigrid_takes_over(self):
        for ranks in swept((1, 2), (1,)):
            with self.subTest(ranks=ranks):
                self.assertEqual(self.run_with("solver.newton.relative=1e-10").returncode, 0)
                expected = read_history(self.out)
                done = self.run_with("solver.newton.relative=1e-10", limit=self.LIMIT, ranks=ranks)
                self.assertIn("multigrid takes its place", self.told(done, 0))
                self.assert_same_history(expected, read_history(self.out), 1e-7)

    def test_what_cannot_do_without_says_so(self):
        """Pressures as unknowns: the matrix is indefinite, nothing but a factorization solves it."""
        for ranks in swept((1, 2), (2,)):
            with self.subTest(ranks=ranks):
                write_box(self.directory / "box.msh", (8, 3, 3), (0.5, 0.1, 0.1))
                done = self.run_with("element=P2", "volumetric=mixed", limit=self.LIMIT, ranks=ranks)
                message = self.told(done, 3)
                self.assertIn("too little memory", message)
                self.assertIn("more memory", message)


if __name__ == "__main__":
    unittest.main()
