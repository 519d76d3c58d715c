#!/usr/bin/python3
"""Free shells and rods that touch obstacles, solids, one another and themselves: at what distance, what does not pass, ranks, messages."""
import unittest

import numpy as np

from program import LONG, ProgramTest, read_history
from shell_meshes import write_shell

G = 9.81
RUBBER = "elasticity: {model: neo-hookean, youngs_modulus: 2e5, poissons_ratio: 0.3}"
ROD = "density: 1100, youngs_modulus: 1e6, poissons_ratio: 0.4"

# A block of 40 x 40 x 20 mm, a sheet of 60 x 60 mm at the height of %s, and none of the mesh's nodes in common.
GEOMETRY = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, -1, 4, 4, 2};
Rectangle(100) = {-3, -3, %s, 6, 6};
Physical Volume("block") = {1};
Physical Surface("base") = {5};
Physical Surface("sheet") = {100};
Mesh.MeshSizeMin = 1.5;
Mesh.MeshSizeMax = 1.5;
"""
BLOCK = f"""mesh: {{file: sheet.geo, scale: 0.01}}
bodies: [{{volume: block, density: 1000, {RUBBER}}}]
shells: [{{name: cloth, surface: sheet, free: true, thickness: 2 mm, bending: true, density: 1000, {RUBBER}}}]
"""


def falling(speed, law="barrier"):
    """The cloth flies at the block; nothing else acts."""
    return BLOCK + f"""initial: {{velocity: [0, 0, "abs(z) > 0.0101 ? {speed} : 0"]}}
contact: {{law: {law}, pairs: [{{name: hit, surface: cloth, with: block}}]}}
time: {{method: backward-euler, step: 2 ms, end: 0.016}}
output: {{every: 1, fields: [displacement, contact_pressure, contact_gap]}}
"""


def two_rods(contact="law: barrier, pairs: [{name: crossing, surface: high, with: low}]", gap=0.012, more=""):
    """A rod of 3 mm radius that flies at one of 2 mm, across and not in the middle of segments."""
    return f"""rods:
  - {{name: low, points: [[-0.1, 0, 0], [0.1, 0, 0]], segments: 9, radius: 2 mm, {ROD}}}
  - {{name: high, points: [[0.005, -0.1, {gap}], [0.005, 0.1, {gap}]], segments: 10, radius: 3 mm, {ROD}}}
initial: {{velocity: [0, 0, "z > 0.003 ? -2 : 0"]}}
contact: {{{contact}}}
{more}time: {{method: bdf2, step: 1 ms, end: 0.02}}
"""


class ThinContact(ProgramTest):
    def test_a_shell_touches_with_both_sides_at_half_its_thickness(self):
        histories = {}
        for side, height, speed in (("above", "1.2", -1), ("below", "-1.2", 1)):
            self.write("sheet.geo", GEOMETRY % height)
            h = histories[side] = self.run_input(self.write("in.yaml", falling(speed)), output=side)
            self.assertGreater(h["contact_points"].max(), 10)
            self.assertGreater(h["contact_gap_min"].min(), 0)
            self.assertLess(h["contact_gap_min"].min(), 3e-4, "it comes to where its surface touches")
            mass = 1000 * (0.06**2 * 2e-3 + 0.04 * 0.04 * 0.02)
            self.assertGreater(abs(h["hit_jz"][-1]), 0.9 * 1000 * 0.06**2 * 2e-3, "it is stopped")
            for name in ("px", "py", "pz"):  # nothing from outside
                self.assertLess(np.abs(h[name] - h[name][0]).max(), 1e-9 * mass)
            self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * h["kinetic_energy"][0])
        # Either side is the same, to what the two meshes of the block differ by.
        gap = lambda h: h["contact_gap_min"][h["contact_points"] > 0].min()
        self.assertAlmostEqual(gap(histories["above"]) / gap(histories["below"]), 1, delta=0.03)
        self.assertAlmostEqual(histories["above"]["hit_jz"][-1] / histories["below"]["hit_jz"][-1], -1, delta=1e-3)

    def test_a_rod_rests_on_a_plane_at_its_radius(self):
        for element, law in (("P1", "barrier"), ("P2", "penalty")):
            text = f"""rods: [{{name: rope, points: [[-0.1, 0, 0.01], [0.1, 0, 0.01]], segments: 5, radius: 2 mm, {ROD}, damping: 1 ms}}]
