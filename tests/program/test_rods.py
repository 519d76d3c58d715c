#!/usr/bin/python3
"""Rods, as users type them: closed forms of statics and vibrations, frames, orders, ranks, restart, rods in and on bodies."""
import sys
import unittest

import numpy as np

from program import ALL_OR_SOME, LINE, ROOT, ProgramTest, box, read_history, swept, write_box, write_mesh
from shell_meshes import write_patch

sys.path.insert(0, str(ROOT / "src/python"))

import pliant  # noqa: E402
from pliant.pictures.rods import RodShapes  # noqa: E402

# E I = 1 N m^2, and E A = 4e6 N: the axis hardly changes its length.
SLENDER = "radius: 1 mm, youngs_modulus: 1.2732395447351628e12, poissons_ratio: 0.3"
BEAM = f"""rods: [{{name: beam, points: [[0, 0, 0], [1, 0, 0]], segments: N, {SLENDER}, start: ground, end: tip}}]
rigid_bodies: [{{name: tip, center: [1, 0, 0]}}]
"""
# A bent bar of a flat section, shaken in space: bending in both planes and twist.
SHAKEN = """rods:
  - name: beam
    points: [[0, 0, 0], [0.3, 0, 0.1], [0.6, 0.1, 0.1]]
    segments: 2
    section: {width: 60 mm, height: 40 mm, up: [0, 0, 1]}
    density: 1000
    youngs_modulus: 1 MPa
    poissons_ratio: 0.3
    start: ground
loads: [{gravity: [0, "2*(1-cos(8*t))", "-9.81*(1-cos(6*t))"]}]
probes: [{name: tip, point: [0.6, 0.1, 0.1]}]
"""
# Two rods that meet in a block, one of them on the ground, the other free.
JOINED = """rods:
  - {name: mast, points: [[0, 0, 0], [0, 0, 0.5]], segments: 5, radius: 10 mm, density: 1000, youngs_modulus: 10 MPa, poissons_ratio: 0.3,
     start: ground, end: block}
  - {name: boom, points: [[0, 0, 0.5], [0.4, 0, 0.5]], size: 0.1, radius: 8 mm, density: 1000, youngs_modulus: 10 MPa, poissons_ratio: 0.3,
     start: block}
rigid_bodies: [{name: block, mass: 20 g, inertia: [1e-6, 1e-6, 1e-6], center: [0, 0, 0.5]}]
loads: [{gravity: [0, 0, -9.81]}, {force: [0, "0.1*sin(20*t)", 0], volume: block}]
"""


def add_curves(path, curves):
    """Adds physical curves to a mesh of gmsh's format 2: chains of nodes, numbers from 0, by their names."""
    lines = path.read_text(encoding="ascii").split("\n")
    for tag, (name, chain) in enumerate(curves.items(), 50):
        for place, more in (("$PhysicalNames", [f'1 {tag} "{name}"']),
                            ("$Elements", [f"{10000 * tag + k} {LINE} 2 {tag} {tag} {a + 1} {b + 1}" for k, (a, b) in enumerate(zip(chain, chain[1:]))])):
            count = lines.index(place) + 1
            lines[count:count + 1] = [str(int(lines[count]) + len(more)), *more]
    path.write_text("\n".join(lines), encoding="ascii")


