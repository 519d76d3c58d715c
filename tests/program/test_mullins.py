#!/usr/bin/python3
"""Softening by the largest strain of the past (Mullins effect): cycles against closed forms, restarts, all methods."""
import math
import unittest

import numpy as np

from program import LONG, ProgramTest, read_history, write_box

CUBE = (1, 1, 1)
SYMMETRY = ", ".join(f"{{surface: {side}, normal_displacement: 0}}" for side in ("left", "front", "bottom"))
CONFINED = SYMMETRY + ", {surface: back, normal_displacement: 0}, {surface: top, normal_displacement: 0}"
R, M, BETA = 1.8, 5e3, 0.15
MU, KAPPA = 1e5, 4e5
FIRST, SECOND = 0.5, 0.8  # elongations of the two cycles; time 0 to 4
CYCLES = f"{FIRST}*max(0, 1 - abs(t - 1)) + {SECOND}*max(0, 1 - abs(t - 3))"


def stretch(t):
    return 1 + FIRST * np.maximum(0, 1 - abs(t - 1)) + SECOND * np.maximum(0, 1 - abs(t - 3))


class Uniaxial:
    """An incompressible bar that is pulled: energy of distortion, its derivative, what the volume adds."""
    constraints = SYMMETRY
    law = f"model: neo-hookean-isochoric, shear_modulus: {MU}, poissons_ratio: 0.5"

    @staticmethod
    def W(l):
        return MU / 2 * (l**2 + 2 / l - 3)

    @staticmethod
    def dW(l):
        return MU * (l - l**-2)

    @staticmethod
    def volume(l):
        return 0 * l


class Confined:
    """A bar that is pulled with its sides held."""
    constraints = CONFINED
    law = f"model: neo-hookean-isochoric, shear_modulus: {MU}, bulk_modulus: {KAPPA}, volumetric_energy: quadratic"

    @staticmethod
    def W(l):
        return MU / 2 * (l ** (-2 / 3) * (l**2 + 2) - 3)

    @staticmethod
    def dW(l):
        return MU / 2 * (4 / 3 * l ** (1 / 3) - 4 / 3 * l ** (-5 / 3))

    @staticmethod
    def volume(l):
        return KAPPA * (l - 1)


def eta(W, Wm):
    return 1 - math.erf(max(0.0, Wm - W) / (M + BETA * Wm)) / R


def forces(test, l):
    """The force in each row of a history, and the largest energy up to there."""
    largest = np.maximum.accumulate(test.W(l))
    return np.array([eta(w, m) for w, m in zip(test.W(l), largest)]) * test.dW(l) + test.volume(l), largest


def lost(test, highest, n=20000):
    """Area between the primary curve up to a stretch and the way back from there, by the midpoint rule."""
    l = 1 + (highest - 1) * (np.arange(n) + 0.5) / n
    top = test.W(highest)
    return sum((1 - eta(w, top)) * f for w, f in zip(test.W(l), test.dW(l))) * (highest - 1) / n


