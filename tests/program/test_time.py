#!/usr/bin/python3
"""Motion in time: methods, own tables, events, adaptive steps, the ledger, pressure, viscosity, stiff bodies."""
import unittest

import numpy as np

from program import ProgramTest, read_history, swept, write_box

OWN = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33", "implicit-midpoint", "symplectic-dirk22")
PETSC = ("alpha2", "bdf", "arkimex")
BODY = """
mesh: {file: bar.msh}
bodies:
  - density: 1000
    elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}
    viscosity: {model: kelvin-voigt, shear: 200, bulk: 200}
"""
MAXWELL = "bodies.0.viscosity={model: maxwell, shear_modulus: 5e4, bulk_modulus: 5e4, relaxation_time: 0.05}"
TIP = "probes: [{name: tip, point: [1, 0.1, 0.1]}]\nsolver: {newton: {relative: 1e-10}}\n"
LOADED = BODY + TIP + """
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, "300*sin(10*t)"]}]
time: {method: bdf2, step: 0.02, end: 0.4}
"""
DRIVEN = BODY + TIP + """
constraints: [{surface: left, displacement: [0, "0.02*(1 - cos(15*t))", "0.05*(1 - cos(10*t))"]}]
loads: [{gravity: [0, 0, -9.81]}, {surface: right, traction: [0, 0, "300*sin(10*t)"]}]
time: {method: bdf2, step: 0.02, end: 0.4}
"""
KICKED = BODY + TIP + """
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, "t < 0.0137 ? 3000*sin(pi*t/0.0137)^2 : 0"]}]
time: {method: bdf2, step: 5 ms, end: 0.15, events: [0.0137, 0.1001]}
output: {every: 20 ms}
"""
DIRK22 = '{name: typed, A: [["1 - sqrt(2)/2", 0], ["sqrt(2)/2", "1 - sqrt(2)/2"]], b: ["sqrt(2)/2", "1 - sqrt(2)/2"]}'
ADAPTIVE = "time.adaptive={relative: 1e-3, absolute: 1e-5}"
STIFF = """
mesh: {file: cube.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e9, poissons_ratio: 0.49}}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 10 ms, end: 0.25}
"""


def largest_energy(h):
    return max(np.abs(h[name]).max() for name in ("kinetic_energy", "elastic_energy", "load_potential", "load_work"))