class Rods(ProgramTest):
    def end_of(self, text, ranks=1):
        return {name: column[-1] for name, column in self.solve(text, "method: static", ranks).items()}

    def assert_second_order(self, errors):
        for coarse, fine in zip(errors, errors[1:]):
            self.assertLess(np.abs(fine).max(), np.abs(coarse).max() / 3.3, errors)

    def test_elastica(self):
        # Bisshopp & Drucker 1945, with elliptic integrals: P L^2 / (E I) = 1 and 5.
        loads = (("1", 0.301721, 0.056433), ("5", 0.713792, 0.387628))
        for force, down, back in swept(loads, loads[:1]):
            errors = []
            for n in (6, 12, 24):
                h = self.end_of(BEAM.replace("N,", f"{n},") + f"loads: [{{force: [0, 0, -{force}], volume: tip}}]\n")
                errors.append([-h["tip_z"] - down, 1 - h["tip_x"] - back])
            self.assertLess(np.abs(errors[-1]).max(), 5e-4)
            self.assertLess(np.abs(errors[-1]).max(), np.abs(errors[0]).max() / 10)
            # What holds the beam has the force and the moment about the clamp.
            np.testing.assert_allclose(h["beam_start_fz"], float(force), rtol=1e-6)
            np.testing.assert_allclose(h["beam_start_ty"], -float(force) * h["tip_x"], rtol=1e-5)

    def test_a_moment_rolls_a_rod_up(self):
        # M = 2 pi E I / L: a full circle; half of it: 2/pi above the clamp.
        errors = []
        for n in (8, 16):
            h = self.end_of(BEAM.replace("N,", f"{n},") + 'loads: [{torque: [0, "-pi", 0], volume: tip}]\n')
            errors.append([h["tip_x"], h["tip_z"] - 2 / np.pi])
        self.assert_second_order(errors)
        self.assertLess(np.abs(errors[-1]).max(), 2e-2)

    def test_a_torque_twists_a_section_by_its_torsion_constant(self):
        # A square: J = 0.140577 a^4 (Saint-Venant), and a circle.
        square = "section: {width: 10 mm, height: 10 mm, up: [0, 0, 1]}, youngs_modulus: 2.6 MPa, poissons_ratio: 0.3"
        for section, J in ((square, 0.14057701 * 0.01**4), (SLENDER.replace("1.2732395447351628e12", "2.6 MPa"), np.pi / 2 * 0.001**4)):
            text = BEAM.replace("N,", "4,").replace(SLENDER, section)
            twist = 0.5
            h = self.end_of(text + f'loads: [{{torque: [{1e6 * J * twist!r}, 0, 0], volume: tip}}]\n')
            np.testing.assert_allclose(2 * np.arcsin(h["tip_qx"]), twist, rtol=1e-6)
            np.testing.assert_allclose(h["tip_x"], 1, atol=1e-9)

    def test_a_cantilever_vibrates_at_its_natural_frequency(self):
        # f = 1.875104^2 / (2 pi) sqrt(E I / (rho A L^4)); the velocity at the start is that of the first mode.
        k, E, rho, r = 1.87510407, 1e6, 1000.0, 0.01
        ratio = (np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))
        shape = f"1e-3*(cosh({k}*x)-cos({k}*x)-{ratio}*(sinh({k}*x)-sin({k}*x)))"
        f = k**2 / (2 * np.pi) * np.sqrt(E / rho) * r / 2
        errors = []
        for n in (8, 16):
            text = f"""rods: [{{name: beam, points: [[0, 0, 0], [1, 0, 0]], segments: {n}, radius: {r}, density: {rho}, youngs_modulus: {E},
  poissons_ratio: 0.3, start: ground}}]
initial: {{velocity: [0, 0, "{shape}"]}}
probes: [{{name: tip, point: [1, 0, 0]}}]
"""
            h = self.solve(text, f"method: symplectic-dirk22, step: {1 / f / 200}, end: {1.1 / f}")
            z, t = h["tip_z"], h["time"]
            zero = [t[i] - z[i] * (t[i + 1] - t[i]) / (z[i + 1] - z[i]) for i in range(1, len(t) - 1) if z[i] * z[i + 1] < 0]
            errors.append([(zero[1] - zero[0]) * 2 * f - 1])
        self.assertLess(abs(errors[-1][0]), 2e-3)
        self.assertLess(abs(errors[1][0]), abs(errors[0][0]) / 3)

    def test_sections_turn_with_an_axis_that_starts_bent(self):
        # The energy is that of a bent beam; directors that stayed behind had thousands of times as much.
        energies = []
        for n in (10, 20):
            h = self.solve(f"""rods: [{{name: beam, points: [[0, 0, 0], [1, 0, 0]], segments: {n}, radius: 0.01, density: 1000, youngs_modulus: 1e7,
  poissons_ratio: 0.3, start: ground}}]
initial: {{displacement: [0, 0, "0.001*x^2*(3-x)/2"]}}
""", "method: bdf2, step: 1 ms, end: 1 ms")
            energies.append(h["elastic_energy"][0])
        exact = 3 * 1e7 * np.pi / 4 * 0.01**4 * 0.001**2 / 2
        np.testing.assert_allclose(energies, exact, rtol=0.02)  # the axis stretches a little, too

    def test_damping(self):
        # Vibrations along a rod: the first mode of a clamped bar, with the damping ratio damping w / 2.
        E, rho, damping = 1e6, 1000.0, 2e-3
        omega = np.pi / 2 * np.sqrt(E / rho)
        text = f"""rods: [{{name: bar, points: [[0, 0, 0], [1, 0, 0]], segments: 20, radius: 0.01, density: {rho}, youngs_modulus: {E},
  poissons_ratio: 0.3, damping: {damping}, start: ground}}]
initial: {{velocity: ["1e-3*sin(1.5707963268*x)", 0, 0]}}
probes: [{{name: tip, point: [1, 0, 0]}}]
solver: {{newton: {{relative: 1e-11}}}}
"""
        h = self.solve(text, f"method: dirk33, step: {0.02 / omega}, end: {12 / omega}")
        decay = damping * omega**2 / 2
        wave = np.sqrt(omega**2 - decay**2)
        expected = 1e-3 / wave * np.exp(-decay * h["time"]) * np.sin(wave * h["time"])
        np.testing.assert_allclose(h["tip_x"] - 1, expected, atol=6e-3 * 1e-3 / wave)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-8 * h["kinetic_energy"][0])
        np.testing.assert_allclose(h["dissipated_rod_viscosity"][-1], h["kinetic_energy"][0] - h["kinetic_energy"][-1] - h["elastic_energy"][-1],
                                   rtol=1e-3)
        self.write("in.yaml", SHAKEN.replace("poissons_ratio: 0.3", "poissons_ratio: 0.3\n    damping: 2 ms")
                   + "time: {method: bdf2, step: 2 ms, end: 0.1, startup: dirk33}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", ",".join(swept(("bdf2", "dirk22", "dirk33"), ("dirk22",))))

    def test_natural_curvature_is_kept(self):
        # An arc is without force, and stays where it is.
        angles = np.linspace(0, 2, 9)
        points = [[float(np.sin(a)), 0.0, float(1 - np.cos(a))] for a in angles]
        text = f"rods: [{{name: arc, points: {points}, {SLENDER}, density: 1000, start: ground}}]\ninitial: {{velocity: [0, 0, 0]}}\n"
        h = self.solve(text, "method: bdf2, step: 10 ms, end: 0.05")
        self.assertLess(np.abs(h["elastic_energy"]).max(), 1e-12)

    def test_a_free_rod_keeps_its_momenta_and_its_energy(self):
        text = """rods: [{name: stick, points: [[0, 0, 0], [0.2, 0.1, 0], [0.3, 0.3, 0.1]], segments: 3, section: {width: 30 mm, height: 20 mm,
  up: [0, 0, 1]}, density: 1000, youngs_modulus: 1 MPa, poissons_ratio: 0.3}]
initial: {velocity: ["3*y", "-3*x+z", "2*x"]}
solver: {newton: {relative: 1e-12}}
"""
        h = self.solve(text, "method: implicit-midpoint, step: 2 ms, end: 0.2")
        for name in ("px", "py", "pz", "Lx", "Ly", "Lz"):
            scale = max(np.abs(h[other]).max() for other in h if other[0] == name[0] and len(other) == 2)
            np.testing.assert_allclose(h[name], h[name][0], atol=1e-9 * scale, err_msg=name)
        energy = h["kinetic_energy"] + h["elastic_energy"]
        np.testing.assert_allclose(energy, energy[0], rtol=2e-3)
        self.assertGreater(h["elastic_energy"].max(), 1e-3 * energy[0])

    def test_orders(self):
        self.write("in.yaml", SHAKEN + "time: {method: bdf2, step: 2 ms, end: 0.2, startup: dirk33}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "3", "--methods", ALL_OR_SOME)

    def test_more_ranks_than_segments(self):
        self.write("in.yaml", SHAKEN + "time: {method: dirk22, step: 5 ms, end: 0.1}\n")
        done = self.call("run", "in.yaml", ranks=16)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertRegex(done.stderr, r"(?m)^in.yaml: rods and rigid bodies make \d+ cells for 16 ranks, but every rank needs at least "
                         "one: use fewer ranks$")

    def test_ranks_and_restart(self):
        for text in swept((SHAKEN, JOINED), (JOINED,)):
            time = "method: dirk22, step: 5 ms, end: 0.05"
            one = self.solve(text + "solver: {newton: {relative: 1e-12}}\n", time)
            self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-7 * np.abs(one["kinetic_energy"]).max())
            quadratic = self.solve(text + "element: P2\nsolver: {newton: {relative: 1e-12}}\n", time, 2)
            self.assert_same_history(one, {name: quadratic[name] for name in one}, 1e-7)
            for ranks in swept((2, 3), (3,)):
                self.assert_same_history(one, self.solve(text + "solver: {newton: {relative: 1e-12}}\n", time, ranks), 1e-7)
            self.write("part.yaml", text + "solver: {newton: {relative: 1e-12}}\ncheckpoint: {}\n"
                       "time: {method: dirk22, step: 5 ms, end: 0.025}\n")
            self.run_input("part.yaml", output="part")
            self.pliant("resume", "part", "--quiet", "--set", "time.end=0.05")
            resumed = read_history(self.directory / "part")
            for name in ("kinetic_energy", "elastic_energy", "Lx", "Ly", "pz"):
                np.testing.assert_allclose(resumed[name][-1], one[name][-1], rtol=1e-6, atol=1e-9, err_msg=name)

    def test_rods_meet_in_a_rigid_body_or_at_a_point(self):
        h = self.solve(JOINED, "method: bdf2, step: 5 ms, end: 0.1")
        self.assertLess(h["block_qw"].min(), 1 - 1e-4)  # the boom pulls it round
        # Two strings of a swing, with a point in common, hinge there.
        swing = """rods:
  - {name: left, points: [[-0.3, 0, 0.4], [0, 0, 0]], segments: 1, radius: 1 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 1000,
     start: ground}
  - {name: right, points: [[0, 0, 0], [0.3, 0, 0.4]], segments: 1, radius: 1 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 1000,
     end: ground}
loads: [{gravity: [0, 0, -9.81]}]
"""
        h = self.end_of(swing)
        weight = 2 * 0.5 * np.pi * 1e-6 * 1000 * 9.81
        np.testing.assert_allclose(h["left_start_fz"] + h["right_end_fz"], weight, rtol=1e-6)
        np.testing.assert_allclose(h["left_start_fx"], -h["right_end_fx"], rtol=1e-6)

    def test_corners(self):
        """A bracket that its tip bends out of its plane. Segments are as long as the section is wide: frames of both legs meet."""
        legs = "[[0, 0, 0], [0.24, 0, 0], [0.24, -0.24, 0]]"
        more = """segments: N, section: {width: 24 mm, height: 24 mm, up: [0, 0, 1]}, density: 1000, youngs_modulus: 1 GPa, poissons_ratio: 0.25"""
        joined = f"""rods:
  - {{name: first, points: [[0, 0, 0], [0.24, 0, 0]], {more}, start: ground, end: knee}}
  - {{name: second, points: [[0.24, 0, 0], [0.24, -0.24, 0]], {more}, start: knee, end: hand}}
rigid_bodies: [{{name: hand, center: [0.24, -0.24, 0]}}, {{name: knee, center: [0.24, 0, 0]}}]
"""
        whole = f"rods: [{{name: rod, points: {legs}, {more}, start: ground, end: hand}}]\nrigid_bodies: [{{name: hand, center: [0.24, -0.24, 0]}}]\n"
        pulled = "loads: [{force: [0, 0, 0.1], volume: hand}]\n"
        bending, torsion = 1e9 * 0.024**4 / 12, 1e9 / 2.5 * 0.1405770 * 0.024**4
        exact = 0.1 * 0.24**3 * (2 / (3 * bending) + 1 / torsion)

        def error(text, n):
            return self.end_of(text.replace("segments: N", f"segments: {n}") + pulled)["hand_z"] / exact - 1

        self.assertLess(abs(error(joined, 10)), 0.004)
        coarse, fine = error(whole, 10), error(whole, 20)
        self.assertLess(abs(coarse), 0.04)
        self.assertLess(abs(fine), 0.6 * abs(coarse))  # of first order: a corner has no radius

    def test_points_of_rods_are_one_up_to_rounding(self):
        # Strings of a swing whose common point was computed twice.
        rod = "radius: 1 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 1000"
        swing = f"""rods:
  - {{name: left, points: [[-0.3, 0, 0.4], [0, 0, 0]], segments: 1, {rod}, start: ground}}
  - {{name: right, points: [[1e-10, -2e-10, 0], [0.3, 0, 0.4]], segments: 1, {rod}, end: ground}}
loads: [{{gravity: [0, 0, -9.81]}}]
"""
        weight = 2 * 0.5 * np.pi * 1e-6 * 1000 * 9.81
        for ranks in (1, 2):
            h = self.end_of(swing, ranks)
            np.testing.assert_allclose(h["left_start_fz"], weight / 2, rtol=1e-6)
            np.testing.assert_allclose(h["left_start_fx"], -h["right_end_fx"], rtol=1e-6)
        self.assertLess(abs(self.end_of(swing.replace("1e-10, -2e-10", "1e-5, 0"))["left_start_fx"]), 1e-6 * weight)  # two pendulums

    def test_rods_that_share_segments(self):
        # Two equal rods at one place are twice as stiff, whether all of their segments are the same or one is.
        beam = "points: [[0, 0, 0], [1, 0, 0]], segments: 4, radius: 10 mm, youngs_modulus: 10 MPa, poissons_ratio: 0.3, density: 1000"
        single = f"rods: [{{name: a, {beam}, start: ground, end: tip}}]\n"
        end = "rigid_bodies: [{name: tip, center: [1, 0, 0]}]\nloads: [{force: [0, 0, FORCE], volume: tip}]\n"
        one = self.end_of(single + end.replace("FORCE", "1e-4"))
        double = single.replace("]\n", f", {{name: b, {beam}, start: ground, end: tip}}]\n")
        for ranks in (1, 2):
            two = self.end_of(double + end.replace("FORCE", "2e-4"), ranks)
            np.testing.assert_allclose(two["tip_z"], one["tip_z"], rtol=1e-6)
            np.testing.assert_allclose(two["a_start_fz"] + two["b_start_fz"], -2e-4, rtol=1e-6)
        shared = f"""rods:
  - {{name: a, {beam}}}
  - {{name: b, {beam.replace("[0, 0, 0], [1, 0, 0]], segments: 4", "[0.5, 0, 0], [0.75, 0, 0], [0.75, 0.5, 0]], segments: 1")}}}
"""
        self.write("in.yaml", shared + "time: {method: bdf2, step: 1 ms, end: 1 ms}\n")
        self.pliant("modes", "in.yaml", "--output", "modes", "--number", "9")
        rows = np.genfromtxt(self.directory / "modes/modes.csv", delimiter=",", names=True)
        self.assertGreater(rows["eigenvalue"].min(), -1e-3 * np.abs(rows["eigenvalue"]).max())

    def test_a_rod_at_rest_has_nothing_to_warn_of(self):
        # Energies and forces are rounding errors: of 1e-26 J, where E A L is 3e3 J.
        self.write("in.yaml", """rods: [{name: a, points: [[0, 0, 0], [1, 0, 0]], segments: 40, radius: 0.01, density: 1000, youngs_modulus: 1e7, poissons_ratio: 0.3}]
initial: {displacement: ["0-x-y", "x-y", 0]}
time: {method: dirk33, step: 1 ms, end: 2 ms}
""")
        done = self.pliant("run", "in.yaml")
        self.assertNotIn("warning", done.stdout + done.stderr)

    def test_an_oblique_rod_next_to_an_incompressible_body(self):
        """Its frames start with rounding errors, the body undeformed."""
        write_box(self.directory / "pad.msh", (1, 1, 1), (0.1, 0.1, 0.1))
        self.pliant("run", self.write("pad.yaml", """
mesh: {file: pad.msh}
element: P2
volumetric: mixed
bodies: [{density: 1000, elasticity: {model: neo-hookean-isochoric, youngs_modulus: 1 MPa, poissons_ratio: 0.5}}]
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
rods: [{name: wire, points: [[0.3, 0, 0], [0.4, 0.1, 0.1]], segments: 2, radius: 1 mm, density: 1000, youngs_modulus: 100 MPa, poissons_ratio: 0.3}]
loads: [{gravity: [0, 0, -0.1]}]
time: {method: bdf2, step: 2 ms, end: 2 ms}
"""))
        self.assertEqual(read_history(self.directory / "out/pad")["time"][-1], 2e-3)

    def test_ranks_without_a_rod_beside_quadratic_elements(self):
        write_box(self.directory / "pad.msh", (3, 1, 1), (0.3, 0.1, 0.1))
        self.write("pad.yaml", """
mesh: {file: pad.msh}
element: P2
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}]
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
rods: [{name: w, points: [[0.7, 0.1, 0.1], [0.8, 0.1, 0.1]], segments: 2, radius: 4 mm, density: 1500, youngs_modulus: 10 MPa, poissons_ratio: 0.3, start: ground}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 2 ms, end: 4 ms}
""")
        alone, shared = (self.run_input("pad.yaml", ranks=ranks, timeout=60) for ranks in (1, 2))
        for column in ("elastic_energy", "kinetic_energy"):
            np.testing.assert_allclose(shared[column], alone[column], rtol=1e-6)

    def test_turns_of_a_prescribed_rotation_are_kept(self):
        # The torque is G J/L times the angle, more than a turn, however long the steps: they are cut where they turn by half a turn or more.
        rod = "points: [[0, 0, 0], [1, 0, 0]], segments: 8, radius: 10 mm, youngs_modulus: 2.6 MPa, poissons_ratio: 0.3, density: 1000"
        text = f"""rods: [{{name: rod, {rod}, start: ground, end: hub}}]
rigid_bodies: [{{name: hub, center: [1, 0, 0]}}]
"""
        torque = 1e6 * np.pi / 2 * 0.01**4
        held = "constraints: [{volume: hub, rigid: {translation: [free, 0, 0], rotation: {axis: [1, 0, 0], angle: ANGLE}}}]\n"
        for method, angle, turn in (("static, load_steps: 1", "7", 7), ("static, load_steps: 2", "-7", -7),
                                    ("static, load_steps: 1", "3.5", 3.5), ("quasistatic, step: 0.5, end: 1", "7*t", 7),
                                    ("static, load_steps: 1, path: {max_load: 1}", "7", 7)):
            with self.subTest(method):
                h = self.solve(text + held.replace("ANGLE", f'"{angle}"'), f"method: {method}")
                np.testing.assert_allclose(h["rod_start_tx"][-1], -torque * turn, rtol=1e-3)
        hinge = """joints: [{name: drive, type: hinge, between: [ground, hub], point: [1, 0, 0], axis: [1, 0, 0], motion: "7*t"}]\n"""
        h = self.solve(text + hinge, "method: quasistatic, step: 1, end: 1")
        np.testing.assert_allclose(h["rod_start_tx"][-1], -torque * 7, rtol=1e-3)
        # A jump cannot be cut.
        self.write("in.yaml", text + held.replace("ANGLE", '"t <= 0.5 ? 0 : 4*pi"') + "time: {method: quasistatic, step: 0.5, end: 1}\n")
        self.assertIn("the rotation of volume 'hub' jumps by 12.57 rad at t = 0.5 s", self.pliant("run", "in.yaml").stderr)

    def test_a_wire_in_a_body_adds_its_stiffness(self):
        # Uniform tension of a bar without lateral contraction, with a wire inside and one on an edge.
        self.write("bar.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.1, 0.02, 0.02};
Point(101) = {0, 0.01, 0.013}; Point(102) = {0.1, 0.01, 0.013};
Line(101) = {101, 102};
BooleanFragments{ Volume{1}; Delete; }{ Curve{101}; Delete; }
Physical Volume("bar") = {1};
Physical Curve("wire") = {101};
Physical Curve("edge") = Curve In BoundingBox {-1e-6, -1e-6, -1e-6, 0.11, 1e-6, 1e-6};
Physical Surface("left") = Surface In BoundingBox {-1e-6, -1, -1, 1e-6, 1, 1};
Physical Surface("right") = Surface In BoundingBox {0.0999, -1, -1, 0.11, 1, 1};
Mesh.MeshSizeMax = 0.012;
""")
        text = """mesh: {file: bar.geo}
bodies: [{density: 1000, elasticity: {model: linear, youngs_modulus: 1 MPa, poissons_ratio: 0}}]
rods: [{name: wire, curve: CURVE, radius: 0.5 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 7800}]
probes: [{name: tip, point: [0.1, 0.01, 0.01]}]
"""
        strain = 1e-4
        pulled = f"""constraints: [{{surface: left, displacement: [0, free, free]}}, {{surface: right, displacement: [{0.1 * strain}, free, free]}},
  {{where: "x < 1e-9 && y < 1e-9", displacement: [free, 0, free]}}, {{where: "x < 1e-9 && z < 1e-9", displacement: [free, free, 0]}}]
"""
        together = strain * (1e6 * 4e-4 + 1e9 * np.pi * 0.25e-6)
        for curve in ("wire", "edge"):
            h = self.end_of(text.replace("CURVE", curve) + pulled)
            np.testing.assert_allclose(h["right_fx"], together, rtol=1e-6)
            np.testing.assert_allclose(h["wire_length"], 0.1 * (1 + strain), rtol=1e-9)
        # Bent under its weight: the frames of the wire turn with the body, and nothing is left undetermined. A stiff wire
        # makes the bar as stiff as it is itself.
        bent = "constraints: [{surface: left, displacement: [0, 0, 0]}]\nloads: [{gravity: [0, 0, -0.1]}]\n"
        stiff = text.replace("CURVE", "wire, start: ground").replace("1 GPa", "1e5 GPa")
        soft = text.replace("CURVE", "wire").replace("1 GPa", "1 kPa")
        one, *others = [self.end_of(stiff + bent, ranks) for ranks in swept((1, 2, 3), (1, 2))]
        for other in others:
            np.testing.assert_allclose(other["tip_z"], one["tip_z"], rtol=1e-6)
        self.assertLess(abs(one["tip_z"] - 0.01), 0.02 * abs(self.end_of(soft + bent)["tip_z"] - 0.01))
        # A ribbon on an edge, of which a quarter is inside, whatever the signs of its axes.
        ribbon = text.replace("CURVE, radius: 0.5 mm", "edge, start: ground, section: {width: 4 mm, height: 1 mm, up: UP}")
        ups = [self.end_of(ribbon.replace("UP", up) + bent)["tip_z"] for up in ("[0, 0, 1]", "[0, 0, -1]")]
        self.assertAlmostEqual(ups[0], ups[1], delta=1e-6 * abs(ups[0] - 0.01))
        # Until it is loaded, nothing moves: the frames are at rest to the last digit.
        late = bent.replace("-0.1]", '"-0.1*max(0, t-0.02)"]')
        for time in ("method: static", "method: quasistatic, step: 10 ms, end: 30 ms", "method: bdf2, step: 10 ms, end: 30 ms"):
            h = self.solve(stiff + (late if "step" in time else bent.split("loads")[0]), time)
            np.testing.assert_array_equal(h["elastic_energy"][:3], 0)

    def test_a_turned_model_gives_the_same(self):
        # Round wires, whose directors have any direction: on an edge of a skew bar, with an angle of 60 degrees, and in a face.
        n = (5, 2, 2)
        skew = lambda x: np.stack([x[..., 0], x[..., 1] + 0.5 * x[..., 2], np.sqrt(0.75) * x[..., 2]], axis=-1)
        points, triangles, cells = box(n, (0.1, 0.03, 0.03), shape=skew)
        curves = {"edge": np.arange(n[0] + 1), "face": np.arange(n[0] + 1) + n[0] + 1}

        def turned(angle):
            """Where the tip moves, in the axes of the model that is turned about x."""
            c, s = np.cos(angle), np.sin(angle)
            Q = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
            write_mesh(self.directory / "turned.msh", points @ Q.T, triangles, cells)
            add_curves(self.directory / "turned.msh", curves)
            vector = lambda x: "[" + ", ".join(f"{value:.17g}" for value in Q @ np.array(x)) + "]"
            rods = "".join(f"  - {{name: {name}, curve: {name}, radius: 2 mm, density: 7800, youngs_modulus: 1e8, poissons_ratio: 0.3}}\n"
                           for name in ("edge", "face"))
            h = self.solve(f"""mesh: {{file: turned.msh}}
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}}}]
rods:
{rods}constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{gravity: {vector([1, -5, -8])}}}]
probes: [{{name: p, point: {vector([0.1, 0, 0])}}}]
solver: {{newton: {{relative: 1e-12}}}}
""", "method: static")
            return np.array([h[f"p_u{axis}"][-1] for axis in "xyz"]) @ Q

        reference = turned(0)
        self.assertGreater(np.abs(reference).max(), 1e-3)
        for angle in swept((0.35, 0.8, 1.2, 2.5), (0.8,)):
            # Frames follow the first director, and the body shears sections a little: up to 4e-5. With four places of a section, 2e-3.
            np.testing.assert_allclose(turned(angle), reference, rtol=0, atol=1e-4 * np.abs(reference).max())

    def write_bar_with_line(self, length, width, height, size):
        """A square bar along x with a line `line` in it or on it, and surfaces `left` and `right`."""
        self.write("bar.geo", f"""SetFactory("OpenCASCADE");
