#!/usr/bin/python3
"""`pliant modes` against closed forms: beams, bars, bodies under load, rigid bodies; and the same modes on any number of ranks."""
import csv
import os
import sys
import unittest

import h5py
import numpy as np
import scipy.linalg
import scipy.optimize

from program import ENVIRONMENT, PROGRAM, ROOT, ProgramTest, box, write_box, write_mesh

sys.path.insert(0, str(ROOT / "src/python"))
os.environ.update(ENVIRONMENT, PLIANT=str(PROGRAM))

import pliant  # noqa: E402

E, RHO = 1e6, 1000.0
WAVE = np.sqrt(E / RHO)  # of a bar [m/s]
LENGTH, WIDTH, HEIGHT = 1.0, 0.06, 0.05
BAR = """mesh: {{file: bar.msh}}
element: P2
bodies:
  - {{volume: body, density: 1000, elasticity: {{model: {law}, youngs_modulus: 1 MPa, poissons_ratio: {nu}}}{more}}}
"""
CLAMP = "constraints: [{surface: left, displacement: [0, 0, 0]}]\n"
LAW = "saint-venant-kirchhoff"  # with the stiffness of stress, which linear elasticity has not
MOTION = "time: {method: bdf2, step: 1 ms, end: 1}\n"
# cos x cosh x = -1 of a cantilever, 1 of a free beam.
CANTILEVER = [scipy.optimize.brentq(lambda x: np.cos(x) * np.cosh(x) + 1, *ends) for ends in ((1, 3), (4, 5))]
FREE = [scipy.optimize.brentq(lambda x: np.cos(x) * np.cosh(x) - 1, *ends) for ends in ((4, 5), (7, 8))]


def bending(root, thickness):
    """Frequency of an Euler-Bernoulli beam [Hz]."""
    return root**2 * np.sqrt(thickness**2 / 12) * WAVE / LENGTH**2 / (2 * np.pi)


