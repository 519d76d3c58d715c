#!/usr/bin/python3
"""Laws of mechanics that a run must obey: free fall, momenta of a free body, energy, motion of the supports."""
import unittest

import numpy as np

from program import ProgramTest, swept, write_box

BAR = """
mesh: {file: bar.msh}
element: P1
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
"""
CLAMPED = BAR + "constraints: [{surface: left, displacement: [0, 0, 0]}]\n"
GRAVITY = "loads: [{gravity: [0, 0, -9.81]}]\n"
MASS = 1000 * 0.04


class Dynamics(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2))

    def history(self, text, *settings, ranks=1):
        return self.run_input(self.write("bar.yaml", text), *settings, ranks=ranks)

    def losses_by_step(self, text, steps):
        """What the method has dissipated at the end, for each step; the books must close in each of them."""
        losses = []
        for dt in steps:
            h = self.history(text, f"time.step={dt}")
            self.assert_books_close(h)
            losses.append(h["numerical_dissipation"][-1])
        return np.array(losses)

    def assert_books_close(self, h, tolerance=1e-7):
        """The balance is what its terms say, and what Newton's method leaves."""
        energy = h["kinetic_energy"] + h["elastic_energy"] + h["load_potential"]
        balance = energy + h["dissipated_energy"] + h["numerical_dissipation"] - h["load_work"] - energy[0]
        scale = max(np.abs(h[name]).max() for name in ("kinetic_energy", "elastic_energy", "load_potential", "load_work"))
        np.testing.assert_allclose(balance, h["energy_balance_error"], atol=1e-12 * scale)
        self.assertLess(np.abs(balance).max(), tolerance * scale)

    def check_free_fall(self, element, mass):
        text = BAR + GRAVITY + "initial: {velocity: [1, 0, 2]}\nprobes: [{name: corner, point: [1, 0.2, 0]}]\n"
        text += "time: {method: backward-euler, step: 0.01, end: 0.2}"
        h = self.history(text, "element=" + element, "mass=" + mass)
        t, dt = h["time"], 0.01
        np.testing.assert_allclose(h["pz"], MASS * (2 - 9.81 * t), atol=1e-6)
        np.testing.assert_allclose(h["corner_z"], 2 * t - 0.5 * 9.81 * t * (t + dt), atol=1e-9)
        np.testing.assert_allclose(h["corner_vz"], 2 - 9.81 * t, atol=1e-8)
        np.testing.assert_allclose(h["corner_x"], 1 + t, atol=1e-9)
        self.assertLess(h["elastic_energy"].max(), 1e-12)

    def test_free_fall(self):
        for element, mass in (("P1", "consistent"), ("P1", "lumped"), ("P2", "consistent"), ("P2", "lumped")):
            with self.subTest(element, mass=mass):
                self.check_free_fall(element, mass)

    def test_free_fall_is_exact_with_second_order(self):
        # BDF2 reproduces a parabola but for its first step, which is one of backward Euler: it starts g dt^2 / 2 low,
        # with the right velocity; its later steps forget a third of that each.
        text = BAR + GRAVITY + "probes: [{name: corner, point: [1, 0.2, 0]}]\ntime: {method: bdf2, step: 0.01, end: 0.2}"
        h = self.history(text)
        t = h["time"]
        error = h["corner_z"] + 0.5 * 9.81 * t**2
        self.assertAlmostEqual(error[1], -0.5 * 9.81 * 0.01**2, delta=1e-10)
        np.testing.assert_allclose(h["corner_vz"], -9.81 * t, atol=1e-8)
        np.testing.assert_allclose(np.diff(error)[1:], np.diff(error)[1] / 3 ** np.arange(19), atol=1e-9)

    def test_a_free_body_keeps_its_momenta(self):
        # A spinning, stretching, drifting body. Linear momentum is kept to the solver's tolerance; angular momentum only
        # as far as the method is accurate.
        text = BAR + """
initial: {velocity: ["0.3 - 2*(y - 0.1) + 0.2*(x - 0.5)", "0.1 + 2*(x - 0.5)", "-0.2 + 0.5*(x - 0.5)"]}
time: {method: bdf2, step: 0.01, end: 0.2}
solver: {newton: {relative: 1e-10}}
"""
        for ranks in swept((1, 2), (1,)):
            with self.subTest(ranks=ranks):
                loss = []
                for dt in (0.01, 0.005):
                    h = self.history(text, f"time.step={dt}", ranks=ranks)
                    np.testing.assert_allclose([h[f"p{c}"][0] for c in "xyz"], MASS * np.array([0.3, 0.1, -0.2]), atol=1e-12)
                    for c in "xyz":
                        np.testing.assert_allclose(h[f"p{c}"], h[f"p{c}"][0], atol=1e-6)
                    loss.append(abs(h["Lz"][-1] - h["Lz"][0]))
                self.assertLess(loss[0], 0.05 * abs(h["Lz"][0]))
                self.assertLess(loss[1], 0.4 * loss[0])

    def test_angular_momentum_of_the_start(self):
        h = self.history(BAR + 'initial: {velocity: ["-3*y", "3*x", 0]}\ntime: {step: 0.01, end: 0.01}')
        # 3 rad/s about the z axis through the origin: L_z = 3 m (1/3 + 0.2^2/3), others by the products of inertia.
        # Linear tetrahedra integrate products of linear functions exactly.
        self.assertAlmostEqual(h["Lz"][0], 3 * MASS * (1 + 0.2**2) / 3, delta=1e-12)
        self.assertAlmostEqual(h["Lx"][0], -3 * MASS * 0.5 * 0.1, delta=1e-12)
        self.assertAlmostEqual(h["Ly"][0], -3 * MASS * 0.1 * 0.1, delta=1e-12)

    def test_energy_that_is_lost_vanishes_with_the_step(self):
        for method, order in (("backward-euler", 1), ("bdf2", 2)):
            with self.subTest(method):
                text = CLAMPED + GRAVITY + f"time: {{method: {method}, step: 0.01, end: 0.2}}"
                losses = self.losses_by_step(text, (0.01, 0.005, 0.0025))
                self.assertTrue((losses > 0).all(), losses)
                ratios = losses[:-1] / losses[1:]
                self.assertTrue((ratios > 0.75 * 2**order).all(), ratios)

    def test_energy_never_grows(self):
        h = self.history(CLAMPED + GRAVITY + "time: {method: backward-euler, step: 0.01, end: 0.5}")
        self.assertGreaterEqual(np.diff(h["numerical_dissipation"]).min(), -1e-9)

    def test_a_load_in_time_does_work(self):
        text = CLAMPED + """
loads: [{surface: right, traction: [0, 0, "2000*sin(20*t)"]}]
time: {method: bdf2, step: 0.01, end: 0.4}
"""
        losses = np.abs(self.losses_by_step(text, (0.01, 0.005, 0.0025)))
        self.assertTrue((losses[:-1] > 3 * losses[1:]).all(), losses)
        h = self.history(text, "time.step=0.0025")
        self.assertGreater(h["load_work"].max(), 1)
        self.assertLess(losses[-1], 0.01 * h["load_work"].max())
        self.assertEqual(np.abs(h["load_potential"]).max(), 0)

    def test_supports_in_motion(self):
        # u_z = A (1 - cos w t) on the clamp, under a load that is constant, or looks as if it were not.
        text = BAR + """
constraints: [{surface: left, displacement: [0, 0, "0.05*(1 - cos(10*t))"]}]
loads: [{gravity: [0, 0, GRAVITY]}]
time: {method: bdf2, step: 0.01, end: 0.4}
probes: [{name: clamp, point: [0, 0.1, 0.1]}]
solver: {newton: {relative: 1e-10}}
"""
        losses = []
        for dt in (0.01, 0.005, 0.0025):
            h = self.history(text.replace("GRAVITY", "-9.81"), f"time.step={dt}")
            t = h["time"]
            np.testing.assert_allclose(h["clamp_z"], 0.1 + 0.05 * (1 - np.cos(10 * t)), atol=1e-14)
            np.testing.assert_allclose(h["clamp_vz"], 0.5 * np.sin(10 * t), atol=1e-9)
            varying = self.history(text.replace("GRAVITY", '"-9.81 + 0*t"'), f"time.step={dt}")
            self.assert_books_close(h)
            self.assert_books_close(varying)
            np.testing.assert_allclose(varying["support_work"], h["support_work"], atol=1e-7)
            np.testing.assert_array_equal(h["load_work"], h["support_work"])
            losses.append(abs(h["numerical_dissipation"][-1]))
        self.assertGreater(h["load_work"].max(), 10)
        self.assertGreater(losses[0], 3 * losses[1])
        self.assertGreater(losses[1], 3 * losses[2])

    def test_components_left_free(self):
        h = self.history(BAR + GRAVITY + "constraints: [{surface: left, displacement: [0, 0, free]}]\n"
                         "probes: [{name: root, point: [0, 0.1, 0.1]}]\ntime: {step: 0.01, end: 0.1}")
        self.assertLess(h["root_z"][-1], 0.1 - 0.04)
        np.testing.assert_array_equal(h["root_x"], 0)
        np.testing.assert_array_equal(h["left_fz"], 0)


if __name__ == "__main__":
    unittest.main()