Box(1) = {{0, 0, 0, {length}, {width}, {width}}};
Point(101) = {{0, {width / 2}, {height}}}; Point(102) = {{{length}, {width / 2}, {height}}};
Line(101) = {{101, 102}};
BooleanFragments{{ Volume{{1}}; Delete; }}{{ Curve{{101}}; Delete; }}
Physical Volume("bar") = {{1}};
Physical Curve("line") = {{101}};
Physical Surface("left") = Surface In BoundingBox {{-1e-6, -1, -1, 1e-6, 1, 1}};
Physical Surface("right") = Surface In BoundingBox {{{length - 1e-6}, -1, -1, {length + 1e-6}, 1, 1}};
Mesh.MeshSizeMax = {size};
""")

    def test_fibres(self):
        # A thin wire near the lower side of a bar: without its bending, which counts for nothing, it has no frames.
        self.write_bar_with_line(0.05, 0.01, 0.002, 0.005)
        text = """mesh: {file: bar.geo}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}]
rods: [{name: wire, curve: line, radius: 0.05 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 7800, damping: 2 msMORE}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
probes: [{name: tip, point: [0.05, 0.005, 0.005]}]
solver: {newton: {relative: 1e-11}}
"""
        time = "method: bdf2, step: 5 ms, end: 0.05"
        columns = "output: {every: 1, history: [{name: f, of: rod_force, in: wire, take: min}, {name: m, of: rod_bending_moment, in: wire, take: max}]}"

        def solve(more, ranks=1):
            self.write("in.yaml", text.replace("MORE", more) + f"time: {{{time}}}\n{columns}\n")
            return self.run_input("in.yaml", ranks=ranks)

        fibre, same, rod = solve(""), solve(", bending: false", 2), solve(", bending: true")
        self.assert_same_history({name: fibre[name] for name in same if "iterations" not in name},
                                 {name: same[name] for name in same if "iterations" not in name}, 1e-6)
        fall, of_rod = (h["tip_z"] - 0.005 for h in (fibre, rod))
        self.assertLess(fall.min(), -1e-4)
        np.testing.assert_allclose(fall, of_rod, atol=5e-3 * np.abs(fall).max())
        np.testing.assert_allclose(fibre["f"], rod["f"], atol=1e-3 * np.abs(fibre["f"]).max())
        self.assertLess(fibre["f"].min(), -1e-4)
        np.testing.assert_array_equal(fibre["m"], 0)
        self.assertGreater(rod["m"].max(), 0)
        self.assertGreater(fibre["dissipated_rod_viscosity"][-1], 0)
        np.testing.assert_allclose(fibre["energy_balance_error"], 0, atol=1e-6 * np.abs(fibre["kinetic_energy"]).max())
        self.write("in.yaml", text.replace("MORE", "") + f"time: {{{time}}}\n{columns}\n")
        self.assertIn("'rod_bending_moment' is 0 in fibres (wire)", self.pliant("run", "in.yaml").stderr)
        self.assertRegex(self.pliant("check", "in.yaml").stdout, r"wire: \d+ segments, 0.05 m long, .*; a fibre: only E A counts")
        # Its weight acts by its name, too, and what bends as much as its surroundings is a rod.
        weight = text.replace("MORE", "").replace("-9.81]", "-9.81], volume: wire")
        h = self.solve(weight, "method: static")
        np.testing.assert_allclose(h["left_fz"][-1], np.pi * 2.5e-9 * 0.05 * 7800 * 9.81, rtol=1e-6)
        self.write("in.yaml", text.replace("MORE", "").replace("0.05 mm", "0.5 mm") + f"time: {{{time}}}\n")
        self.assertNotIn("a fibre", self.pliant("check", "in.yaml").stdout)

    def test_what_a_fibre_does_not_need(self):
        # A direction of its section, and a line without a turn back; its name selects its nodes.
        self.write_bar_with_line(0.05, 0.01, 0.002, 0.005)
        text = """mesh: {file: bar.geo}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}]