class Modes(ProgramTest):
    def modes(self, file, *options, ranks=1, output="modes"):
        """Columns of modes.csv by name."""
        self.log = self.pliant("modes", file, "--output", output, *options, ranks=ranks)
        with open(self.directory / output / "modes.csv", encoding="ascii", newline="") as stream:
            names, *rows = csv.reader(stream)
        return dict(zip(names, np.array(rows, dtype=float).T))

    def bar(self, more="", law="linear", nu=0, n=(10, 1, 1), rest=CLAMP + MOTION):
        write_box(self.directory / "bar.msh", n, (LENGTH, WIDTH, HEIGHT))
        return self.write("bar.yaml", BAR.format(law=law, nu=nu, more=more) + rest)

    def assert_close(self, found, expected, within):
        np.testing.assert_allclose(found, expected, rtol=within)

    def test_a_cantilever(self):
        """Bending, twist and stretch of a slender bar; damping in proportion to mass and to stiffness."""
        damping = ", viscosity: [{model: mass-proportional, decay_rate: 0.8}, {model: stiffness-proportional, time: 2 ms}]"
        found = self.modes(self.bar(damping), "--number", "9")
        f = found["frequency"]
        self.assert_close(f[:2], [bending(CANTILEVER[0], HEIGHT), bending(CANTILEVER[0], WIDTH)], 0.004)
        # Shear and the rotation of the sections lower the second pair (Timoshenko).
        self.assert_close(f[2:4], [bending(CANTILEVER[1], HEIGHT), bending(CANTILEVER[1], WIDTH)], 0.03)
        self.assertTrue((f[2:4] < [bending(CANTILEVER[1], HEIGHT), bending(CANTILEVER[1], WIDTH)]).all())
        axial = np.argmax(found["effective_mass_x"])
        self.assert_close(f[axial], WAVE / (4 * LENGTH), 1e-3)
        self.assert_close(found["effective_mass_x"][axial], 8 / np.pi**2, 0.002)
        # The first bending mode of a cantilever moves 61.3 % of the mass, the second 18.8 %.
        self.assert_close(found["effective_mass_z"][0], 0.6131, 0.01)
        self.assert_close(found["effective_mass_y"][1], 0.6131, 0.01)
        self.assert_close(found["effective_mass_z"][2], 0.1883, 0.02)
        w = 2 * np.pi * f
        self.assert_close(found["damping_ratio"], 0.8 / (2 * w) + 0.002 * w / 2, 1e-6)
        self.assert_close(found["eigenvalue"], w**2, 1e-12)

    def test_a_layer_with_damping(self):
        """Of the body and of its skin the same, in proportion to their stiffness."""
        skin = ("shells: [{name: skin, surface: top, thickness: 2 mm, damping: 2 ms, "
                "elasticity: {model: neo-hookean, youngs_modulus: 20 MPa, poissons_ratio: 0.3}}]\n")
        damping = ", viscosity: {model: stiffness-proportional, time: 2 ms}"
        found = self.modes(self.bar(damping, n=(4, 1, 1), rest=CLAMP + MOTION + skin), "--number", "4")
        self.assert_close(found["damping_ratio"], 0.002 * np.pi * found["frequency"], 1e-6)

    def test_results_of_a_run_are_kept(self):
        file = self.bar(n=(2, 1, 1), rest=CLAMP + MOTION.replace("end: 1}", "end: 2 ms}"))
        self.run_input(file, output="out")
        before = (self.directory / "out/result.h5").read_bytes()
        self.assertIn("has the results of a run", self.pliant("modes", file, "--output", "out", status=4).stderr)
        self.assertEqual((self.directory / "out/result.h5").read_bytes(), before)

    def test_the_order_of_frequencies(self):
        """Errors of frequencies fall with h^2 for P1 and h^4 for P2, twice the order of the shapes: a bar that moves along its axis."""
        sides = ", ".join(f"{{surface: {side}, displacement: [free, 0, 0]}}" for side in ("front", "back", "bottom", "top"))
        # Cells that keep their width become less slender, which helps those of P2 a little.
        for element, order, within in (("P1", 2, 0.1), ("P2", 4.2, 0.2)):
            errors = []
            for n in (4, 8):
                file = self.bar(n=(n, 1, 1), rest=CLAMP.replace("}]", "}, " + sides + "]") + MOTION)
                errors.append(self.modes(file, "--number", "1", "--set", f"element={element}")["frequency"][0] * 4 * LENGTH / WAVE - 1)
            self.assertAlmostEqual(np.log2(errors[0] / errors[1]), order, delta=within)

    def test_nearest_modes_are_among_all(self):
        file = self.bar()
        lowest = self.modes(file, "--number", "8")["frequency"]
        near = self.modes(file, "--number", "2", "--near", str(lowest[5] * 1.001))["frequency"]
        self.assertTrue(all(np.isclose(f, lowest[4:8], rtol=1e-7).any() for f in near), (near, lowest))
        self.assertTrue(np.isclose(near, lowest[5], rtol=1e-7).any())
        in_kilohertz = self.modes(file, "--number", "2", "--near", f"{1.001e-3 * lowest[5]} kHz")["frequency"]
        np.testing.assert_allclose(in_kilohertz, near, rtol=1e-7)

    def test_a_bar_that_nothing_holds(self):
        """Six rigid motions, first the translations along x, y, z, then the bending of a free beam; the same on 1, 2 and 3 ranks."""
        file = self.bar(rest=MOTION)
        alone = None
        for ranks in (1, 2, 3):
            found = self.modes(file, "--number", "8", ranks=ranks)
            self.assertEqual(found["frequency"][:6].tolist(), [0.0] * 6)
            self.assertIn("6 modes at 0 Hz", self.log.stdout)
            self.assert_close(found["frequency"][6:], [bending(FREE[0], HEIGHT), bending(FREE[0], WIDTH)], 0.02)
            mass = np.stack([found[f"effective_mass_{axis}"] for axis in "xyz"])
            np.testing.assert_allclose(mass, np.eye(3, 8), atol=1e-7)
            shapes = self.shapes()
            if alone is None:
                alone = found, shapes
                continue
            np.testing.assert_allclose(found["frequency"], alone[0]["frequency"], rtol=1e-8)
            np.testing.assert_allclose(shapes, alone[1], atol=1e-5 * np.abs(shapes).max())

    def test_what_nothing_holds_needs_no_inertia(self):
        """Without inertia such a body has no equilibrium under loads, but modes about its undeformed state."""
        for rest, options in (("time: {method: quasistatic, step: 1, end: 1}\n", ()), ("time: {method: static}\n", ()),
                              ("time: {method: static}\nloads: [{gravity: [0, 0, -9.81]}]\n", ("--unloaded",))):
            found = self.modes(self.bar(rest=rest), "--number", "7", *options)
            self.assertEqual(found["frequency"][:6].tolist(), [0.0] * 6)
            self.assert_close(found["frequency"][6:], [bending(FREE[0], HEIGHT)], 0.02)
            self.assertIn("modes about the undeformed state without loads", self.log.stdout)
        said = self.pliant("modes", "bar.yaml", status=2).stderr
        self.assertIn("a static analysis needs constraints; without them the bodies can move as a whole; to get the modes of the undeformed state, "
                      "in which bodies may be free: --unloaded\n", said)

    def shapes(self, output="modes"):
        """Of each mode, num_nodes x 3, in an order of nodes that no number of ranks changes."""
        with h5py.File(self.directory / output / "result.h5") as file:
            order = np.lexsort(np.round(file["mesh/coordinates"][()], 9).T)
            return np.stack([frame["mode_shape"][()][order] for frame in file["frames"].values()])

    def test_a_string_under_tension(self):
        """A stretched bar between two walls: f = sqrt(T / m) / 2 L of a string, and what its stiffness adds."""
        write_box(self.directory / "bar.msh", (24, 1, 1), (LENGTH, 0.01, 0.02))
        rest = ("constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: right, displacement: [0.05, 0, 0]}]\n"
                "time: {method: static}\n")
        file = self.write("bar.yaml", BAR.format(law=LAW, nu=0, more="") + rest)
        tight = self.modes(file, "--number", "2")["frequency"]
        loose = self.modes(file, "--number", "2", "--unloaded")["frequency"]
        string = np.sqrt(E * (1.05**2 - 1) / 2 / RHO) / (2 * LENGTH)
        self.assert_close(loose[0], bending(FREE[0], 0.01), 0.02)  # the roots of a clamped beam are those of a free one
        self.assertGreater(tight[0], string)
        self.assert_close(tight[0], self.clamped_beam_under_tension(1.05, 0.01), 0.01)

    @staticmethod
    def clamped_beam_under_tension(stretch, thickness):
        """First frequency [Hz] of B w'''' - T w'' = rho s^2 w, clamped at both ends, in the length of the unstretched bar and per area
        of its section: B = dP/dl h^2 / 12 / l^2, T = P / l with the nominal stress P = E l (l^2 - 1) / 2 of this law at the stretch l."""
        B = E * (3 * stretch**2 - 1) / 2 * thickness**2 / 12 / stretch**2
        T = E * (stretch**2 - 1) / 2

        def determinant(f):
            root = np.sqrt(T**2 + 4 * B * RHO * (2 * np.pi * f) ** 2)
            a, b = np.sqrt((T + root) / (2 * B)) * LENGTH, np.sqrt((root - T) / (2 * B)) * LENGTH
            return 2 * a * b * (1 / np.cosh(a) - np.cos(b)) + (a**2 - b**2) * np.sin(b) * np.tanh(a)

        grid = np.linspace(0.2, 8, 4000)
        values = [determinant(f) for f in grid]
        k = next(k for k in range(len(grid) - 1) if values[k] * values[k + 1] < 0)
        return scipy.optimize.brentq(determinant, grid[k], grid[k + 1])

    def test_a_column_up_to_its_buckling_load(self):
        """The first frequency of a column falls to zero at Euler's load, and beyond it the mode grows."""
        euler = np.pi**2 / 4 * E * WIDTH * HEIGHT**3 / 12 / LENGTH**2
        rest = CLAMP + "loads: [{surface: right, traction: [%r, 0, 0]}]\ntime: {method: static}\n"
        free = self.modes(self.bar(law=LAW, rest=rest % -1e-9), "--number", "1")["eigenvalue"][0]
        for part in (0.5, 0.9, 1.2):
            file = self.bar(law=LAW, rest=rest % (-part * euler / (WIDTH * HEIGHT)))
            found = self.modes(file, "--number", "2")
            self.assertAlmostEqual(found["eigenvalue"][0] / free, self.column(part), delta=0.005)
            self.assertEqual(part > 1, found["growth_rate"][0] > 0)
            self.assertEqual(part > 1, "the state is unstable" in self.log.stderr, self.log.stderr)
        self.assert_close(found["growth_rate"][0] ** 2, -found["eigenvalue"][0], 1e-12)
        self.assertEqual(found["frequency"][0], 0.0)

    @staticmethod
    def column(part):
        """w^2 / w0^2 of a cantilever of unit stiffness, mass and length under this part of Euler's load, by the method of Ritz."""
        k = np.arange(2, 10)
        i, j = np.meshgrid(k, k)
        bending, slope, mass = i * (i - 1) * j * (j - 1) / (i + j - 3), i * j / (i + j - 1), 1 / (i + j + 1)
        loaded = scipy.linalg.eigh(bending - part * np.pi**2 / 4 * slope, mass, eigvals_only=True)[0]
        return loaded / CANTILEVER[0] ** 4

    def test_a_mass_on_a_bar(self):
        """A rigid body at the end of a bar: k l tan(k l) = m / M, on any number of ranks."""
        write_box(self.directory / "bar.msh", (6, 1, 1), (LENGTH, WIDTH, HEIGHT))
        mass = RHO * LENGTH * WIDTH * HEIGHT
        text = BAR.format(law="linear", nu=0, more="") + (
            "rigid_bodies:\n  - {name: weight, mass: %r, inertia: [1.0e-3, 1.0e-3, 1.0e-3], center: [1, 0.03, 0.025], attached: [right]}\n"
            "constraints: [{surface: left, displacement: [0, 0, 0]}]\n" % (2 * mass) + MOTION)
        file = self.write("weight.yaml", text)
        x = scipy.optimize.brentq(lambda x: x * np.tan(x) - 0.5, 0.1, 1.5)
        found = [self.modes(file, "--number", "6", ranks=ranks) for ranks in (1, 2)]
        axial = np.argmax(found[0]["effective_mass_x"])
        self.assert_close(found[0]["frequency"][axial], x * WAVE / LENGTH / (2 * np.pi), 2e-3)
        self.assert_close(found[1]["frequency"], found[0]["frequency"], 1e-8)

    def test_two_halves_that_are_tied(self):
        """They vibrate as the whole bar does."""
        whole = self.modes(self.bar(n=(8, 1, 1)), "--number", "6")["frequency"]
        halves = [box((4, 1, 1), (LENGTH / 2, WIDTH, HEIGHT), origin=(x, 0, 0)) for x in (0, LENGTH / 2)]
        number = len(halves[0][0])
        left, right = halves[0][1], [side + number for side in halves[1][1]]
        sides = [left[0], right[1], left[1], right[0], left[4], left[5]]  # the ends, then both sides of the cut
        points, cells = np.vstack([h[0] for h in halves]), np.vstack([halves[0][2], halves[1][2] + number])
        write_mesh(self.directory / "halves.msh", points, sides, cells)
        text = BAR.format(law="linear", nu=0, more="").replace("bar.msh", "halves.msh")
        file = self.write("halves.yaml", text + CLAMP.replace("]}]", "]}, {surface: front, tied_to: back}]") + MOTION)
        self.assert_close(self.modes(file, "--number", "6", ranks=2)["frequency"], whole, 1e-6)

    def test_a_pendulum(self):
        """A rigid body on a hinge under gravity: (2 pi f)^2 = m g l / I, from the curvature of its motion alone."""
        file = self.write("pendulum.yaml", """rigid_bodies:
  - {name: bob, mass: 2, inertia: [0.01, 0.02, 0.03], center: [0, 0, -0.5]}
joints: [{type: hinge, name: pivot, between: [ground, bob], point: [0, 0, 0], axis: [0, 1, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: static}
""")
        found = self.modes(file, "--number", "1")
        self.assert_close(found["frequency"][0], np.sqrt(2 * 9.81 * 0.5 / (0.02 + 2 * 0.25)) / (2 * np.pi), 1e-9)
        self.assertEqual(self.modes(file, "--unloaded", "--number", "3")["frequency"].tolist(), [0.0])  # which has no stiffness at all

    def test_a_tendon_that_is_just_taut(self):
        """Its spring counts about the undeformed state, where it has no tension yet."""
        file = self.write("slider.yaml", """rigid_bodies: [{name: a, mass: 2, inertia: [1, 1, 1], center: [1, 0, 0]}]
joints: [{name: s, type: slider, between: [ground, a], point: [1, 0, 0], axis: [1, 0, 0], spring: {stiffness: 30}}]
tendons: [{name: t, points: [{body: ground, point: [0, 0, 0]}, {body: a, point: [1, 0, 0]}], pull: 0.1, stiffness: 50}]
time: {method: static}
""")
        for options in ((), ("--unloaded",)):
            self.assert_close(self.modes(file, "--number", "1", *options)["frequency"][0], np.sqrt(80 / 2) / (2 * np.pi), 1e-9)

    def test_mechanisms_have_modes_of_zero_frequency(self):
        """Without any stiffness, rounding errors are all that there is."""
        for name in ("hinge_chain", "heavy_top"):
            found = self.modes(ROOT / f"input/verification/{name}.yaml", "--unloaded", "--number", "6", output=name)
            self.assertEqual([found["frequency"].tolist(), found["growth_rate"].tolist()], [[0.0] * 3] * 2)

    def test_a_piston_on_air(self):
        """A rigid block on a gas: (2 pi f)^2 = n p A^2 / (V m), the rank-one part of the stiffness alone."""
        write_box(self.directory / "block.msh", (1, 1, 1), (0.2, 0.1, 0.3))
        sides = ", ".join(f"{{surface: {side}, displacement: [0, 0, free]}}" for side in ("left", "right", "front", "back"))
        file = self.write("piston.yaml", f"""mesh: {{file: block.msh}}
bodies: [{{volume: body, density: 500, elasticity: {{model: linear, youngs_modulus: 1.0e11, poissons_ratio: 0}}}}]
constraints: [{sides}]
cavities: [{{name: air, surface: bottom, volume: 0.05, gas: {{pressure: 0, ambient: 1.0e5, exponent: 1.4}}}}]
""" + MOTION)
        found = self.modes(file, "--number", "1", ranks=3)
        self.assert_close(found["frequency"], np.sqrt(1.4e5 * 0.02**2 / (0.05 * 3)) / (2 * np.pi), 1e-6)

    def test_a_rod(self):
        """A round cantilever: pairs of equal frequencies, of which one bends along y and one along z."""
        file = self.write("rod.yaml", "rods: [{name: beam, points: [[0, 0, 0], [1, 0, 0]], segments: 30, radius: 10 mm, density: 1000, "
                          "youngs_modulus: 1 MPa, poissons_ratio: 0, start: ground}]\n" + MOTION)
        found = self.modes(file, "--number", "4")
        self.assert_close(found["frequency"], np.repeat([bending(x, 0.01 * np.sqrt(3)) for x in CANTILEVER], 2), 0.003)
        np.testing.assert_allclose(found["effective_mass_y"][:2], [0.6131, 0], atol=0.001)
        np.testing.assert_allclose(found["effective_mass_z"][:2], [0, 0.6131], atol=0.001)
        # A bob on a wire that is light and stiff: 3 E I / L^3, slow beside the vibrations of the wire alone.
        file = self.write("wire.yaml", "rods: [{name: wire, points: [[0, 0, 0], [0, 0, -1]], segments: 400, radius: 0.25 mm, density: 7800, "
                          "youngs_modulus: 200 GPa, poissons_ratio: 0.3, start: ground, end: bob}]\n"
                          "rigid_bodies: [{name: bob, mass: 1, inertia: [1e-6, 1e-6, 1e-6], center: [0, 0, -1]}]\n" + MOTION)
        found = self.modes(file, "--number", "2")
        self.assert_close(found["frequency"], np.sqrt(3 * 200e9 * np.pi / 4 * 0.25e-3**4) / (2 * np.pi), 0.01)

    def test_a_body_of_constant_volume(self):
        """With pressures as unknowns: a free bar at nu = 1/2 bends as one at nu = 0."""
        file = self.bar(law="neo-hookean-isochoric", nu=0.5, rest="volumetric: mixed\n" + MOTION)
        text = file.read_text().replace("poissons_ratio: 0.5", "incompressible: true")
        found = self.modes(self.write("bar.yaml", text), "--number", "8", ranks=2)
        self.assertEqual(found["frequency"][:6].tolist(), [0.0] * 6)
        self.assert_close(found["frequency"][6:], [bending(FREE[0], HEIGHT), bending(FREE[0], WIDTH)], 0.02)

    def test_what_cannot_vibrate(self):
        without = self.bar(rest=CLAMP + "time: {method: static}\n").read_text().replace("density: 1000, ", "")
        refused = self.pliant("modes", self.write("massless.yaml", without), status=2)
        self.assertIn("modes need a mass: give the bodies a 'density'", refused.stderr)
        held = self.bar(rest=CLAMP.replace("surface: left", "volume: body") + MOTION)
        self.assertIn("constraints hold everything that has a mass", self.pliant("modes", held, status=2, ranks=2).stderr)
        self.assertIn("a frequency above 0 Hz is expected", self.pliant("modes", held, "--near", "-3", status=2).stderr)
        self.assertIn("'3 kg' is a mass, but a frequency", self.pliant("modes", held, "--near", "3 kg", status=2).stderr)
        pressed = self.bar(law="neo-hookean", nu=0.3, rest=CLAMP + "loads: [{surface: top, pressure: 10}]\ntime: {method: static}\n")
        refused = self.pliant("modes", pressed, status=2)
        self.assertIn("forces without a potential have no real modes: pressure", refused.stderr)
        self.pliant("modes", pressed, "--unloaded", "--number", "1")

    def test_results(self):
        """Where they go, what the frames are called, and the same in Python."""
        file = self.bar(rest=CLAMP + MOTION + "output: {directory: out/bar}\n")
        self.pliant("modes", file, "--number", "3")
        result = pliant.Result(self.directory / "out/bar/modes")
        f = pliant.modes(file, number=3, output=self.directory / "python")
        self.assertEqual([frame.label for frame in result.frames], [f"mode {k + 1}, {f.frequency[k]:.5g} Hz" for k in range(3)])
        largest = [np.linalg.norm(frame["displacement"], axis=1).max() for frame in result.frames]
        np.testing.assert_allclose(largest, 0.1 * LENGTH, rtol=1e-12)
        self.assertIn('<Grid Name="mode 1, ', (self.directory / "out/bar/modes/result.xdmf").read_text())
        self.pliant("report", "out/bar/modes")
        page = (self.directory / "out/bar/modes/report.html").read_text(encoding="utf-8")
        self.assertIn('"label":"mode 3, ', page)
        self.assertIn("3 frames from mode 1, ", self.pliant("info", "out/bar/modes").stdout)
        self.assertEqual(f.shapes.shape, (3, len(result.frames[0].mesh.coordinates), 3))
        self.assertEqual(f.effective_mass.shape, (3, 3))


if __name__ == "__main__":
    unittest.main()