class Mullins(ProgramTest):
    def input(self, case, element="P1", volumetric="mixed", step=0.1, more=""):
        return self.write("in.yaml", f"""mesh: {{file: cube.msh}}
element: {element}
volumetric: {volumetric}
bodies: [{{volume: body, elasticity: {{{case.law}}}, mullins: {{r: {R}, m: {M}, beta: {BETA}}}}}]
constraints: [{case.constraints}, {{surface: right, normal_displacement: "{CYCLES}"}}]
time: {{method: quasistatic, step: {step}, end: 4}}
solver: {{newton: {{relative: 1e-11}}}}
output: {{fields: [cauchy_stress, elastic_energy_density]}}
{more}""")

    def assert_closed_form(self, h, case):
        l = stretch(h["time"])
        expected, largest = forces(case, l)
        np.testing.assert_allclose(h["right_fx"], expected, atol=1e-8 * MU)
        # At one stretch: first loading, unloading, reloading along the same path, unloading from farther.
        primary, back, again, softer = (h["right_fx"][np.argmin(abs(h["time"] - t))] for t in (0.8, 1.2, 2.5, 3.5))
        self.assertGreater(primary - back, 0.02 * MU)
        self.assertAlmostEqual(again / back, 1, 7)
        self.assertGreater(back - softer, 0.02 * MU)
        dissipated = h["dissipated_mullins"]
        self.assertTrue(np.all(np.diff(dissipated) >= 0))
        self.assertTrue(np.all(np.diff(dissipated)[(np.diff(l) < 0)] == 0))
        for cycle, elongation in ((1, FIRST), (3, SECOND)):
            row = np.argmin(abs(h["time"] - cycle))
            self.assertAlmostEqual(dissipated[row] / lost(case, 1 + elongation), 1, 7)
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-10 * MU)
        # What remains is the error of the trapezoidal rule between equilibria, which are far apart here.
        self.assertLess(abs(h["numerical_dissipation"]).max(), 0.03 * dissipated[-1])
        self.assertAlmostEqual(h["elastic_energy"][-1] / MU, 0, 9)

    def test_cycles(self):
        write_box(self.directory / "cube.msh", (1, 1, 1), CUBE)
        for ranks, (case, element, volumetric) in enumerate((
                (Uniaxial, "P1", "mixed"), (Uniaxial, "P2", "mixed"), (Confined, "P1", "standard"),
                (Confined, "P2", "mean-dilatation"))):
            with self.subTest(case.__name__, element=element, volumetric=volumetric):
                self.input(case, element, volumetric)
                self.assert_closed_form(self.run_input("in.yaml", ranks=1 + (ranks % 3 if LONG else ranks == 2)), case)

    def test_restart_when_unloaded(self):
        """What the body remembers is in the checkpoint, next to the variables of viscosity, for any number of ranks."""
        write_box(self.directory / "cube.msh", (2, 2, 1), CUBE)
        text = self.input(Uniaxial, step=0.25, more="checkpoint: {every: 8}\n").read_text()
        text = text.replace("mullins:", "viscosity: {model: prony, ratio: 0.4, relaxation_time: 1}, mullins:")
        self.write("in.yaml", text)
        for ranks in (1, 3):
            whole = self.run_input("in.yaml", ranks=ranks)
            self.pliant("resume", "out/checkpoint-000008.h5", "--output", "resumed", "--quiet", ranks=4 - ranks)
            resumed = read_history(self.directory / "resumed")
            self.assertEqual(resumed["time"][0], 2.25)
            for name in ("right_fx", "elastic_energy", "dissipated_mullins", "dissipated_prony", "numerical_dissipation"):
                tail = whole[name][-len(resumed["step"]):]
                np.testing.assert_allclose(resumed[name], tail, atol=1e-9 * abs(tail).max(), err_msg=name)

    def test_load_steps(self):
        """Each load step of a static analysis is a state that the body remembers."""
        write_box(self.directory / "cube.msh", (1, 1, 1), CUBE)
        file = self.input(Confined, volumetric="standard", more="checkpoint: {every: 2}\n")
        file.write_text(file.read_text().replace(CYCLES, "0.5").replace(
            "{method: quasistatic, step: 0.1, end: 4}", "{method: static, load_steps: 8}"))
        h = self.run_input(file, ranks=2)
        expected, largest = forces(Confined, 1 + 0.5 * h["time"])
        np.testing.assert_allclose(h["right_fx"], expected, atol=1e-8 * MU)
        self.assertAlmostEqual(h["dissipated_mullins"][-1] / lost(Confined, 1.5), 1, 7)
        self.pliant("resume", "out/checkpoint-000006.h5", "--output", "resumed", "--quiet")
        resumed = read_history(self.directory / "resumed")
        for name in ("right_fx", "elastic_energy", "dissipated_mullins"):
            np.testing.assert_allclose(resumed[name], h[name][-len(resumed["step"]):], rtol=1e-9, err_msg=name)

    def test_repeated_steps(self):
        """Steps that fail and are halved leave nothing behind: the body remembers accepted states only."""
        write_box(self.directory / "cube.msh", (1, 1, 1), CUBE)
        file = self.input(Uniaxial, step=0.5)
        text = file.read_text().replace(CYCLES, f"{CYCLES} + 0.1*min(1, t)")
        file.write_text(text.replace("relative: 1e-11", "relative: 1e-11, max_iterations: 3"))
        h = self.run_input(file)
        self.assertLess(h["dt"][1:].min(), 0.3)
        expected, _ = forces(Uniaxial, stretch(h["time"]) + 0.1 * np.minimum(1, h["time"]))
        np.testing.assert_allclose(h["right_fx"], expected, atol=1e-8 * MU)

    def test_return_to_rest(self):
        """Without stress there are no forces for the residual to be compared with; Newton's method ends all the same."""
        write_box(self.directory / "cube.msh", (1, 1, 1), CUBE)
        file = self.input(Uniaxial, step=0.5)
        file.write_text(file.read_text().replace("relative: 1e-11", "relative: 1e-11, max_iterations: 6"))
        h = self.run_input(file)
        np.testing.assert_array_equal(h["dt"][1:], 0.5)

    def block(self, initial, time, more=""):
        return self.write("block.yaml", f"""mesh: {{file: block.msh}}
bodies:
  - volume: body
    density: 1
    elasticity: {{model: neo-hookean-isochoric, shear_modulus: 2, poissons_ratio: 0.4}}
    mullins: {{r: 1.5, m: 0.01, beta: 0.2}}
initial: {{{initial}}}
time: {{{time}}}
solver: {{newton: {{relative: 1e-11}}}}
{more}""")

    def test_every_method(self):
        """While no point is strained beyond its past, softening is smooth, and every method keeps its order."""
        write_box(self.directory / "block.msh", (1, 1, 1), CUBE)
        file = self.block('displacement: ["0.1*x", "-0.05*y", "-0.05*z"], velocity: ["0.5-y", "x-0.5", 0]',
                          "method: dirk33, step: 0.01, end: 0.2")
        done = self.call("converge", file, "--in", "time", "--levels", "3", "--methods", "all", "--output", "study")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_adaptive_steps_in_motion(self):
        """The energies of a motion across an event, in which the block is softened again and again."""
        write_box(self.directory / "block.msh", (1, 1, 1), CUBE)
        for method in ("bdf2", "dirk33"):
            file = self.block('displacement: ["0.08*x", "-0.03*x*y", "0.05*x*z"]',
                              f"method: {method}, step: 0.05, end: 2, events: [1], adaptive: {{relative: 1e-3, absolute: 1e-3}}",
                              """constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: ["0.5*(t < 1)", 0, 0]}]
""")
            h = self.run_input(file)
            self.assertTrue(np.all(np.diff(h["dissipated_mullins"]) >= 0))
            self.assertGreater(h["dissipated_mullins"][-1], 1e-3)
            given = h["load_work"]
            stored = h["kinetic_energy"] + h["elastic_energy"] + h["dissipated_mullins"]
            np.testing.assert_allclose(stored - stored[0] - given, 0, atol=0.02 * stored.max())


if __name__ == "__main__":
    unittest.main()
