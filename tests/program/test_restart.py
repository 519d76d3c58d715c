#!/usr/bin/python3
"""A run that ends before its time, whatever ends it, goes on from its last checkpoint as if nothing had happened.

PLIANT_LONG_TESTS=1 kills each kind of run twenty times on each number of ranks: some minutes.
"""
import os
import random
import re
import shutil
import signal
import time
import unittest

import h5py
import numpy as np

from program import LONG, ProgramTest, box, finish, long_test, ranks_of, read_history, start, swept, write_box, write_mesh

METHODS = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33", "implicit-midpoint", "symplectic-dirk22")
ADAPTIVE = ("bdf3", "dirk23", "dirk33")  # each estimates its error in another way
PATIENCE = 900  # seconds: some runs that are killed again and again take two thousand steps, with a checkpoint every other
SAME_RANKS, OTHER_RANKS = 1e-10, 1e-7  # the second: what Newton's tolerance of 1e-10 leaves after many steps

BODY = """
title: going on
mesh: {file: box.msh}
bodies:
  - density: 1000
    elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}
    viscosity:
      - {model: prony, ratio: 0.5, relaxation_time: 50 ms}
      - {model: maxwell, shear_modulus: 10 kPa, relaxation_time: 20 ms}
constraints: [{surface: left, displacement: [0, 0, "0.02*sin(20*t)"]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 5 ms, end: 0.1}
solver: {newton: {relative: 1e-10}}
output: {fields: [displacement]}
checkpoint: {every: 4}
probes: [{name: tip, point: [0.5, 0.1, 0.1]}]
"""


def checkpoints(directory):
    return sorted(directory.glob("checkpoint-*.h5"))


class RestartTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.make_input()

    def make_input(self):
        write_box(self.directory / "box.msh", (3, 1, 1), (0.5, 0.1, 0.1))
        self.input = self.write("input.yaml", BODY)

    def out(self, name):
        return self.directory / name

    def resume(self, name, *arguments, ranks=1, timeout=120):
        done = self.call("resume", name, "--quiet", *arguments, ranks=ranks, timeout=timeout)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def text(self, name):
        return (self.out(name) / "history.csv").read_text()

    def started(self, arguments, ranks, rows):
        """A run that has written so many rows."""
        process = start(arguments, self.directory, ranks)
        history = self.out("out") / "history.csv"
        deadline = time.monotonic() + 60
        while not history.exists() or history.read_text().count("\n") <= rows:
            if process.poll() is not None:
                break
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.002)
        return process

    def assert_frames_are_the_rows(self, name):
        """A frame for each step, none twice, whole."""
        steps = read_history(self.out(name))["step"]
        np.testing.assert_array_equal(steps, np.arange(len(steps)))
        with h5py.File(self.out(name) / "result.h5") as file:
            frames = [frame.attrs["step"] for frame in file["frames"].values()]
            for frame in file["frames"].values():
                self.assertEqual(frame["displacement"].shape, file[frame.attrs["mesh"]]["coordinates"].shape)
        listed = re.findall(r'Name="step (\d+)"', (self.out(name) / "result.xdmf").read_text())
        self.assertEqual([int(step) for step in listed], frames)
        self.assertEqual(frames, list(steps))