rods: [{name: wire, curve: line, section: {width: 50 um, height: 100 um, up: UP}, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 7800, bending: false}]
constraints: [{WHERE, displacement: [0, 0, 0]}]
loads: [{gravity: [9.81, 0, 0]}]
probes: [{name: tip, point: [0.05, 0.005, 0.005]}]
time: {method: static}
output: {fields: [displacement, rod_force], history: [{name: f, of: rod_force, in: wire, take: max}]}
"""

        def end(up, where="surface: left", ranks=1):
            self.write("in.yaml", text.replace("UP", up).replace("WHERE", where))
            return {name: column[-1] for name, column in self.run_input("in.yaml", ranks=ranks).items()}

        across = end("[0, 0, 1]")
        self.assertGreater(across["f"], 1e-5)
        for ranks in (1, 2):
            along = end("[1, 0, 0]", ranks=ranks)
            for name in ("f", "tip_ux", "wire_length"):
                self.assertAlmostEqual(along[name] / across[name], 1, delta=1e-7)
        for where in ("volume: wire", "curve: line"):
            self.assertAlmostEqual(end("[0, 0, 1]", where)["wire_length"], 0.05, delta=1e-14)

    def test_a_wire_on_a_free_shell(self):
        # Triangles hold its sections as tetrahedra do: it falls with the sheet, and weighs on what holds that.
        n = 6
        write_patch(self.directory / "sheet.msh", n, lambda s, t: (0.2 * s, 0.1 * t, 0.05 * s * s))
        add_curves(self.directory / "sheet.msh", {"middle": [n // 2 * (n + 1) + i for i in range(n + 1)], "side": list(range(n + 1))})
        text = """mesh: {file: sheet.msh}