element: {element}
loads: [{{gravity: [0, 0, {-G}]}}]
probes: [{{name: middle, point: [0, 0, 0.01]}}]
contact: {{law: {law}, obstacles: [{{name: floor, shape: plane, point: [0, 0, 0], normal: [0, 0, 1]}}]}}
time: {{method: backward-euler, step: 4 ms, end: 0.12}}
"""
            h = self.run_input(self.write("floor.yaml", text), output=element)
            weight = 1100 * np.pi * 2e-3**2 * 0.2 * G
            self.assertAlmostEqual(h["floor_fz"][-1] / weight, 1, delta=1e-6)
            self.assertAlmostEqual(h["middle_z"][-1], 2e-3 + h["contact_gap_min"][-1], delta=1e-7)
            self.assertLess(abs(h["contact_gap_min"][-1]), 5e-4)
            self.assertEqual(h["contact_gap_min"][-1] > 0, law == "barrier")

    def test_rods_cross_and_do_not_pass(self):
        probes = "probes: [{name: up, point: [0.005, 0, 0.012]}, {name: down, point: [0.005, 0, 0]}]\n"
        h = self.run_input(self.write("rods.yaml", two_rods(more=probes)))
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertLess(h["contact_gap_min"].min(), 3e-4)
        mass = 1100 * np.pi * 0.2 * 3e-3**2
        self.assertGreater((h["up_z"] - h["down_z"]).min(), 5e-3, "the sum of the radii")
        self.assertLess(np.abs(h["pz"] - h["pz"][0]).max(), 1e-9 * 2 * mass)
        size = np.abs(h["Lx"]).max() + 2 * mass * 0.1
        for name in ("Lx", "Ly", "Lz"):
            self.assertLess(np.abs(h[name] - h[name][0]).max(), 1e-3 * size, "backward Euler starts bdf2")
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * h["kinetic_energy"][0])
        # Without the pair they pass.
        h = self.run_input(self.write("free.yaml", two_rods("law: barrier, pairs: [{surface: high}]", more=probes)), output="free")
        self.assertLess((h["up_z"] - h["down_z"])[-1], 0, "it has passed")

    def test_a_rod_does_not_pass_through_itself(self):
        # A hairpin whose ends a spring pulls together; segments are shorter than it is thick.
        text = f"""rods: [{{name: pin, points: [[0, 0, 0], [0.06, 0, 0], [0.06, 0.02, 0], [0, 0.02, 0]], size: 3 mm, radius: 2 mm, {ROD}, damping: 10 ms}}]
springs: [{{name: pull, points: [[0, 0, 0], [0, 0.02, 0]], stiffness: 20, rest: 0}}]
contact: {{law: barrier, pairs: [{{surface: pin}}]}}
time: {{method: backward-euler, step: 5 ms, end: 0.1}}
"""
        h = self.run_input(self.write("pin.yaml", text))
        self.assertGreater(h["contact_points"].max(), 0)
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertAlmostEqual(h["pull_length"][-1], 4e-3, delta=4e-4)

    def test_a_shell_touches_itself(self):
        # A strip, bent to three quarters of a ring, whose ends fly at each other: edge meets edge, and they slip past each other at its
        # thickness.
        n, m, radius = 16, 2, 0.02
        angles = np.linspace(np.radians(-135), np.radians(135), n + 1)
        nodes = [(radius * np.cos(a), radius * np.sin(a), 0.005 * j) for a in angles for j in range(m + 1)]
        at = lambda i, j: i * (m + 1) + j
        triangles = [t for i in range(n) for j in range(m)
                     for t in ((at(i, j), at(i + 1, j), at(i, j + 1)), (at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))]
        write_shell(self.directory / "ring.msh", nodes, triangles)
        text = f"""mesh: {{file: ring.msh}}
shells: [{{name: ring, surface: sheet, free: true, thickness: 1 mm, bending: true, density: 1000, {RUBBER}}}]
initial: {{velocity: [0, "x < -0.005 ? -3*y/0.015 : 0", 0]}}
contact: {{law: barrier, pairs: all}}
time: {{method: backward-euler, step: 1 ms, end: 0.016}}
"""
        h = self.run_input(self.write("ring.yaml", text))
        self.assertGreater(h["contact_points"].max(), 0)
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertLess(h["contact_gap_min"].min(), 2e-4)

    def everything(self, element="P1", end="0.012"):
        """A cloth and a rod fall on a block on a plane; the rod is joined to another one."""
        self.write("sheet.geo", GEOMETRY % "1.25")
        return BLOCK + f"""element: {element}