class Continuation(RestartTest):
    def test_goes_on_to_the_last_digit(self):
        for method in ("bdf3", "symplectic-dirk22"):
            with self.subTest(method):
                self.check_steps(f"time.method={method}")
        for method in ADAPTIVE:
            with self.subTest(f"{method}, adaptive"):
                self.check_steps(f"time.method={method}", "time.adaptive={relative: 1e-2, absolute: 1e-3}")

    def test_what_else_has_a_state(self):
        cases = {
            "startup": ("time.method=bdf3", "time.startup=dirk33"),
            "events": ("time.method=bdf3", "time.events=[0.021]", 'loads=[{gravity: [0, 0, "t < 0.021 ? 0 : -9.81"]}]'),
            "quasistatic": ("time.method=quasistatic",),
            "static": ("time.method=static", "time.load_steps=12", "time.end=0.1",
                       'constraints=[{surface: left, displacement: [0, 0, 0]}]'),
            "P2": ("element=P2", "time.end=0.06"),
            "refined": ("mesh.refine=1", "time.end=0.06"),
            "mixed": ("element=P2", "volumetric=mixed", "time.end=0.04",
                      "bodies=[{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.5}}]"),
            "rigid": ('constraints=[{surface: left, displacement: [0, 0, 0]}, '
                      '{surface: right, rigid: {translation: [free, 0, "0.02*sin(20*t)"]}}]',),
            "cavity": ("time.end=0.06", "constraints=[{surface: left, displacement: [0, free, free]}, {surface: right, displacement: [0, free, free]}, "
                       "{surface: front, displacement: [free, 0, free]}, {surface: back, displacement: [free, 0, free]}, "
                       "{surface: top, displacement: [free, free, '0.002*sin(20*t)']}]",
                       "cavities=[{name: below, surface: bottom, volume: 1e-3, "
                       "liquid: {bulk_modulus: 1e5, added_volume: '1e-5*sin(20*t)'}}]"),
            "contact": ("contact={obstacles: [{name: floor, friction: 0.4, shape: plane, point: [0, 0, -2 mm], normal: [0, 0, 1]}]}",
                        "constraints=[]", "initial={velocity: [1, 0, -0.5]}", "time.end=0.06"),
            "friction by stages": ("time.method=dirk33", "time.end=0.08", "checkpoint.every=4", "time.step=10 ms",
                                   "contact={obstacles: [{name: floor, shape: plane, point: [0, 0, -5 mm], normal: [0, 0, 1], friction: 0.4}]}",
                                   "loads=[{gravity: [0, 0, -9.81]}, {surface: right, traction: [0, '2500*t', '-1500*t']}]"),
            "HDF5 mesh": ("mesh.file=box.h5", "time.end=0.06"),
            "multigrid": ("solver.linear=amg", "mesh.refine=2", "time.end=0.06"),
            "multigrid of an unsymmetric matrix": ("solver.linear=amg", "time.end=0.06", "loads=[{surface: top, pressure: 500}]"),
            "multigrid with pressures": ("solver.linear=amg", "time.end=0.06", "volumetric=mixed"),
            # On three ranks one of them has tensors alone, another single numbers alone.
            "two memories": ("mesh.file=two.msh", "time.end=0.06",
                             "bodies=[{volume: near, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, "
                             "poissons_ratio: 0.3}, viscosity: [{model: maxwell, shear_modulus: 10 kPa, relaxation_time: 20 ms}]}, "
                             "{volume: far, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, "
                             "poissons_ratio: 0.3}, mullins: {r: 2, m: 10}}]"),
        }
        elastic = "bodies=[{density: 1000, elasticity: {model: linear, youngs_modulus: 50 kPa, poissons_ratio: 0.3}}]"
        cases |= {f"PETSc's {name}": (f"time.method={{petsc: {name}}}", "time.end=0.06", elastic)
                  for name in ("alpha2", "bdf", "arkimex")}
        done = self.call("mesh", "convert", "box.msh", "box.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        points, sides, cells = box((6, 1, 1), (0.5, 0.1, 0.1))
        write_mesh(self.directory / "two.msh", points, sides, cells,
                   (["near", "far"], (points[cells].mean(axis=1)[:, 0] > 0.25).astype(int)))
        on_other_ranks = {"events": 2, "mixed": 3, "contact": 2, "two memories": 3}
        for number, (name, settings) in enumerate(cases.items()):
            with self.subTest(name):
                self.check_steps(*settings, ranks=on_other_ranks.get(name, 2 + number % 2 if LONG else None))

    def check_steps(self, *settings, ranks=None):
        """From the first of two checkpoints, on one rank to the last bit, on others to the accuracy of the solver."""
        for name in ("whole", "one", "several"):
            shutil.rmtree(self.out(name), ignore_errors=True)
        whole = self.run_input(self.input, *settings, output="whole")
        files = checkpoints(self.out("whole"))
        self.assertEqual(len(files), 2)
        for name in ("one", "several"):
            shutil.copytree(self.out("whole"), self.out(name))
            checkpoints(self.out(name))[-1].unlink()
        self.resume("one")
        self.assertEqual(self.text("one"), self.text("whole"))
        self.assertEqual([f.name for f in checkpoints(self.out("one"))], [f.name for f in files])
        if ranks is None:
            return
        self.resume("several", ranks=ranks)
        self.assert_same_history(whole, read_history(self.out("several")), OTHER_RANKS)

    def test_killed(self):
        """Each method once, from one number of ranks to another."""
        chance = self.chance()
        for number, method in enumerate(swept(METHODS, METHODS[1:2])):
            with self.subTest(method):
                ranks = (1 + number % 3, 1 + (number + 1) % 3)
                self.check_kills([f"time.method={method}", "time.end=0.2"], ranks, 1, chance)

    @long_test
    def test_killed_again_and_again(self):
        """Twenty times, on the same number of ranks or on each in turn, with fixed steps and with adaptive ones."""
        chance = self.chance()
        kinds = {method: [f"time.method={method}"] for method in METHODS}
        kinds |= {f"{method}, adaptive": [f"time.method={method}", "time.adaptive={relative: 2e-4, absolute: 2e-5, max_step: 5 ms}"]
                  for method in ADAPTIVE}
        for ranks in ((1, 2, 3), (1,), (2,), (3,)):
            for name, settings in kinds.items():
                with self.subTest(name, ranks=ranks):
                    self.check_kills([*settings, "time.end=2", "checkpoint.every=2"], ranks, 20, chance)

    def chance(self):
        seed = random.randrange(2**32)
        print("seed", seed)
        return random.Random(seed)

    def check_kills(self, settings, ranks, num_kills, chance):
        """A run that is killed at random moments, mostly once it has got on a little, and resumed on the ranks in turn."""
        shutil.rmtree(self.out("out"), ignore_errors=True)
        whole = self.run_input(self.input, *settings, ranks=ranks[0], output="whole", timeout=PATIENCE)
        arguments = ["run", self.input, "--quiet", "--output", "out"]
        arguments += [a for setting in settings for a in ("--set", setting)]
        for kill in range(num_kills):
            process = start(arguments, self.directory, ranks[kill % len(ranks)])
            if checkpoints(self.out("out")) and chance.random() < 0.2:
                time.sleep(chance.uniform(0.0, 1.0))  # whatever it does: it may not even have started
            else:
                self.wait_for_a_checkpoint(process)
                time.sleep(chance.uniform(0.0, 0.03))
            self.kill(process)
            arguments = ["resume", "out", "--quiet"]
        self.assertLess(len(self.text("out").splitlines()), 1 + len(whole["step"]), "ended before it was killed")
        self.resume("out", ranks=ranks[num_kills % len(ranks)], timeout=PATIENCE)
        tolerance = SAME_RANKS if len(ranks) == 1 else OTHER_RANKS
        self.assert_same_history(whole, read_history(self.out("out")), tolerance)
        self.assert_frames_are_the_rows("out")

    def wait_for_a_checkpoint(self, process):
        """Until there is one more, or the run is over."""
        before = checkpoints(self.out("out"))[-1:]
        deadline = time.monotonic() + 60
        while checkpoints(self.out("out"))[-1:] == before and process.poll() is None:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.002)

    def kill(self, process):
        for rank in ranks_of(process.pid):
            os.kill(rank, signal.SIGKILL)
        process.kill()
        finish(process, 30)

    def test_a_later_end_and_another_step(self):
        whole = self.run_input(self.input, output="whole")
        self.run_input(self.input, "time.end=0.05", output="part")
        self.resume("part", "--set", "time.end=0.1")
        self.assert_same_history(whole, read_history(self.out("part")), SAME_RANKS)
        resumed = self.pliant("resume", "part", "--set", "time.end=0.12", "--set", "time.step=2 ms")
        self.assertIn(" stages since the run was resumed, ", resumed.stdout)
        history = read_history(self.out("part"))
        self.assertEqual(history["time"][-1], 0.12)
        record = (self.out("part") / "run.yaml").read_text()
        refused = self.call("resume", "part", "--set", "time.end=0.1")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("time.end: the run is at t = 0.12 s already: give a later end", refused.stderr)
        self.assertEqual((self.out("part") / "run.yaml").read_text(), record)
        np.testing.assert_allclose(history["dt"][-10:], 0.002)
        self.assert_frames_are_the_rows("part")

    def test_a_run_that_ends_at_an_event_goes_on_from_it(self):
        """The row at the event shows the velocities before it: nothing follows, as far as that run knows."""
        stamped = 'constraints=[{surface: left, displacement: [0, 0, "0.5*min(t, 0.04)"]}]'
        cases = {"kink": (stamped,),
                 "jump": ('loads=[{gravity: [0, 0, "t < 0.04 ? 0 : -9.81"]}]',),
                 "jump of a store": ('bodies=[{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 50 kPa, poissons_ratio: 0.3}, '
                                     'expansion: {stretch: "t < 0.04 ? 1 : 1.02"}}]',),
                 "kink, stages": (stamped, "time.method=dirk23"),
                 "kink, several steps": (stamped, "time.method=bdf3", "time.startup=dirk33")}
        for name, settings in cases.items():
            with self.subTest(name):
                for directory in ("whole", "part"):
                    shutil.rmtree(self.out(directory), ignore_errors=True)
                whole = self.run_input(self.input, *settings, "checkpoint.every=8", output="whole")
                part = self.run_input(self.input, *settings, "checkpoint.every=8", "time.end=0.04", output="part")
                self.assertEqual(part["time"][-1], 0.04)
                self.resume("part", "--set", "time.end=0.1")
                rows = [self.text(directory).splitlines() for directory in ("part", "whole")]
                at_event = 1 + int(np.argmin(np.abs(whole["time"] - 0.04)))
                for of_run in rows:
                    del of_run[at_event]
                self.assertEqual(*rows)

    def test_what_a_static_run_depends_on(self):
        # Its end is the time of its loads, and load factors and lengths of paths do not mix.
        text = BODY.replace(BODY[BODY.index("    viscosity"):BODY.index("constraints")], "").replace(", \"0.02*sin(20*t)\"]", ", 0]")
        text = text.replace("method: bdf2, step: 5 ms, end: 0.1", "method: static, load_steps: 4, end: 3")
        steps = self.write("steps.yaml", text.replace("-9.81", '"-3*t"'))
        self.run_input(steps, output="steps")
        rows = (self.out("steps") / "history.csv").read_bytes()
        words = "a static analysis this is the time at which formulas of loads are evaluated"
        self.assertIn(words, self.refused("resume", "steps", "--set", "time.end=6"))
        self.assertIn(words, self.refused("run", steps, "--output", "steps", "--continue", "--set", "time.end=6"))
        self.assertIn("cannot begin one", self.refused("resume", "steps", "--set", "time.path.max_load=2"))
        path = self.write("path.yaml", text.replace("end: 3", "path: {max_load: 1, max_steps: 2}").replace("0, 0, -9.81", "1, 0, 0"))
        self.run_input(path, output="path")
        self.assertIn("cannot leave it", self.refused("resume", "path", "--set", "time.path=null"))
        self.assertEqual((self.out("steps") / "history.csv").read_bytes(), rows)

    def refused(self, *arguments):
        done = self.call(*arguments)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        return done.stderr

    def test_elsewhere(self):
        """Results may go to another directory; the place from which the program is called does not matter."""
        self.run_input(self.input, output="whole")
        first = checkpoints(self.out("whole"))[0]
        done = self.resume(first, "--output", "more", "--", "-ksp_max_it", "5000")
        self.assertIn("the run had the PETSc options '', now they are '", done.stderr)
        whole, more = read_history(self.out("whole")), read_history(self.out("more"))
        step = int(first.stem.rsplit("-", 1)[1])
        self.assertEqual(self.text("more").splitlines()[1:], self.text("whole").splitlines()[step + 2:])
        self.assertEqual(len(checkpoints(self.out("whole"))), 2)
        self.assertEqual(more["step"][-1], whole["step"][-1])


    def test_the_same_command_again(self):
        """`run --continue` begins a run, goes on with it, or leaves it, whichever is to be done."""
        def again(*settings, ranks=1, code=0):
            settings = [a for setting in settings for a in ("--set", setting)]
            done = self.call("run", self.input, "--continue", "--output", "out", *settings, ranks=ranks)
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            return done.stdout + done.stderr

        whole = self.run_input(self.input, output="whole")
        self.assertNotIn("resuming", again())
        self.assertEqual(self.text("out"), self.text("whole"))
        made = (self.out("out") / "result.h5").stat().st_mtime_ns
        self.assertIn("done already\nresults: out/", again())
        self.assertEqual((self.out("out") / "result.h5").stat().st_mtime_ns, made)

        (self.out("out") / "summary.json").unlink()  # as if it had been killed before the last checkpoint
        checkpoints(self.out("out"))[-1].unlink()
        self.assertIn("resuming from out/checkpoint-000016.h5", again())
        self.assertEqual(self.text("out"), self.text("whole"))
        again("time.end=0.12", "time.step=4 ms", ranks=2)
        history = read_history(self.out("out"))
        self.assertEqual(history["time"][-1], 0.12)
        self.assertEqual(list(history["tip_z"][:len(whole["step"])]), list(whole["tip_z"]))

        for settings in (("time.method=bdf3",), ("bodies.0.density=1001", "time.end=1")):
            said = again(*settings, ranks=2, code=2)
            self.assertIn("'out' holds a run of another input: '", said)
        self.assertIn("'- density: 1000' then, '- density: 1001' now", said)
        for file in checkpoints(self.out("out")):
            file.unlink()
        self.assertIn("another input", again("time.method=bdf3", code=2))
        self.assertNotIn("resuming", again())  # a shorter run, and nothing to go on from
        self.assertEqual(self.text("out"), self.text("whole"))


