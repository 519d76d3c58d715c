#!/usr/bin/python3
"""Cavities with gas or liquid, and pressures with a potential: a thick tube, a pneumatic actuator, the ledger, bad input."""
import unittest

import numpy as np

from program import LONG, ROOT, ProgramTest, write_box
from thick_shell import ThickShell

INNER, OUTER, LENGTH = 0.5, 1.0, 0.2
YOUNG, POISSON = 1e6, 0.4
VOLUME = np.pi * INNER**2 * LENGTH / 4  # of the quarter of the bore
# A quarter of a thick tube between two plates: x is the radius before it is bent, y the angle.
TUBE = f"""
mesh: {{file: tube.msh}}
element: P2
bodies: [{{density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: {YOUNG}, poissons_ratio: {POISSON}}}}}]
constraints:
  - {{surface: front, displacement: [free, 0, free]}}
  - {{surface: back, displacement: [0, free, free]}}
  - {{surface: bottom, displacement: [free, free, 0]}}
  - {{surface: top, displacement: [free, free, 0]}}
solver: {{newton: {{relative: 1e-10}}}}
probes: [{{name: bore, point: [{INNER}, 0, 0]}}]
"""
STATIC = "time: {method: static, end: 1, load_steps: 2}\n"


def bent(points):
    r, angle, z = np.moveaxis(points, -1, 0)
    return np.stack([(INNER + r) * np.cos(angle * np.pi / 2), (INNER + r) * np.sin(angle * np.pi / 2), z], axis=-1)