rods:
  - {{name: rope, points: [[-0.035, 0.002, 0.017], [0.035, 0.004, 0.017]], segments: 7, radius: 1.5 mm, {ROD}}}
  - {{name: tail, points: [[0.035, 0.004, 0.017], [0.035, 0.004, -0.006]], segments: 3, radius: 1.5 mm, {ROD}}}
initial: {{velocity: [0.1, 0, "z > 0.0101 ? -0.8 : -0.5"]}}
loads: [{{gravity: [0, 0, {-G}]}}]
contact:
  law: barrier
  pairs: all
  friction: 0.3
  friction_update: frozen
  obstacles: [{{name: floor, shape: plane, point: [0, 0, -0.011], normal: [0, 0, 1]}}]
time: {{method: backward-euler, step: 2 ms, end: {end}}}
output: {{fields: [displacement, contact_pressure, contact_gap, contact_slip]}}
checkpoint: {{}}
"""

    def test_all_of_it_on_any_number_of_ranks_and_resumed(self):
        self.write("all.yaml", self.everything())
        h = self.run_input("all.yaml", output="one")
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertGreater(h["floor_rope_fz"].max() + h["floor_tail_fz"].max() + h["floor_block_fz"].max(), 0)
        self.assertGreater(h["contact_points"].max(), 50)
        for ranks in (2, 3) if LONG else (2,):
            self.assert_same_history(h, self.run_input("all.yaml", output=f"on{ranks}", ranks=ranks), 1e-5)
        self.run_input("all.yaml", "time.end=0.006", output="half")
        self.pliant("resume", "half", "--set", "time.end=0.012", "--quiet")
        resumed = read_history(self.directory / "half")
        for name in ("kinetic_energy", "elastic_energy", "contact_energy", "floor_jz"):
            np.testing.assert_allclose(resumed[name], h[name], rtol=1e-6, err_msg=name)

    def test_quadratic_elements(self):
        h = self.run_input(self.write("all.yaml", self.everything("P2", "0.006")))
        self.assertGreater(h["contact_points"].max(), 50)
        self.assertGreater(h["contact_gap_min"].min(), 0)

    def test_what_is_refused(self):
        self.write("sheet.geo", GEOMETRY % "1.2")
        cases = {
            "a penalty": (falling(-1, "penalty"), "free shell 'cloth' has no inside"),
            "a penalty for all": (two_rods("pairs: all"), "list the pairs that touch instead of 'pairs: all'"),
            "too near": (two_rods(gap=0.004), "m nearer than their 'thickness'"),
            "through each other": (falling(-1).replace("sheet.geo", "through.geo"), "'block' and 'cloth' overlap at the start in 1 place"),
            "rods through each other": (two_rods(gap=0.0), "m nearer than their 'thickness'"),
        }
        self.write("through.geo", GEOMETRY % "0.2")
        for name, (text, message) in cases.items():
            with self.subTest(name):
                self.write("in.yaml", text)
                done = self.pliant("run", "in.yaml", "--quiet", status=2)
                self.assertIn(message, done.stderr)

    def test_check_lists_them(self):
        done = self.pliant("check", self.write("rods.yaml", two_rods()))
        row = next(line for line in done.stdout.splitlines() if line.strip().startswith("crossing"))
        self.assertRegex(row, r"high with low +10 and 9 +barrier .* 0\.005 +- +0\.007 ")

    def test_a_rod_does_not_touch_what_it_ends_in(self):
        # It begins in the middle of a rigid block.
        self.write("block.geo", """SetFactory("OpenCASCADE");
Box(1) = {-1, -1, -1, 2, 2, 2};
Physical Volume("rigid") = {1};
Mesh.MeshSizeMax = 1;
""")
        text = f"""rigid_bodies: [{{name: hand, mass: 8 g, inertia: [5e-7, 5e-7, 5e-7], center: [0, 0, 0], surface: {{file: block.geo, scale: 0.01}}}}]
rods: [{{name: arm, points: [[0, 0, 0], [0.05, 0, 0]], segments: 10, radius: 2 mm, {ROD}, start: hand}}]
loads: [{{gravity: [0, 0, {-G}]}}]
contact: {{law: barrier, pairs: all}}
time: {{method: backward-euler, step: 2 ms, end: 0.004}}
"""
        h = self.run_input(self.write("hand.yaml", text))
        self.assertEqual(h["contact_points"].max(), 0)


if __name__ == "__main__":
    unittest.main()