class Signals(RestartTest):
    ENDLESS = ["--set", "time.end=100"]

    def test_stopped(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number.name):
                shutil.rmtree(self.out("out"), ignore_errors=True)
                process = self.started(["run", self.input, "--output", "out", *self.ENDLESS], 1, 6)
                process.send_signal(number)
                done = finish(process, 30)
                self.assertEqual(done.returncode, 130, done.stderr)
                step = int(read_history(self.out("out"))["step"][-1])
                self.assertEqual(checkpoints(self.out("out"))[-1].name, f"checkpoint-{step:06}.h5")
                command = re.search(r"to continue: pliant (resume .*)", done.stderr).group(1).split()
                # The end as it would have been.
                done = self.call(*command, "--quiet", "--set", f"time.end={0.005 * (step + 4)}")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(read_history(self.out("out"))["step"][-1], step + 4)
                self.assert_frames_are_the_rows("out")

    def test_the_frame_of_an_interruption_does_not_stay(self):
        process = self.started(["run", self.input, "--output", "out", "--set", "output.every=1000", *self.ENDLESS], 1, 6)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(finish(process, 30).returncode, 130)
        with h5py.File(self.out("out") / "result.h5") as file:
            self.assertEqual(len(file["frames"]), 2)
        end = read_history(self.out("out"))["time"][-1] + 0.02
        self.resume("out", "--set", f"time.end={end}")
        with h5py.File(self.out("out") / "result.h5") as file:
            self.assertEqual([frame.attrs["time"] for frame in file["frames"].values()], [0, end])

    def test_asked_for_a_checkpoint(self):
        process = self.started(["run", self.input, "--output", "out", "--set", "checkpoint.every=1000000", *self.ENDLESS], 1, 3)
        self.assertEqual(checkpoints(self.out("out")), [])
        process.send_signal(signal.SIGUSR1)
        deadline = time.monotonic() + 30
        while not checkpoints(self.out("out")):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        rows = len(self.text("out").splitlines())
        while len(self.text("out").splitlines()) <= rows:  # it goes on
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        self.assertEqual(finish(process, 30).returncode, 130)

    def test_by_the_clock(self):
        self.run_input(self.input, "checkpoint={minutes: 1e-9}", "time.end=0.02")
        names = [file.name for file in checkpoints(self.out("out"))]
        self.assertEqual(names, ["checkpoint-000003.h5", "checkpoint-000004.h5"])

    def test_a_failed_solve(self):
        """The last good state is kept; what failed may be tried another way."""
        broken = 'loads=[{gravity: [0, 0, "t < 0.0401 ? -9.81 : sqrt(0.0401 - t)"]}]'
        done = self.call("run", self.input, "--quiet", "--output", "out", "--set", broken)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("pliant resume out", done.stderr)
        last = read_history(self.out("out"))
        self.resume("out", "--set", f"time.end={last['time'][-1]!r}")
        self.assertEqual(read_history(self.out("out"))["step"][-1], last["step"][-1])