class Cavities(ProgramTest):
    def tube(self, n=(4, 6, 1)):
        write_box(self.directory / "tube.msh", n, (OUTER - INNER, 1, LENGTH), order=2, shape=bent)

    def history(self, text, *settings, **more):
        return self.run_input(self.write("in.yaml", text), *settings, **more)

    # Half as much again in the bore. The pressure belongs to the volume, from which the radius is taken: 3e-5 off; nodes
    # lie 2e-4 off the circle.
    def test_a_thick_tube_follows_the_curve_of_pressure_and_radius(self):
        self.tube()
        text = TUBE + STATIC + (f"cavities: [{{name: bore, surface: left, volume: {VOLUME}, "
                                f'liquid: {{bulk_modulus: 1e11, added_volume: "{0.5 * VOLUME}*t"}}}}]\n')
        h = self.history(text)
        np.testing.assert_allclose(h["bore_volume"], [VOLUME, 1.25 * VOLUME, 1.5 * VOLUME], rtol=1e-5)
        tube = ThickShell(INNER, OUTER, YOUNG, POISSON, curved=1)
        for step in (1, 2):
            expected = tube.pressure(INNER * np.sqrt(h["bore_volume"][step] / VOLUME))
            self.assertAlmostEqual(h["bore_pressure"][step], expected, delta=1e-4 * expected)
        self.assertAlmostEqual(h["bore_x"][-1], INNER * np.sqrt(1.5), delta=1e-3 * INNER)
        if LONG:
            self.assert_same_history(h, self.history(text, ranks=2), 1e-7)

    def test_a_given_pressure_is_the_same_as_that_load(self):
        self.tube((2, 3, 1))
        fluid = self.history(TUBE + STATIC + f"cavities: [{{name: c, surface: left, volume: {VOLUME}, pressure: 2e5}}]\n")
        load = self.history(TUBE + STATIC + "loads: [{surface: left, pressure: 2e5}]\n")
        np.testing.assert_allclose(fluid["c_pressure"], [0, 1e5, 2e5])
        for name in load:
            if name not in ("newton_iterations", "linear_iterations"):
                np.testing.assert_allclose(fluid[name], load[name], rtol=1e-8, atol=1e-8 * np.abs(load[name]).max(), err_msg=name)

    def test_gas_swings_with_the_tube_and_keeps_its_law(self):
        self.tube((2, 3, 1))
        text = TUBE + (f"cavities: [{{name: c, surface: left, volume: {VOLUME}, "
                       "gas: {pressure: 3 bar, ambient: 1 bar, exponent: 1.4}}]\n")
        text += "time: {method: implicit-midpoint, step: 1 ms, end: 60 ms}\n"
        h = self.history(text)
        constant = (h["c_pressure"] + 1e5) * h["c_volume"] ** 1.4
        np.testing.assert_allclose(constant, 4e5 * VOLUME**1.4, rtol=1e-12)
        self.assertGreater(np.ptp(h["c_volume"]) / VOLUME, 0.1)
        # The gas has a potential: what it gives the tube has.
        scale = np.abs(h["load_potential"]).max()
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-8 * scale)
        np.testing.assert_allclose(h["load_work"], 0, atol=1e-8 * scale)
        self.assertLess(np.abs(h["numerical_dissipation"]).max(), 0.01 * scale)

    # For a tenth of a second 2/s of the bore's volume flows in, then half as much.
    def test_liquid_flows_in(self):
        self.tube((2, 3, 1))
        text = TUBE + (f"cavities: [{{name: c, surface: left, volume: {VOLUME}, "
                       f'liquid: {{bulk_modulus: 1e11, flow: "{VOLUME}*(t < 0.1 ? 2 : 1)"}}}}]\n')
        h = self.history(text + "time: {method: bdf2, step: 10 ms, end: 0.2, events: [0.1]}\n", ranks=2 if LONG else 1)
        t = h["time"]
        np.testing.assert_allclose(h["c_volume"] / VOLUME, 1 + 2 * np.minimum(t, 0.1) + np.maximum(0, t - 0.1), rtol=1e-5)
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-7 * h["elastic_energy"].max())

    # A closed surface, here that of the whole body, has a potential as well, and so the solver minimises.
    def test_a_pressure_on_a_closed_surface_is_minimised(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2))
        text = "mesh: {file: bar.msh}\n" + TUBE[TUBE.index("bodies"):TUBE.index("constraints")]
        text += 'loads: [{where: "x > -1", pressure: 5e4}]\ntime: {method: bdf2, step: 2 ms, end: 0.02}\n'
        done = self.call("run", self.write("in.yaml", text), "--output", "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Newton on the incremental potential", done.stdout)
        loose = text.replace('where: "x > -1"', "surface: right")
        done = self.call("run", self.write("in.yaml", loose), "--output", "out")
        self.assertIn("'pressure' has no potential", done.stdout)

    def test_the_actuator_bends_under_air_that_is_pumped_in(self):
        # 5 chambers of 6 mm x 16 mm x 16 mm, and 4 pieces of channel of 8 mm x 6 mm x 3 mm.
        volume = 5 * 6 * 16 * 16e-9 + 4 * 8 * 6 * 3e-9
        self.assertIn(f"chamber: volume {volume:.6g} m^3", self.call("check", ROOT / "input/pneumatic_actuator.yaml").stdout)
        h = self.run_input(ROOT / "input/pneumatic_actuator.yaml", "time.end=0.24", "time.events=[0.2]")
        amount = 1 + 0.5 * np.minimum(h["time"] / 0.2, 1)
        np.testing.assert_allclose((h["chamber_pressure"] + 101325) * h["chamber_volume"], 101325 * h["chamber_volume"][0] * amount,
                                   rtol=1e-10)
        self.assertAlmostEqual(h["chamber_volume"][0], volume, delta=1e-15)
        self.assertGreater(h["chamber_pressure"][-1], 5e3)
        self.assertLess(h["tip_z"][-1] - h["tip_z"][0], -5e-3)
        scale = max(np.abs(h[n]).max() for n in ("elastic_energy", "load_work", "load_potential"))
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-7 * scale)

    def test_open_cavities_are_told(self):
        self.tube((2, 3, 1))
        cavity = "cavities: [{name: c, surface: left, gas: {}}]\n"
        moving = TUBE.replace("surface: top, displacement: [free, free, 0]", "surface: top, displacement: [0, 0, 0.01]")
        shifted = TUBE.replace("surface: top, displacement: [free, free, 0]", "surface: top, displacement: [free, free, 0.01]")
        for text, message in ((shifted, "is open: the edge of surface 'left' can move (3 edges of its facets, the first near (0.125, "),
                              (moving, "is open: the edge of surface 'left' moves"),
                              (TUBE, "between two parallel planes")):
            with self.subTest(message):
                done = self.call("run", self.write("in.yaml", text + STATIC + cavity))
                self.assertEqual(done.returncode, 2, done.stdout)
                self.assertIn(message, done.stderr)

    def test_given_volumes_that_do_not_fit_the_walls(self):
        write_box(self.directory / "box.msh", (2, 2, 2), (1, 1, 1))
        around = self.write("around.yaml", """mesh: {file: box.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
cavities: [{name: tank, where: "x > -1", volume: 3, liquid: {bulk_modulus: 1e6}}]
time: {method: bdf2, step: 0.01, end: 0.1}
""")
        actuator = ROOT / "input/pneumatic_actuator.yaml"
        for arguments, message in (((around,), "the cavity 'tank' presses on"),
                                   ((around,), "point outwards from the 1 m^3 that it surrounds"),
                                   ((actuator, "--set", "cavities.0.volume=8"), "has a `volume` of 8 m^3, and its walls surround 8.26e-06 m^3")):
            with self.subTest(message):
                done = self.call("check", *arguments)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(message, done.stderr)
        done = self.call("check", actuator, "--set", "cavities.0.volume=9e-6")
        self.assertNotIn("cavity", done.stderr)
        self.assertIn("chamber: volume 9e-06 m^3; walls surround 8.256e-06 m^3", done.stdout)

    def test_an_end_that_slides_along_its_walls_is_open(self):
        # A square tube in a block, one end of which is a plate that moves along it: the lid would move, too.
        self.write("tube.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1}; Box(2) = {0, 0.25, 0.25, 1, 0.5, 0.5};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
e = 1e-6;
ends() = Surface In BoundingBox {-e, -e, -e, e, 1+e, 1+e};
tops() = Surface In BoundingBox {1-e, -e, -e, 1+e, 1+e, 1+e};
Physical Volume("block") = {3};
Physical Surface("low") = {ends()};
Physical Surface("high") = {tops()};
Physical Surface("wall") = Surface In BoundingBox {-e, 0.25-e, 0.25-e, 1+e, 0.75+e, 0.75+e};
Mesh.MeshSizeMax = 0.5;
""")
        text = """mesh: {file: tube.geo}
bodies: [{volume: block, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
constraints:
  - {surface: low, displacement: [0, 0, 0]}
  - {surface: high, HELD}
cavities: [{name: c, surface: wall, volume: 0.25, gas: {}}]
"""
        for held in ("rigid: {translation: [free, 0, 0], rotation: fixed}", "displacement: [free, 0, 0]"):
            done = self.call("run", self.write("in.yaml", text.replace("HELD", held) + STATIC))
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn("is open: the edge of surface 'wall' slides along its walls, and no lid goes with it", done.stderr)
        for held in ("displacement: [0, free, free]", "displacement: [0, 0, 0]"):
            self.assertAlmostEqual(self.history(text.replace("HELD", held) + STATIC)["c_volume"][0], 0.25, places=12)


if __name__ == "__main__":
    unittest.main()