shells: [{name: sheet, surface: sheet, free: true, thickness: 1 mm, density: 1000, bending: true,
          elasticity: {model: neo-hookean, youngs_modulus: 5 MPa, poissons_ratio: 0.4}CLAMPED}]
rods:
  - {name: wire, curve: middle, radius: 0.3 mm, density: 7800, youngs_modulus: 1 GPa, poissons_ratio: 0.3}
  - {name: strip, curve: side, section: {width: 0.4 mm, height: 0.8 mm, up: [0, 0, 1]}, density: 7800, youngs_modulus: 1 GPa, poissons_ratio: 0.3}
loads: [{gravity: [0, 0, -9.81]}]
probes: [{name: tip, point: [0.2, 0.05, 0.05]}]
solver: {newton: {relative: 1e-11}}
"""
        for element, ranks in swept([(e, r) for e in ("P1", "P2") for r in (1, 2, 3)], [("P1", 2), ("P2", 1)]):
            h = self.solve(text.replace("CLAMPED", "") + f"element: {element}\n", "method: implicit-midpoint, step: 5 ms, end: 0.05", ranks)
            np.testing.assert_allclose(h["tip_uz"], -9.81 * h["time"]**2 / 2, atol=1e-9)
        mass = -h["pz"][-1] / (9.81 * h["time"][-1])
        held = ", clamped: [{curve: s0}]}]\nconstraints: [{curve: s0, name: root, displacement: [0, 0, 0]}"
        h = self.solve(text.replace("CLAMPED}]", held + "]"), "method: static, load_steps: 4")
        self.assertAlmostEqual(h["root_fz"][-1] / (9.81 * mass), 1, delta=1e-6)
        self.assertLess(h["tip_uz"][-1], -5e-3)

    def test_an_inextensible_fibre(self):
        # A wire on the side of a bar that is pulled: the bar curls, and the stiffer the wire, the less depends on its stiffness.
        self.write_bar_with_line(0.1, 0.02, 0.02, 0.012)
        radius, of_bar = 1e-6, 1e6 * 4e-4  # so thin that it does not resist bending
        tips, stretches = [], []
        for ratio in (1e2, 1e3, 1e4, 1e6):
            h = self.solve(f"""mesh: {{file: bar.geo}}
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.45}}}}]
rods: [{{name: wire, curve: line, radius: {radius}, youngs_modulus: {ratio * of_bar / (np.pi * radius**2)}, poissons_ratio: 0.3, density: 1400, start: ground}}]
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{surface: right, traction: [2e5, 0, 0]}}]
probes: [{{name: tip, point: [0.1, 0.01, 0.01]}}]
""", "method: static, load_steps: 5")
            self.assertEqual(len(h["step"]), 6, "a step was cut")
            self.assertLess(h["newton_iterations"].max(), 30)
            tips.append(h["tip_z"][-1] - 0.01)
            stretches.append(ratio * (h["wire_length"][-1] / 0.1 - 1))
        self.assertGreater(tips[-1], 7e-3)
        np.testing.assert_allclose(stretches[2:], stretches[1], rtol=2e-3)  # the force in it tends to a limit
        change = np.abs(np.diff(tips))
        self.assertLess(change[1], 0.15 * change[0])
        self.assertLess(change[2], 5e-4 * tips[-1])

    def test_a_rod_alone_is_drawn(self):
        self.solve("""rods: [{name: wire, points: [[0, 0, 0], [1, 0, 0]], segments: 4, radius: 5 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 1000, start: ground}]
