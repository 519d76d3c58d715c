#!/usr/bin/python3
"""Runs side by side: their differences in a table and in plots, and numbers that a sweep takes from its runs."""
import csv
import sys
import unittest
from xml.etree import ElementTree

import numpy as np

from program import ROOT, ProgramTest, read_history

INPUT = ROOT / "input/beam_small.yaml"


def texts_of(file):
    return "".join(ElementTree.parse(file).getroot().itertext())


class Compare(ProgramTest):
    def compare(self, *arguments, code=0):
        done = self.call("compare", *arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_differences_of_two_steps(self):
        coarse = self.run_input(INPUT, "time.step=20 ms", "time.end=60 ms", output="coarse")
        fine = self.run_input(INPUT, "time.step=10 ms", "time.end=60 ms", output="fine")
        done = self.compare("coarse", "fine/history.csv", "--output", "both")
        with open(self.directory / "both/compare.csv", encoding="utf-8", newline="") as file:
            rows = {row["column"]: row for row in csv.DictReader(file)}
        # Both have the times of the coarse run.
        expected = fine["tip_z"][::2] - coarse["tip_z"]
        at = np.argmax(np.abs(expected))
        row = rows["tip_z"]
        self.assertAlmostEqual(float(row["largest_difference"]), expected[at], delta=1e-9 * abs(expected[at]))
        self.assertAlmostEqual(float(row["time"]), coarse["time"][at])
        self.assertAlmostEqual(float(row["relative_to_range"]), abs(expected[at]) / np.ptp(coarse["tip_z"]), delta=1e-9)
        self.assertEqual((row["unit"], row["run"]), ("m", "fine"))
        self.assertNotIn("newton_iterations", rows)
        self.assertRegex(done.stdout, r"(?m)^  tip_z \[m\]: [-+]\d\S+ in fine at t = 0\.06 s, ")
        self.assertIn("coarse", texts_of(self.directory / "both/tip_z.svg"))
        self.assertIn("differences from coarse", texts_of(self.directory / "both/tip_z_difference.svg"))
        # Other steps are interpolated: the other way round, at every second time.
        self.compare("fine", "coarse", "--of", "tip_z", "--output", "back")
        with open(self.directory / "back/compare.csv", encoding="utf-8", newline="") as file:
            (row,) = csv.DictReader(file)
        between = np.interp(fine["time"], coarse["time"], coarse["tip_z"]) - fine["tip_z"]
        self.assertAlmostEqual(float(row["largest_difference"]), between[np.argmax(np.abs(between))], delta=1e-12)
        # A run differs from itself by nothing, and two of the same name are told apart.
        same = self.compare("coarse", "coarse", "coarse", "--output", "same").stdout
        self.assertRegex(same, r"\Alargest differences from \S+ \(1\):\n  all \d+ columns are equal\nresults: ")
        with open(self.directory / "same/compare.csv", encoding="utf-8", newline="") as file:
            same = list(csv.DictReader(file))
        self.assertEqual({float(row["largest_difference"]) for row in same}, {0.0})
        self.assertEqual({row["run"] for row in same}, {"coarse (2)", "coarse (3)"})
        self.assertFalse((self.directory / "same/tip_z_difference.svg").exists())
        (self.directory / "empty").mkdir()
        for arguments, code, expected in ((("coarse", "nowhere"), 4, "no result: 'nowhere' does not exist"),
                                          (("coarse", "empty"), 2, "empty: it has no history"),
                                          (("coarse", "fine", "--of", "tip_q"), 2, "no run has this column (did you mean 'tip_")):
            told = self.compare(*arguments, code=code)
            self.assertIn(expected, told.stderr)
            self.assertEqual(told.stderr.count("\n"), 1)

    def test_columns_that_are_equal_are_counted(self):
        """One that differs in one of two runs is not among them; the table has all."""
        for name, b in (("one", 3), ("two", 3), ("three", 4)):
            (self.directory / name).mkdir()
            self.write(f"{name}/history.csv", f"step,time,a,b,c\n0,0,1,2,0\n1,1,2,{b},0\n")
        self.assertEqual(self.compare("one", "two", "three", "--output", "all").stdout.split("\n")[1:3], ["  b: +1 in three at t = 1 s, 1 of its range", "  2 columns are equal"])
        self.assertIn("\n  1 column is equal\n", self.compare("one", "two", "--of", "a", "--output", "all").stdout)
        self.assertNotIn("equal", self.compare("one", "three", "--of", "b", "--output", "all").stdout)
        self.compare("one", "two", "three", "--output", "all")
        self.assertEqual(len((self.directory / "all/compare.csv").read_text().split()), 1 + 3 * 2)

    def test_units_of_columns(self):
        """Those of columns from fields follow from the input, those of motors from the columns of their joints; plots have handy ones."""
        units = {"lift_travel": "m", "lift_effort": "N", "lift_rate": "m/s", "knuckle_angle": "rad", "knuckle_effort": "N m", "knuckle_rate": "rad/s",
                 "lift_spring": "N", "lift_friction": "N", "knuckle_spring": "N m", "knuckle_damping": "N m",
                 "lift_bearing": "N", "knuckle_stops": "N m",
                 "pull": "N", "work": "J", "size": "m^3", "area": "m^2", "moved": "m^3", "error": "m^2.5", "peak": "Pa", "there": "m", "side": "N m"}
        entries = [("pull", "first_piola_kirchhoff_stress_xx", "take: integral, in: right"), ("work", "energy_density", "take: integral, in: bar"),
                   ("size", "volume_ratio", "take: integral"), ("area", "volume_ratio", "take: integral, in: right"),
                   ("moved", "displacement_z", "take: integral, in: right"), ("error", "displacement", "take: norm"), ("peak", "von_mises_stress", "take: max, in: bar"),
                   ("there", "displacement", "at: tip"), ("side", "membrane_force_xx", "take: integral, in: skin")]
        for name, factor in (("one", 1), ("two", 2)):
            (self.directory / name).mkdir()
            self.write(f"{name}/run.yaml", "bodies:\n  - volume: bar\nshells:\n  - name: skin\noutput:\n  history:\n"
                       + "".join(f"    - {{name: {column}, of: {of}, {how}}}\n" for column, of, how in entries))
            self.write(f"{name}/history.csv", ",".join(["step", "time", *units]) + "\n" + "".join(
                f"{t},{t}" + f",{0.001 * factor * t}" * len(units) + "\n" for t in (0, 1, 2)))
        printed = self.compare("one", "two", "--output", "both").stdout
        for column, unit in units.items():
            self.assertIn(f"  {column} [{unit}]: +0.002 in two", printed)
        self.assertIn("pull [mN]", texts_of(self.directory / "both/pull.svg"))
        self.assertIn("lift_travel [mm]", texts_of(self.directory / "both/lift_travel_difference.svg"))
        sys.path.insert(0, str(ROOT / "src/python"))
        from pliant import History
        from pliant.pictures import plot  # which needs matplotlib
        taken, history = plot.columns_from_fields(self.directory / "one"), History(self.directory / "one")
        self.assertEqual({column: plot.unit_of_column(column, taken, history) for column in units}, units)
        self.assertEqual(taken["pull"][0], "integral of first Piola-Kirchhoff stress xx in right")

    def test_rounding_is_drawn_as_nothing(self):
        """Next to other columns of its unit, at a value too; what is small on its own is drawn. An angle is compared with 1 rad."""
        columns = {"tip_x": (1.0, 1.0 + 2e-16, 1.0), "tip_uy": (0.0, 3e-19, -1e-19), "tip_uz": (0.0, 1e-3, 2e-3), "left_fx": (0.0, 1e-19, 2e-19), "knee_angle": (0.0, 1e-17, -1e-17)}
        for name in ("one", "two"):
            (self.directory / name).mkdir()
            self.write(f"{name}/history.csv", ",".join(["step", "time", *columns]) + "\n" + "".join(
                f"{k},{k}," + ",".join(repr(values[k]) for values in columns.values()) + "\n" for k in range(3)))
        self.compare("one", "two", "--output", "both")
        self.assertEqual(sorted(file.name for file in self.directory.glob("both/*.svg")), ["left_fx.svg", "tip_uz.svg"])
        sys.path.insert(0, str(ROOT / "src/python"))
        from pliant import History
        from pliant.pictures import plot
        history = History(self.directory / "one")
        for column in columns:
            figure = plot.draw(history, "", {}, columns=[column])
            low, high = figure.axes[0].get_ylim()
            line = figure.axes[0].lines[0].get_ydata()
            share = np.ptp(line) / (high - low)
            self.assertTrue(share > 0.8 if column in ("tip_uz", "left_fx") else share < 1e-6, (column, share))
            plot.plt.close(figure)

    def test_rounding_is_not_a_difference(self):
        """Of forces that balance, next to the work; of a constant; where it is a part of what varies. The rest is reported."""
        columns = {"elastic_energy": (0.0, 1.0, 2.0), "rim_fx": (0.0, 1e-11, -2e-11), "rim_tz": (0.0, 3e-12, 1e-12), "rod_force": (5.0, 5.0, 5.0 + 1e-10), "clamp_fx": (0.0, 1e-4, 3e-4), "clamp_fz": (0.0, 5e4, 1e5),
                   "tip_x": (1.0, 1.0, 1.0), "tip_uz": (0.0, 0.1, 0.2), "energy_balance_error": (0.0, 1e-9, 2e-9), "wall_fz": (0.0, 10.0, 20.0)}
        changes = {"clamp_fx": 1e-4, "rim_fx": 1e-11, "rim_tz": 1e-12, "rod_force": 1e-11, "tip_x": 2e-16, "energy_balance_error": 1e-9, "wall_fz": 1e-6}
        for name, factor in (("one", 0), ("two", 1)):
            (self.directory / name).mkdir()
            self.write(f"{name}/history.csv", ",".join(["step", "time", *columns]) + "\n" + "".join(
                f"{k},{k}," + ",".join(repr(values[k] + factor * changes.get(name, 0) * (k == 1)) for name, values in columns.items()) + "\n" for k in range(3)))
        done = self.compare("one", "two", "--output", "both")
        self.assertEqual(done.stdout.split("\n")[1:4], ["  wall_fz [N]: +1e-06 in two at t = 1 s, 5e-08 of its range",
                                                        "  3 columns are equal", "  6 columns are equal up to rounding"])
        self.assertEqual(sorted(file.name for file in self.directory.glob("both/*.svg")),
                         ["clamp_fz.svg", "elastic_energy.svg", "tip_uz.svg", "wall_fz.svg", "wall_fz_difference.svg"])
        with open(self.directory / "both/compare.csv", encoding="utf-8", newline="") as file:
            rows = {row["column"]: row for row in csv.DictReader(file)}
        self.assertEqual({column: float(row["largest_difference"]) > 0 for column, row in rows.items()}, {column: column in changes for column in columns})
        self.assertEqual({column for column, row in rows.items() if row["relative_to_range"].lower() == "nan"}, {"clamp_fx", "rim_fx", "rim_tz", "rod_force", "tip_x", "energy_balance_error"})

    def test_results_of_a_sweep(self):
        done = self.call("sweep", INPUT, "--output", "out", "--set", "bodies.0.density=[900, 1000]", "--set",
                         "time.method=[bdf2, backward-euler]", "--set", "time.end=40 ms", "--result", "lowest=min(tip_z)", "--result",
                         "mean(kinetic_energy)")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(self.directory / "out/sweep.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 4)
        for row in rows:
            history = read_history(self.directory / "out" / row["directory"])
            self.assertEqual(float(row["lowest"]), history["tip_z"].min())
            t, y = history["time"], history["kinetic_energy"]
            mean = np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(t)) / (t[-1] - t[0])
            self.assertAlmostEqual(float(row["mean(kinetic_energy)"]), mean, delta=1e-12 * mean)
            self.assertRegex(done.stdout, rf"(?m)^{row['bodies.0.density']} +{row['time.method']} .* {float(row['lowest']):.6g} ")
        self.assertRegex(done.stdout, r"(?m)^density .* lowest \[m\] +mean\(kinetic_energy\) \[J\]$")
        for row in rows:  # what a run printed is with its results
            self.assertIn("energy [J]", (self.directory / "out" / row["directory"] / "log.txt").read_text())
        self.assertEqual([file for file in self.directory.glob("out/0*") if not file.is_dir()], [])
        text = texts_of(self.directory / "out/lowest.svg")
        for part in ("density", "method=bdf2", "method=backward-euler"):
            self.assertIn(part, text)

    def test_static_runs_have_load_factors(self):
        static = self.write("static.yaml", f"""mesh: {{file: {ROOT}/meshes/unit_cube.msh}}
bodies: [{{elasticity: {{model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}}}]
constraints: [{{where: "z < 1e-9", displacement: [0, 0, 0]}}]
loads: [{{where: "z > 1 - 1e-9", traction: [0, 0, 10 kPa]}}]
time: {{method: static, load_steps: 2}}
probes: [{{name: tip, point: [1, 1, 1]}}]
output: {{history: [{{name: peak, of: von_mises_stress, take: max}}]}}
""")
        modulus = "bodies.0.elasticity.youngs_modulus"
        done = self.pliant("sweep", static, "--output", "out", "--set", modulus + "=[500 kPa, 1 MPa, 2e6]", "--result", "last(tip_uz)",
                           "--result", "when=time_of_max(tip_uz)")
        self.assertRegex(done.stdout, r"(?m)^youngs_modulus .* load factor ")
        self.assertNotIn("time [s]", done.stdout)
        for file, label in (("tip_uz", "tip_uz [mm]"), ("peak", "peak [kPa]")):
            text = texts_of(self.directory / f"out/{file}.svg")
            self.assertIn("load factor", text)
            self.assertIn(label, text)
            self.assertNotIn("time [s]", text)
        # Values of several units are drawn, and written, in SI; as typed too.
        self.assertIn("youngs_modulus [MPa]", texts_of(self.directory / "out/last_tip_uz.svg"))
        self.assertNotIn("when [s]", texts_of(self.directory / "out/when.svg"))
        with open(self.directory / "out/sweep.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([row[modulus] for row in rows], ["500 kPa", "1 MPa", "2e6"])
        self.assertEqual([float(row[modulus + " [Pa]"]) for row in rows], [5e5, 1e6, 2e6])
        self.assertEqual([float(row["when"]) for row in rows], [1.0] * 3)
        done = self.compare(f"out/{rows[0]['directory']}", f"out/{rows[1]['directory']}", "--of", "peak,tip_uz", "--output", "both")
        self.assertRegex(done.stdout, r"peak \[Pa\]: .* in 02_\S+ at load factor \S+, ")
        self.assertIn("load factor", texts_of(self.directory / "both/tip_uz_difference.svg"))
        self.run_input(INPUT, "time.step=20 ms", "time.end=60 ms", output="dynamic")
        done = self.compare("dynamic", f"out/{rows[0]['directory']}", code=2)
        self.assertIn("its rows are at values of load factor, and those of 'dynamic' at values of time [s]", done.stderr)

    def test_mistakes_in_results(self):
        for result, expected in (("tip_z", "no parentheses"), ("most(tip_z)", "there is no function 'most'"), ("=max(tip_z)", "a name is missing")):
            with self.subTest(result):
                done = self.call("sweep", INPUT, "--set", "time.step=[10 ms, 5 ms]", "--result", result)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
                self.assertIn(expected, done.stderr)
                self.assertIn("e.g. max(tip_z)", done.stderr)


if __name__ == "__main__":
    unittest.main()
