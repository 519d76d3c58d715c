#!/usr/bin/python3
"""A sweep runs every combination of the values, each as `pliant run` would, and puts together what came of them."""
import csv
import json
import shutil
import signal
import time
import unittest
from xml.etree import ElementTree

import numpy as np

from program import ROOT, ProgramTest, finish, read_history, start

INPUT = ROOT / "input/beam_small.yaml"


class Sweep(ProgramTest):
    def sweep(self, *settings, options=(), code=0):
        shutil.rmtree(self.directory / "out", ignore_errors=True)
        arguments = ["sweep", INPUT, "--output", "out", *options]
        for setting in settings:
            arguments += ["--set", setting]
        done = self.call(*arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def rows(self):
        with open(self.directory / "out/sweep.csv", encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_every_combination_is_run(self):
        done = self.sweep("time.method=[bdf2, backward-euler]", "time.step=['10 ms', 20 ms]", "time.end=40 ms",
                          "loads.0.gravity=[0, 0, -1]")
        rows = self.rows()
        self.assertEqual([(row["time.method"], row["time.step"]) for row in rows],
                         [("bdf2", "10 ms"), ("bdf2", "20 ms"), ("backward-euler", "10 ms"), ("backward-euler", "20 ms")])
        for row in rows:
            self.assertEqual(row["exit_code"], "0")
            self.assertRegex(done.stdout, rf"(?m)^{row['time.method']} +{row['time.step']} +done +{row['step']} ")
            history = read_history(self.directory / "out" / row["directory"])
            self.assertEqual(float(row["tip_z"]), history["tip_z"][-1])
        alone = self.run_input(INPUT, "time.end=40 ms", "loads.0.gravity=[0, 0, -1]", "time.step=20 ms", "time.method=bdf2",
                               output="alone")
        self.assert_same_history(alone, read_history(self.directory / "out" / rows[1]["directory"]), 1e-12)
        for name in ("tip_z", "kinetic_energy"):
            text = "".join(ElementTree.parse(self.directory / f"out/{name}.svg").getroot().itertext())
            self.assertIn("method=backward-euler,step=20 ms", text)
        self.assertFalse((self.directory / "out/step.svg").exists())

    def test_lists_of_lists_where_the_input_takes_a_list(self):
        self.sweep("loads.0.gravity=[[0, 0, -1], [0, 0, -2]]", "time.end=20 ms", options=("--ranks", "2", "--jobs", "1"))
        near, far = (float(row["tip_z"]) for row in self.rows())
        self.assertLess(far, near)
        self.assertAlmostEqual(far / near, 2.0, delta=0.01)
        self.assertTrue(np.isfinite(far))

    def test_lists_side_by_side(self):
        done = self.sweep("time.step=[10 ms, 20 ms, 5 ms]", "time.method=[bdf2, backward-euler]", "bodies.0.density=[900, 1000, 1100]", "time.end=20 ms",
                          options=("--together", "bodies.0.density,time.step", "--result", "sag=min(tip_z)"))
        self.assertIn("6 runs of", done.stdout)
        self.assertEqual([(row["time.step"], row["time.method"], row["bodies.0.density"]) for row in self.rows()],
                         [(step, method, density) for step, density in (("10 ms", "900"), ("20 ms", "1000"), ("5 ms", "1100"))
                          for method in ("bdf2", "backward-euler")])
        text = list(ElementTree.parse(self.directory / "out/sag.svg").getroot().itertext())
        self.assertTrue({"method=bdf2", "method=backward-euler"} <= {part.strip() for part in text}, "curves of the methods alone")
        for together, expected in (("time.step,time.end", "'time.end' has no list of values"), ("time.step", "give the keys that vary together"),
                                   ("time.step,time.step", "'time.step' is named twice"), ("time.step,time.method", "'time.step' has 3 values and 'time.method' has 2")):
            with self.subTest(together):
                done = self.sweep("time.step=[10 ms, 20 ms, 5 ms]", "time.method=[bdf2, backward-euler]", options=("--together", together), code=2)
                self.assertIn(f"--together {together}: " + expected, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)

    def test_samples_of_ranges(self):
        settings = ("bodies.0.density=500..2000", "bodies.0.elasticity.youngs_modulus=0.1..10 MPa", "time.end=20 ms", "time.method=[bdf2, backward-euler]")
        options = ("--samples", "4", "--seed", "3", "--logarithmic", "bodies.0.elasticity.youngs_modulus", "--result", "sag=min(tip_z)")
        self.sweep(*settings, options=options)
        rows = self.rows()
        self.assertEqual([row["time.method"] for row in rows], ["bdf2"] * 4 + ["backward-euler"] * 4)
        sampled = [(row["bodies.0.density"], row["bodies.0.elasticity.youngs_modulus"]) for row in rows]
        self.assertEqual(sampled[:4], sampled[4:])
        density = [(float(d) - 500) / 1500 for d, _ in sampled[:4]]
        stiffness = [np.log10(float(e.removesuffix(" MPa")) / 0.1) / 2 for _, e in sampled[:4]]
        for shares in (density, stiffness):
            self.assertEqual(sorted(int(4 * share) for share in shares), [0, 1, 2, 3])
        for row in rows:
            history = read_history(self.directory / "out" / row["directory"])
            self.assertEqual(float(row["sag"]), history["tip_z"].min())
        names = {file.name for file in self.directory.glob("out/sag*.svg")}
        self.assertEqual(names, {"sag_over_density.svg", "sag_over_youngs_modulus.svg", "sag_map,method=bdf2.svg", "sag_map,method=backward-euler.svg"})
        for name, circles in (("sag_map,method=bdf2", 4), ("sag_over_density", 4)):
            tree = ElementTree.parse(self.directory / f"out/{name}.svg").getroot()
            marks = [m for m in tree.iter("{http://www.w3.org/2000/svg}circle") if m.find("{http://www.w3.org/2000/svg}title") is not None]
            self.assertEqual(len(marks), circles)
        again = self.call("sweep", INPUT, "--output", "out", "--continue", *options, *(a for s in settings for a in ("--set", s)))
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual([row["directory"] for row in self.rows()], [row["directory"] for row in rows])
        self.assertEqual(len(list(self.directory.glob("out/*/result.h5"))), 8)

    def test_map_over_two_lists(self):
        self.sweep("bodies.0.density=[500, 2000]", "bodies.0.elasticity.youngs_modulus=[0.1 MPa, 10 MPa]", "time.end=20 ms", options=("--result", "sag=min(tip_z)"))
        tree = ElementTree.parse(self.directory / "out/sag_map.svg").getroot()
        titles = ["".join(cell.itertext()) for cell in tree.iter("{http://www.w3.org/2000/svg}rect") if len(cell)]
        shown = {title.split(":")[0]: float(title.split(":")[1]) for title in titles}
        for row in self.rows():
            place = f"{row['bodies.0.density']}, {row['bodies.0.elasticity.youngs_modulus'].removesuffix(' MPa')}"
            self.assertAlmostEqual(shown[place], 1000 * float(row["sag"]), delta=1e-2 * abs(float(row["sag"])))
        self.assertIn("sag [mm]", "".join(tree.itertext()))
        places = list(ElementTree.parse(self.directory / "out/sag.svg").getroot().iter())[1:]
        self.assertEqual(sum(place.find("{http://www.w3.org/2000/svg}title") is not None for place in places), 4, "a mark for each run")

    def test_mistakes_are_told_before_anything_runs(self):
        for settings, expected in (
            (["time.step=10 ms"], "nothing varies"),
            (["time.stp=[1, 2]"], "did you mean 'step'"),
            (["time.step=[5 ms, 5 kg]"], "is a mass"),
            (["time.step=[5, 10] ms"], "after the closing bracket"),
            (["time.step=[5 ms, 10 ms]", "time=[{step: 1 ms, end: 2 ms}, {step: 2 ms, end: 2 ms}]"], "'time' would replace those of 'time.step'"),
            ([f"time.step={list(range(1, 40))}", f"time.end={list(range(1, 40))}"], "more than 1000 runs"),
        ):
            with self.subTest(settings[0]):
                done = self.sweep(*settings, code=2)
                self.assertIn(expected, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)
                self.assertFalse((self.directory / "out").exists())
        for setting, options, expected in (
            ("time.step=1..2 ms", (), "'time.step' has a range: say how many values"),
            ("time.step=[1, 2]", ("--samples", "3"), "no key has one"),
            ("time.step=2..1 ms", ("--samples", "3"), "does not ascend"),
            ("time.step=1 ms..2 s", ("--samples", "3"), "different units"),
            ("time.step=1..2 kg", ("--samples", "3"), "is a mass"),
            ("mesh.refine=0..2", ("--samples", "3"), "must be a whole number"),
            ("time.step=1..2 ms", ("--samples", "3", "--logarithmic", "time.end"), "--logarithmic time.end: this key has no range"),
            ("contact.friction=0..1", ("--samples", "3", "--logarithmic", "contact.friction"), "must be positive"),
        ):
            with self.subTest(setting):
                done = self.sweep(setting, options=options, code=2)
                self.assertIn(expected, done.stderr)
                self.assertEqual(done.stderr.count("\n"), 1)
        done = self.sweep("time.step=[5 ms, 10 ms]", options=("--result", "exit_code=max(tip_z)"), code=2)
        self.assertIn("sweep.csv has a column of this name already", done.stderr)

    def test_results_of_columns_that_no_run_has(self):
        """Before anything runs; a column of some of the runs does, and a run that cannot begin says why itself."""
        for column, expected in (("tip_q", "history.csv has no column 'tip_q' (did you mean 'tip_"), ("clamp_fq", "(did you mean 'clamp_f"),
                                 ("tip_z_displacement", "(did you mean 'tip_z'?)"), ("speed", "; it has step, time, ")):
            done = self.sweep("time.step=[5 ms, 10 ms]", options=("--result", f"max({column})"), code=2)
            self.assertIn(f"--result max({column}): history.csv has no column ", done.stderr)
            self.assertIn(expected, done.stderr)
            self.assertEqual((done.stdout, done.stderr.count("\n")), ("", 1))
            self.assertFalse((self.directory / "out").exists())
        self.sweep("constraints.0.name=[clamp, grip]", "time.end=20 ms", options=("--result", "last(grip_fz)"))
        self.assertEqual([row["last(grip_fz)"] == "nan" for row in self.rows()], [True, False])
        done = self.sweep("mesh.file=[nowhere.msh]", options=("--result", "max(clamp_fz)"), code=2)
        self.assertIn("run 1 failed", done.stderr)
        done = self.call("sweep", self.directory, "--set", "time.step=[1, 2]")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("give the path of an input file", done.stderr)
        done = self.call("sweep", INPUT, "--set", "time.step=[1, 2]", ranks=2)
        self.assertIn("without mpirun", done.stderr)

    def test_warnings_are_counted(self):
        done = self.sweep("bodies.0.density=[1.1, 1000]", "time.step=2 ms", "time.end=10 ms")
        self.assertRegex(done.stdout, r"01_density=1.1: done after \S+ s, 1 warning\n")
        self.assertRegex(done.stdout, r"02_density=1000: done after \S+ s\n")
        self.assertIn("warning: 1 of 2 runs has warnings: they are in out/*/log.txt, and in summary.json of each run", done.stderr)
        told, = json.loads((self.directory / "out/01_density=1.1/summary.json").read_text())["warnings"]
        self.assertIn("the density is 1.1 kg/m^3", told)

    def test_a_run_that_fails_does_not_stop_the_others(self):
        done = self.sweep("solver.newton.max_iterations=[1, 50]", "time.end=20 ms", "time.min_step=10 ms", code=3)
        failed, fine = self.rows()
        self.assertEqual((failed["exit_code"], fine["exit_code"]), ("3", "0"))
        self.assertIn(f"{failed['directory']}/log.txt", done.stderr)
        self.assertIn("max_iterations", (self.directory / "out" / failed["directory"] / "log.txt").read_text())

    def test_interrupted(self):
        process = start(["sweep", INPUT, "--output", "out", "--set", "time.step=[1 ms, 2 ms, 3 ms]", "--set", "time.end=1000",
                         "--jobs", "1"], self.directory)
        deadline = time.monotonic() + 60
        while not list(self.directory.glob("out/01*/history.csv")):
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        done = finish(process, 60)
        self.assertEqual(done.returncode, 130, done.stderr)
        self.assertEqual(done.stdout.count(": interrupted after"), 3)
        self.assertEqual(len(list(self.directory.glob("out/*/result.xdmf"))), 1)

    def test_what_is_done_is_left_and_what_was_begun_goes_on(self):
        settings = ("time.step=[10 ms, 20 ms]", "time.end=40 ms", "checkpoint.every=2")
        self.sweep(*settings)
        rows = self.rows()
        done, begun = (self.directory / "out" / row["directory"] for row in rows)
        made = (done / "result.h5").stat().st_mtime_ns
        (begun / "summary.json").unlink()
        arguments = [a for setting in settings for a in ("--set", setting)]
        again = self.call("sweep", INPUT, "--output", "out", "--continue", *arguments)
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertEqual((done / "result.h5").stat().st_mtime_ns, made)
        self.assertIn("done already", (done / "log.txt").read_text())
        self.assertIn("resuming from", (begun / "log.txt").read_text())
        for row, before in zip(self.rows(), rows):
            self.assertEqual(row | {"seconds": 0}, before | {"seconds": 0})

    def test_runs_of_another_sweep_are_not_mixed_with_these(self):
        """They are refused, with all left as it is; the same sweep may be repeated, and grow at its end."""
        self.sweep("time.step=[10 ms, 20 ms]", "time.end=40 ms")
        first = sorted(file.name for file in self.directory.glob("out/*"))
        (self.directory / "out/03_notes=mine").mkdir()

        def sweep(values, *options):
            return self.call("sweep", INPUT, "--output", "out", "--set", f"time.step={values}", "--set", "time.end=40 ms", *options)

        for options in ((), ("--continue",)):
            for values, what in (("[10 ms, 25 ms]", "a run of another sweep, such as 02_step=20_ms"), ("[5 ms, 25 ms]", "2 runs of another sweep, such as 01_step=10_ms")):
                done = sweep(values, *options)
                self.assertEqual((done.returncode, done.stdout, done.stderr), (2, "", f"out: it has {what}: name another directory with --output, or remove this one\n"))
        self.assertEqual(sorted(file.name for file in self.directory.glob("out/*")), sorted([*first, "03_notes=mine"]))
        self.assertEqual(sweep("[10 ms, 20 ms]").returncode, 0)
        self.assertEqual(sweep("[10 ms, 20 ms, 40 ms]", "--continue").returncode, 0)
        self.assertEqual([row["time.step"] for row in self.rows()], ["10 ms", "20 ms", "40 ms"])


if __name__ == "__main__":
    unittest.main()