loads: [{gravity: [0, 0, -9.81]}]
""", "method: bdf2, step: 5 ms, end: 0.01")
        self.pliant("render", "out", "--size=320x240", "--output", "rods.png")
        mesh = pliant.Result(self.directory / "out").mesh()
        np.testing.assert_allclose(np.linalg.norm(RodShapes(mesh).at(mesh.coordinates)[:, 2:], axis=2), 5e-3)
        self.assertIn("--scale 1 only", self.pliant("render", "out", "--scale", 2, status=2).stderr)

    def test_results(self):
        self.solve(JOINED, "method: bdf2, step: 5 ms, end: 0.01", 2)
        result = pliant.Result(self.directory / "out")
        self.assertEqual(list(result.rods), ["mast", "boom"])
        mast = result.rods["mast"]
        self.assertEqual(mast.points.shape[1:], (6, 3))
        np.testing.assert_allclose(mast.points[0, :, 2], np.linspace(0, 0.5, 6), atol=1e-12)
        self.assertLess(mast.tension[-1].min(), 0)  # carries weight
        self.assertEqual(result.mesh().rods, ["mast", "boom"])
        self.assertEqual(result.mesh().sections, ["mast_start", "mast_end", "boom_start"])
        shown = self.pliant("check", "in.yaml").stdout
        self.assertRegex(shown, r"mast: 5 segments, 0.5 m long, mass 0.157\d* kg; stiffness: E A 3141.59 N, .*start fixed in ground.*\n    extent \[.*\] x \[.*\] x \[0, 0\.5\] m\n")
        self.assertRegex(shown, r"size       \d+ segments of rods\n")

    def test_what_is_refused(self):
        line = f"rods: [{{name: beam, points: [[0, 0, 0], [1, 0, 0]], {SLENDER}, start: ground}}]\ntime: {{method: static}}\n"
        dynamic = line.replace("method: static", "method: bdf2, step: 1 ms, end: 1 ms")
        cases = {
            "missing key 'radius' of rod 'beam'": line.replace("radius: 1 mm, ", ""),
            "rod 'beam' has a 'radius' and a rectangular 'section'": line.replace(
                "radius: 1 mm", "radius: 1 mm, section: {width: 1, height: 1, up: [0, 0, 1]}"),
            "is parallel to its `up`": line.replace("radius: 1 mm", "section: {width: 1, height: 1, up: [1, 0, 0]}"),
            "rod 'beam' is fixed in 'grund', which is not a rigid body (did you mean 'ground'?)": line.replace("start: ground", "start: grund"),
            "which dynamics needs": dynamic,
            "which gravity needs": line + "loads: [{gravity: [0, 0, -1]}]\n",
            "rod 'beam' has the same point twice": line.replace("[1, 0, 0]]", "[1, 0, 0], [1, 0, 0]]"),
            "turns back on itself": line.replace("[1, 0, 0]]", "[1, 0, 0], [0.5, 0, 0]]"),
            "follows a curve of the mesh, which this input lacks": line.replace("points: [[0, 0, 0], [1, 0, 0]]", "curve: wire"),
            "give it one instead of `points`, or remove 'bending: false'": line.replace("radius: 1 mm", "radius: 1 mm, bending: false"),
            "nothing holds the part of the mesh near": line.replace("start: ground}", "start: ground, density: 1}, "
                "{name: loose, points: [[0, 0, 1], [1, 0, 1]], " + SLENDER + ", density: 1}") + "loads: [{gravity: [0, 0, -1]}]\n",
            "names a rod and a probe": line + "probes: [{name: beam, point: [0, 0, 0]}]\n",
        }
        self.write("in.yaml", SHAKEN + "time: {method: bdf2, step: 2 ms, end: 0.2}\n")
        self.assertIn("rods cannot be refined with the mesh", self.pliant("converge", "in.yaml", "--in", "space", status=2).stderr)
        for message, text in cases.items():
            with self.subTest(message):
                self.write("in.yaml", text)
                done = self.call("run", "in.yaml", ranks=2 if "up" in message else 1)
                self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                self.assertIn(message, done.stderr)
                self.assertRegex(done.stderr, r"in\.yaml:\d+:\d+: ")


if __name__ == "__main__":
    unittest.main()