class Time(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (6, 1, 1), (1, 0.2, 0.2))

    def history(self, text, *settings, **more):
        return self.run_input(self.write("in.yaml", text), *settings, **more)

    def log(self, text, *settings):
        """The outputs of a run that talks, and its history."""
        arguments = [word for setting in settings for word in ("--set", setting)]
        done = self.call("run", self.write("in.yaml", text), "--output", "out", *arguments)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done, read_history(self.directory / "out")

    # ---- methods

    def test_every_method_runs(self):
        best = self.history(LOADED, "time.method=dirk33", "time.step=0.0025")["tip_z"][-1]
        for method in (*OWN, *(f"{{petsc: {name}}}" for name in PETSC)):
            with self.subTest(method):
                h = self.history(LOADED, "time.method=" + method)
                self.assertEqual(len(h["step"]), 21)
                # backward-euler damps this motion by several percent; the others are of second order at least.
                share = 0.15 if method == "backward-euler" else 0.03
                self.assertAlmostEqual(h["tip_z"][-1], best, delta=share * abs(best))

    def test_a_typed_table_is_the_method(self):
        typed = self.history(LOADED, "time.method=" + DIRK22)
        self.assert_same_history(typed, self.history(LOADED, "time.method=dirk22"), 1e-12)
        typed = self.history(LOADED, "time.method={A: [[1]], b: [1], alpha: [4/3, -1/3], beta: 2/3}")
        self.assert_same_history(typed, self.history(LOADED), 1e-12)

    def test_refused_tables(self):
        for table, words in (("{A: [[0.5, 0.5], [0, 0.5]], b: [0.5, 0.5]}", "triang"),
                             ("{A: [[0]], b: [1]}", "diagonal|explicit"),
                             ("{A: [[0.5]], b: [0.9]}", "inconsistent"), ("{A: [[1]]}", "'b'")):
            with self.subTest(table):
                file = self.write("bad.yaml", LOADED.replace("method: bdf2", "method: " + table))
                done = self.call("run", file, "--output", "out")
                self.assertEqual(done.returncode, 2, done.stderr)
                line = 1 + file.read_text().split("method: " + table)[0].count("\n")
                self.assertRegex(done.stderr, rf"bad.yaml:{line}:\d+: .*({words})")

    def test_startup(self):
        best = self.history(LOADED, "time.method=dirk33", "time.step=0.00125")["tip_z"][-1]
        errors = {}
        for startup in ("ramp", "dirk33"):
            ends = [self.history(LOADED, "time.method=bdf3", "time.startup=" + startup, f"time.step={dt}")["tip_z"][-1]
                    for dt in (0.01, 0.005)]
            errors[startup] = np.abs(np.array(ends) - best)
        self.assertGreater(errors["dirk33"][0], 6 * errors["dirk33"][1])  # third order
        self.assertGreater(errors["ramp"][1], 2 * errors["dirk33"][1])

    # ---- steps

    def test_events_and_output_times_are_hit(self):
        wanted = [0.0137, 0.1001, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14, 0.15]
        for method in ("bdf2", "dirk33", "{petsc: bdf}"):
            for more in ((), (ADAPTIVE,)):
                if more and "petsc" in method:
                    continue
                with self.subTest(method, more=more):
                    h = self.history(KICKED, "time.method=" + method, *more)
                    for t in wanted[:2] + wanted[-1:]:
                        self.assertIn(t, h["time"])
                    for t in wanted[2:]:  # fixed steps of 5 ms keep their grid beside the events
                        self.assertLess(np.abs(h["time"] - t).min(), 1e-15)
                    np.testing.assert_allclose(np.diff(h["time"]), h["dt"][1:], rtol=1e-9)

    def test_rejected_steps_leave_no_trace(self):
        # A coarse first step, to be rejected; the history knows only what was accepted, and a rerun is the same file.
        first, h = self.log(KICKED, ADAPTIVE, "time.step=50 ms", "time.adaptive.min_step=1e-6")
        text = (self.directory / "out/history.csv").read_bytes()
        self.assertRegex(first.stdout, r"repeated after a failed solve, [1-9]\d* for accuracy")
        np.testing.assert_array_equal(h["step"], np.arange(len(h["step"])))
        np.testing.assert_allclose(np.diff(h["time"]), h["dt"][1:], rtol=1e-9)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * largest_energy(h))
        self.log(KICKED, ADAPTIVE, "time.step=50 ms", "time.adaptive.min_step=1e-6")
        self.assertEqual((self.directory / "out/history.csv").read_bytes(), text)

    def test_adaptive_steps_outlast_a_loose_solver(self):
        # What Newton's tolerance leaves of the velocity is proportional to the step, as is the error a step may have.
        h = self.history("""
mesh: {file: bar.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.45},
          viscosity: {model: maxwell, shear_modulus: 1e4, relaxation_time: 1e-4}}]
loads: [{gravity: [0, 0, -9.81]}, {surface: top, pressure: "1724*sin(300*t)"}]
initial: {velocity: [1, 0, 0]}
time: {method: bdf2, step: 3 ms, end: 30 ms, adaptive: {relative: 1e-4}}
solver: {newton: {relative: 1e-3}}
""")
        self.assertEqual(h["time"][-1], 0.03)
        self.assertLess(len(h["time"]), 1000)

    # ---- ledger

    def test_the_books_close(self):
        for method in OWN:
            for viscosity in swept(((), (MAXWELL,)), ((MAXWELL,),) if OWN.index(method) % 2 else ((),)):
                with self.subTest(method, viscosity=viscosity):
                    h = self.history(DRIVEN, "time.method=" + method, *viscosity)
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * largest_energy(h))
                    energy = h["kinetic_energy"] + h["elastic_energy"] + h["load_potential"]
                    balance = energy + h["dissipated_energy"] + h["numerical_dissipation"] - h["load_work"] - energy[0]
                    np.testing.assert_allclose(balance, h["energy_balance_error"], atol=1e-12 * largest_energy(h))
                    self.assertGreater(h["dissipated_energy"][-1], 0.01 * largest_energy(h))
                    if method == "backward-euler":
                        self.assertGreaterEqual(np.diff(h["dissipated_energy"]).min(), 0)

    def test_every_mechanism_has_its_account(self):
        # Several side by side; without integrals of the method too, and without inertia (there the start is in balance).
        several = ("{model: kelvin-voigt, shear: 500}, {model: stiffness-proportional, time: 1 ms}, "
                   "{model: mass-proportional, decay_rate: 1}")
        branches = ("{model: maxwell, shear_ratio: 0.3, bulk_ratio: 0.3, relaxation_time: 50 ms}, "
                    "{model: maxwell, shear_modulus: 5e4, relaxation_time: 0.5}")
        for method in ("backward-euler", "dirk33", "petsc:alpha2", "quasistatic"):
            with self.subTest(method):
                names = [f"dissipated_{n}" for n in ("kelvin_voigt", "stiffness_proportional", "maxwell", "mass_proportional")]
                mechanisms = f"{several}, {branches}"
                if method.startswith("petsc:"):  # which has no place for internal variables
                    names.remove("dissipated_maxwell")
                    mechanisms = several
                h = self.history(DRIVEN, "time.method=" + method, "loads=[]", f"bodies.0.viscosity=[{mechanisms}]")
                self.assertEqual({name for name in h if name.startswith("dissipated_")} - {"dissipated_energy"}, set(names))
                np.testing.assert_allclose(sum(h[n] for n in names), h["dissipated_energy"], rtol=1e-13)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * largest_energy(h))
                for name in names:
                    self.assertGreater(h[name][-1], 1e-4 * largest_energy(h))
                    if method != "dirk33":  # whose weights are not all positive
                        self.assertGreaterEqual(np.diff(h[name]).min(), 0)

    def test_midpoint_keeps_the_energy_of_linear_elasticity(self):
        text = BODY.split("    viscosity")[0].replace("neo-hookean", "linear") + TIP
        text += "constraints: [{surface: left, displacement: [0, 0, 0]}]\nloads: [{gravity: [0, 0, -9.81]}]\n"
        h = self.history(text + "time: {method: implicit-midpoint, step: 0.02, end: 2}")
        energy = h["kinetic_energy"] + h["elastic_energy"] + h["load_potential"]
        scale = largest_energy(h)
        self.assertGreater(scale, 1)
        np.testing.assert_allclose(energy, energy[0], atol=1e-7 * scale)
        np.testing.assert_allclose(h["numerical_dissipation"], 0, atol=1e-7 * scale)

    # ---- pressure

    def test_pressure_all_around_moves_nothing(self):
        text = BODY + TIP + 'loads: [{where: "x > -1", pressure: "PRESSURE"}]\n'
        text += 'initial: {velocity: ["0.3 - (y - 0.1)", "0.1 + (x - 0.5)", -0.2]}\n'
        text += "time: {method: implicit-midpoint, step: 0.01, end: 0.2}\n"
        for pressure in swept(("5e3", "-5e3", "5e3*sin(30*t)"), ("-5e3", "5e3*sin(30*t)")):
            with self.subTest(pressure):
                h = self.history(text.replace("PRESSURE", pressure))
                for kind, names in (("p", ["px", "py", "pz"]), ("L", ["Lx", "Ly", "Lz"])):
                    values = np.array([h[name] for name in names])
                    start = np.broadcast_to(values[:, :1], values.shape)
                    np.testing.assert_allclose(values, start, atol=1e-6 * np.abs(values).max(), err_msg=kind)
                self.assertGreater(h["elastic_energy"].max(), 0.05)

    def test_pressure_on_a_plate(self):
        text = BODY.replace("1e5", "1e9") + TIP
        text += "constraints: [{surface: left, displacement: [0, 0, 0]}]\n"
        text += "loads: [{surface: top, pressure: 2 kPa}]\ntime: {method: static}\n"
        h = self.history(text)
        self.assertAlmostEqual(h["left_fz"][-1], 2e3 * 0.2, delta=1e-3 * 400)  # the top stays flat but for 1e-4
        self.assertLess(h["tip_z"][-1], 0.1)

    # ---- stiff bodies at long steps

    def check_stiff(self, text, steps=("10 ms", "25 ms")):
        write_box(self.directory / "cube.msh", (4, 4, 4), (0.1, 0.1, 0.1))
        for method in swept(("backward-euler", "bdf2", "dirk22"), ("bdf2", "dirk22")):
            for step in steps:
                with self.subTest(method, step=step):
                    done, h = self.log(text, "time.method=" + method, "time.step=" + step)
                    self.assertNotIn("failed", done.stderr)
                    self.assertIn("; 0 repeated", done.stdout)
                    self.assertEqual(h["time"][-1], 0.25)
                    self.assertTrue(np.isfinite(list(h.values())).all())

    def test_a_stiff_clamped_body(self):
        self.check_stiff(STIFF + "constraints: [{surface: left, displacement: [0, 0, 0]}]\n")

    def test_a_stiff_body_in_free_fall(self):
        self.check_stiff(STIFF + "initial: {velocity: [1, 0, 2]}\n")

    def test_a_stiff_spinning_body(self):
        # 0.03 rad per step: Newton's method takes tens of iterations for a turn, and may run out of them for larger ones.
        for step, spin in (("10 ms", 3), ("25 ms", 1)):
            velocity = f'initial: {{velocity: ["1 - {spin}*(y - 0.05)", "{spin}*(x - 0.05)", 2]}}\n'
            self.check_stiff(STIFF + velocity, (step,))

    # ---- viscosity

    def test_damping_ratio_of_a_bar(self):
        # Stress of the dashpot = beta times the rate of the elastic one: zeta = beta w0 / 2 = 5 %.
        modulus, w = 1e6, 0.5 * np.pi * np.sqrt(1e3)
        beta = 2 * 0.05 / w
        text = f"""
mesh: {{file: bar.msh}}
element: P2
bodies:
  - density: 1000
    elasticity: {{model: linear, youngs_modulus: {modulus}, poissons_ratio: 0}}
    viscosity: {{model: kelvin-voigt, shear: {beta * modulus / 2!r}, bulk: {beta * modulus / 3!r}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
initial: {{displacement: ["1e-4*sin(pi*x/2)", 0, 0]}}
time: {{method: dirk33, step: 2 ms, end: 0.3}}
probes: [{{name: tip, point: [1, 0.1, 0.1]}}]
"""
        h = self.history(text)
        damped = w * np.sqrt(1 - 0.05**2)
        amplitude = np.hypot(h["tip_x"] - 1, (h["tip_vx"] + 0.05 * w * (h["tip_x"] - 1)) / damped)
        rate = -np.polyfit(h["time"], np.log(amplitude), 1)[0]
        self.assertAlmostEqual(rate / (0.05 * w), 1, delta=0.01)

    def test_stress_relaxes(self):
        # A bar is stretched at once and held. Neither part contracts across: nu = 0, bulk modulus = 2/3 shear modulus.
        tau, stretch = 0.1, 0.05
        text = f"""
mesh: {{file: bar.msh}}
bodies:
  - density: 1000
    elasticity: {{model: saint-venant-kirchhoff, youngs_modulus: 1e5, poissons_ratio: 0}}
    viscosity: {{model: maxwell, shear_modulus: 5e4, bulk_modulus: {1e5 / 3!r}, relaxation_time: {tau}}}
constraints:
  - {{surface: left, displacement: [0, 0, 0]}}
  - {{surface: right, displacement: ["{stretch}*min(1, t/1e-3)", 0, 0]}}
time: {{method: quasistatic, step: 1 ms, end: 0.4}}
"""
        h = self.history(text)
        t, force = h["time"][1:] - 1e-3, h["right_fx"][1:]
        elastic = 0.04 * (1 + stretch) * 1e5 * (stretch + 0.5 * stretch**2)
        np.testing.assert_allclose(force, elastic * (1 + np.exp(-t / tau)), rtol=0.01)
        self.assertAlmostEqual(force[-1] / (elastic * (1 + np.exp(-t[-1] / tau))), 1, delta=2e-3)


if __name__ == "__main__":
    unittest.main()