class Damage(RestartTest):
    @classmethod
    def setUpClass(cls):
        """One run, which each test damages a copy of."""
        first = cls("test_info")
        super(Damage, first).setUp()
        cls.addClassCleanup(first.doCleanups)
        first.run_input(first.input, "time.end=0.04")
        cls.original = first.directory

    def make_input(self):
        if not hasattr(self, "original"):
            super().make_input()

    def setUp(self):
        super().setUp()
        shutil.copytree(self.original, self.directory, dirs_exist_ok=True)
        self.input = self.directory / "input.yaml"
        self.older, self.newer = checkpoints(self.out("out"))
        self.whole = self.text("out")

    def fails(self, code, *words, place="out", numbers_of_ranks=(1,)):
        """With one message."""
        for ranks in numbers_of_ranks:
            done = self.call("resume", place, "--quiet", ranks=ranks)
            self.assertEqual(done.returncode, code, done.stderr)
            lines = [line for line in done.stderr.splitlines() if "heckpoint" in line or "mesh" in line]
            self.assertEqual(len(lines), 1, done.stderr)
            for word in words:
                self.assertIn(word, lines[0])

    def flip(self, file, place):
        data = bytearray(file.read_bytes())
        data[place] ^= 0x10
        file.write_bytes(data)

    def test_the_one_before_takes_over(self):
        self.flip(self.newer, self.newer.stat().st_size // 2)
        done = self.resume("out")
        self.assertIn("checksum", done.stderr)
        self.assertIn(self.older.name, done.stderr)
        self.assertEqual(self.text("out"), self.whole)
        self.call("info", self.newer)

    def test_every_byte_counts(self):
        self.older.unlink()
        data = self.newer.read_bytes()
        for place in (0, 40, 500, 512, len(data) // 3, len(data) - 1):
            with self.subTest(place):
                self.newer.write_bytes(data)
                self.flip(self.newer, place)
                done = self.call("resume", "out", "--quiet")
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)

    def test_cut_short(self):
        self.older.unlink()
        data = self.newer.read_bytes()
        for size in (0, 100, 512, len(data) - 1):
            with self.subTest(size):
                self.newer.write_bytes(data[:size])
                self.assertEqual(self.call("resume", "out", "--quiet").returncode, 4)
        self.fails(4, "damaged", str(len(data)))

    def test_another_version(self):
        self.older.unlink()
        self.newer.write_bytes(self.newer.read_bytes().replace(b"version 5", b"version 1", 1))
        self.fails(4, "another version", numbers_of_ranks=(1, 2))

    def test_no_checkpoint(self):
        self.fails(4, "not a checkpoint of Pliant", place=self.write("checkpoint-text.h5", "hello"))
        self.fails(4, "not a checkpoint of Pliant", place=self.out("out") / "result.h5")
        (self.directory / "empty").mkdir()
        self.fails(4, "no checkpoint", place="empty")
        done = self.call("resume", "nothing")
        self.assertEqual((done.returncode, done.stderr), (4, "there is no file 'nothing'\n"))

    def test_another_mesh(self):
        self.run_input(self.input, "time.end=0.04")  # its checkpoints know this directory's mesh
        write_box(self.directory / "box.msh", (3, 1, 1), (0.5, 0.1, 0.1000001))
        self.fails(2, "box.msh", "restore that mesh", numbers_of_ranks=(1, 2))
        (self.directory / "box.msh").unlink()
        self.fails(2, "box.msh")

    def test_changes_that_are_none(self):
        done = self.call("resume", "out", "--set", "bodies[0].density=2", "--set", "element=P2")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count("cannot change when a run is resumed"), 2)
        done = self.call("resume", "out", "--set", "time.end=1 m")
        self.assertEqual(done.returncode, 2, done.stderr)

    def test_info(self):
        done = self.call("info", self.newer)
        self.assertEqual(done.returncode, 0)
        for word in ("going on", "after step 8 at t = 0.04", "youngs_modulus"):
            self.assertIn(word, done.stdout)
        done = self.call("info", self.out("out") / "result.h5")
        self.assertIn("9 frames from t = 0 to 0.04", done.stdout)
        self.assertIn(f"run: done\nnewest checkpoint: {self.newer.name}\n", done.stdout)
        (self.out("out") / "summary.json").unlink()
        done = self.call("info", self.out("out"))
        self.assertIn(f"run: not ended; it continues, or was killed\nnewest checkpoint: {self.newer.name}; to continue: pliant resume {self.out('out')}\n",
                      done.stdout)
        self.assertEqual(self.call("info", self.input).returncode, 4)

    def test_results_that_are_damaged(self):
        """HDF5 cannot close a file that says of itself that it was written by another driver."""
        result = self.out("out") / "result.h5"
        data = bytearray(result.read_bytes())
        data[48:56] = (11).to_bytes(8, "little")  # where the address of the driver's information stands, which none of ours has
        result.write_bytes(data)
        for ranks in (1, 2):
            done = self.call("resume", self.older, "--quiet", ranks=ranks)
            self.assertEqual(done.returncode, 4, done.stderr)
            told = [line for line in done.stderr.splitlines() if "result.h5" in line]
            self.assertEqual(len(told), 1, done.stderr)
            self.assertNotIn("HDF5", done.stderr)
            self.assertNotIn("signal", done.stderr)
        command = re.search(r"pliant (resume .*) DIR", told[0]).group(1).split()
        self.resume(*command[1:], "elsewhere")
        self.assertEqual(self.text("elsewhere").splitlines()[-1], self.whole.splitlines()[-1])

    def test_a_directory_that_cannot_be_written(self):
        """A checkpoint that cannot be written ends the run, and leaves the one before as it was."""
        data = self.newer.read_bytes()
        (self.out("out") / "checkpoint-000012.h5.part").mkdir()  # where the next one would be written
        done = self.call("resume", "out", "--quiet", "--set", "time.end=0.06")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("checkpoint-000012.h5.part", done.stderr)
        self.assertEqual(checkpoints(self.out("out"))[-1].read_bytes(), data)


if __name__ == "__main__":
    unittest.main()
