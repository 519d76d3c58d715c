#!/usr/bin/python3
"""Paths of equilibria through limit points: a truss, a frame and a rubber ball in closed form, ranks, resuming, errors."""
import json
import re
import unittest

import numpy as np

from browser import CHROMIUM, Browser
from program import LONG, ROOT, ProgramTest, read_history, write_box
from shell_meshes import write_patch

# A shallow truss of two springs, whose apex moves up and down only; the force at the load factor 1 is 10 N.
RISE, STIFFNESS = 0.3, 1000.0
TRUSS = f"""
rigid_bodies: [{{name: apex, mass: 1, inertia: [1, 1, 1], center: [0, 0, {RISE}]}}]
joints: [{{name: guide, type: slider, between: [ground, apex], point: [0, 0, {RISE}], axis: [0, 0, 1]}}]
springs:
  - {{name: left, points: [{{body: ground, point: [-1, 0, 0]}}, {{body: apex, point: [0, 0, {RISE}]}}], stiffness: {STIFFNESS}}}
  - {{name: right, points: [{{body: ground, point: [1, 0, 0]}}, {{body: apex, point: [0, 0, {RISE}]}}], stiffness: {STIFFNESS}}}
"""
PUSHED = "loads: [{force: [0, 0, -10], volume: apex}]\n"
# Lee's frame: hinged at both ends, E = 720, A = 6, I = 2, L = 120; wide, so that it stays in its plane.
BAR = "section: {width: 30, height: 2, up: [UP]}, density: 1, youngs_modulus: 72, poissons_ratio: 0.3"
FRAME = f"""
rods:
  - {{name: column, points: [[0, 0, 0], [0, 120, 0]], segments: 20, {BAR.replace("UP", "1, 0, 0")}, start: foot, end: corner}}
  - {{name: near, points: [[0, 120, 0], [24, 120, 0]], segments: 4, {BAR.replace("UP", "0, 1, 0")}, start: corner, end: hand}}
  - {{name: far, points: [[24, 120, 0], [120, 120, 0]], segments: 16, {BAR.replace("UP", "0, 1, 0")}, start: hand, end: wall}}
rigid_bodies:
  - {{name: foot, center: [0, 0, 0]}}
  - {{name: corner, center: [0, 120, 0]}}
  - {{name: hand, center: [24, 120, 0]}}
  - {{name: wall, center: [120, 120, 0]}}
joints:
  - {{name: base, type: hinge, between: [ground, foot], point: [0, 0, 0], axis: [0, 0, 1]}}
  - {{name: support, type: hinge, between: [ground, wall], point: [120, 120, 0], axis: [0, 0, 1]}}
loads: [{{force: [0, -1, 0], volume: hand}}]
"""
# The equations of its rods, integrated by a method of order 8 with continuation; published with few elements: 1.85 and -0.94.
FRAME_MAXIMUM, FRAME_MINIMUM = 1.855478, -0.941451
MODULUS, INNER, OUTER = 3e5, 8e-3, 10e-3
BALL = f"""
mesh: {{file: {ROOT}/meshes/hollow_sphere.geo, scale: 1e-3, size: 2.5 mm}}
element: P2
volumetric: mixed
bodies: [{{elasticity: {{model: neo-hookean-isochoric, shear_modulus: {MODULUS}, bulk_modulus: 1e9}}}}]
constraints:
  - {{surface: yz, symmetry: plane}}
  - {{surface: xz, symmetry: plane}}
  - {{surface: xy, symmetry: plane}}
cavities: [{{name: hollow, surface: inner, pressure: 100 kPa}}]
probes: [{{name: inside, point: [8 mm, 0, 0]}}]
"""
# A quarter of a square film that its sides hold. Flat, it resists pressure by bending alone, a thousand times less than later.
FILM = """
mesh: {file: film.msh}
shells:
  - name: film
    surface: sheet
    free: true
    bending: true
    thickness: 1 mm
    clamped: [{curve: s0, normal: [1, 0, 0]}, {curve: t0, normal: [0, 1, 0]}]
    elasticity: {model: neo-hookean, shear_modulus: 100 kPa, poissons_ratio: 0.4999}
constraints:
  - {curve: s0, displacement: [0, free, free]}
  - {curve: t0, displacement: [free, 0, free]}
  - {curve: s1, displacement: [0, 0, 0]}
  - {curve: t1, displacement: [0, 0, 0]}
loads: [{surface: sheet, pressure: -1 kPa}]
probes: [{name: pole, point: [0, 0, 0]}]
"""


def path(load_steps=10, **keys):
    return f"time: {{method: static, load_steps: {load_steps}, path: {json.dumps(keys)}}}\noutput: {{every: 100}}\n"


def truss_force(height):
    """Over that of the load factor 1, where the apex is at this height."""
    length = np.hypot(1, height)
    return 2 * STIFFNESS * (np.hypot(1, RISE) - length) / length * height / 10


def ball_pressure(radius):
    """Of an incompressible neo-Hookean ball whose inner wall is at this radius."""
    outside = np.cbrt(OUTER**3 + radius**3 - INNER**3)

    def part(stretch):
        return 2 / stretch + 1 / (2 * stretch**4)

    return MODULUS * (part(outside / OUTER) - part(radius / INNER))


def texts(svg):
    """What a plot of matplotlib says: its texts stand in comments next to their outlines."""
    return re.findall(r"<!-- (.*?) -->", svg.read_text(encoding="utf-8"))


class Paths(ProgramTest):
    def follow(self, text, *settings, output="out", **more):
        """The history, and the critical points that the summary names."""
        h = self.run_input(self.write("in.yaml", text), *settings, output=output, **more)
        return h, json.loads((self.directory / output / "summary.json").read_text()).get("critical_points", [])

    def test_a_truss_snaps_through(self):
        h, points = self.follow(TRUSS + PUSHED + path(20, max_load=5))
        np.testing.assert_allclose(h["load_factor"], truss_force(h["apex_z"]), atol=5e-8)
        limit = truss_force(np.linspace(0, RISE, 100001)).max()
        self.assertEqual([p["kind"] for p in points], ["maximum", "minimum"])
        np.testing.assert_allclose([p["load_factor"] for p in points], [limit, -limit], rtol=1e-4)  # cubic between two steps
        # The tangent stiffness is negative between the limits.
        slope = truss_force(h["apex_z"] + 1e-6) - truss_force(h["apex_z"] - 1e-6)
        np.testing.assert_array_equal(h["unstable_modes"][1:], (slope > 0)[1:])
        self.assertEqual(h["load_factor"][-1], 5)
        self.assertTrue((np.diff(h["apex_z"]) < 0).all(), "it has turned back")
        self.assertTrue((np.diff(h["time"]) > 0).all())

    # With a soft spring between hand and apex, the hand's own way has limit points too (snap-back).
    def test_a_prescribed_motion_is_followed_back(self):
        soft = 40.0
        text = TRUSS + """  - {name: pusher, points: [{body: hand, point: [0, 0, 1]}, {body: apex, point: [0, 0, 0.3]}], stiffness: 40}
"""
        text = text.replace("]}]\njoints: [", "]}, {name: hand, mass: 1, inertia: [1, 1, 1], center: [0, 0, 1]}]\njoints: [{name: stroke, "
                            "type: slider, between: [ground, hand], point: [0, 0, 1], axis: [0, 0, 1], motion: -0.6}, ")
        h, points = self.follow(text + path(20, max_load=2))
        way = RISE - h["apex_z"] + 10 * truss_force(h["apex_z"]) / soft
        np.testing.assert_allclose(0.6 * h["load_factor"], way, atol=1e-6)
        self.assertEqual([p["kind"] for p in points], ["maximum", "minimum"])
        self.assertLess(np.diff(h["load_factor"]).min(), 0)

    def test_lees_frame(self):
        h, points = self.follow(FRAME + path(10, max_load=2, min_load=-2))
        self.assertEqual([p["kind"] for p in points], ["maximum", "minimum"])
        for point, exact, of_the_segments in zip(points, (FRAME_MAXIMUM, FRAME_MINIMUM), (0.006, 0.026)):
            self.assertLess(abs(point["load_factor"] / exact - 1), of_the_segments)
        self.assertEqual(h["unstable_modes"].max(initial=0, where=np.isfinite(h["unstable_modes"])), 1)
        self.assertLess(len(h["step"]), 90)
        if not LONG:
            return
        errors = [np.abs([p["load_factor"] - e for p, e in zip(points, (FRAME_MAXIMUM, FRAME_MINIMUM))])]
        for more in (2, 4):
            text = FRAME
            for n in (20, 16, 4):
                text = text.replace(f"segments: {n},", f"segments: {n * more},")
            _, points = self.follow(text + path(10, max_load=2, min_load=-2, max_step=0.5))
            errors.append(np.abs([p["load_factor"] - e for p, e in zip(points, (FRAME_MAXIMUM, FRAME_MINIMUM))]))
            self.assertTrue((errors[-1] < errors[-2] / 3.2).all(), errors)

    # Against the volume of the hollow, so that nodes off the sphere do not matter; and on two ranks and three.
    def test_a_rubber_ball_beyond_its_greatest_pressure(self):
        text = BALL + path(5, max_load=5, stop=[{"column": "inside_ux", "above": 8e-3}])
        h, points = self.follow(text)
        radius = np.cbrt(6 / np.pi * h["hollow_volume"])
        np.testing.assert_allclose(h["hollow_pressure"][1:], ball_pressure(radius[1:]), rtol=1.2e-3)  # 210 tetrahedra
        limit = ball_pressure(INNER * np.linspace(1, 3, 100001)).max() / 1e5
        self.assertEqual([p["kind"] for p in points], ["maximum"])
        self.assertAlmostEqual(points[0]["load_factor"] / limit, 1, delta=3e-4)
        self.assertLess(h["load_factor"][-1], 0.9 * limit)
        self.assertGreater(h["inside_ux"][-1], 8e-3)
        self.assertEqual(list(np.unique(h["unstable_modes"][1:])), [0, 1])
        for ranks in (2, 3) if LONG else (2,):
            self.assert_same_history(h, self.follow(text, ranks=ranks)[0], 1e-9)

    def test_a_flat_film_that_stiffens(self):
        """The path passes the limit although its loads move a thousand times less there than at the start."""
        write_patch(self.directory / "film.msh", 4, lambda s, t: (0.05 * s, 0.05 * t, 0), alternate=True)
        greatest = []
        for prestretch in ((), ("shells.0.prestretch=1.01",)):
            h, points = self.follow(FILM + path(max_load=8, stop=[{"column": "pole_uz", "above": 0.1}]), *prestretch)
            greatest += [point["load_factor"] for point in points if point["kind"] == "maximum"]
            self.assertGreater(h["pole_uz"][-1], 0.1)
            self.assertLess(h["load_factor"][-1], 0.95 * h["load_factor"].max())
        self.assertEqual(len(greatest), 2)
        self.assertAlmostEqual(greatest[0], greatest[1], delta=0.05 * greatest[0])

    def test_a_resumed_path_continues_to_the_last_bit(self):
        coarse = FRAME.replace("segments: 20", "segments: 10").replace("segments: 16", "segments: 8").replace("segments: 4", "segments: 2")
        whole = self.follow(TRUSS + PUSHED + path(20, max_load=5) + "checkpoint: {every: 3}\n", output="truss")[0]
        self.follow(TRUSS + PUSHED + path(20, max_load=5) + "checkpoint: {every: 3}\n", "time.path.max_steps=3", output="truss_part")
        self.pliant("resume", "truss_part", "--set", "time.path.max_steps=500")
        np.testing.assert_array_equal(whole["apex_z"], read_history(self.directory / "truss_part")["apex_z"])
        text = coarse + path(5, max_load=2, min_load=-2) + "checkpoint: {every: 4}\n"
        whole, passed = self.follow(text)
        self.follow(text, "time.path.max_steps=8", output="part")
        done = self.pliant("resume", "part", "--set", "time.path.max_steps=500")
        self.assertIn("the path ends: the load factor is 2", done.stdout)
        part = read_history(self.directory / "part")
        for name in whole:
            np.testing.assert_array_equal(whole[name], part[name], err_msg=name)
        self.assertGreater(len(passed), 1)
        self.assertEqual(json.loads((self.directory / "part/summary.json").read_text())["critical_points"], passed)
        self.assertIn("nothing is left to do", self.pliant("resume", "part").stderr)
        self.pliant("resume", "part", "--set", "time.path.max_load=2.1", "--set", "checkpoint.every=1")
        self.assertEqual(read_history(self.directory / "part")["load_factor"][-1], 2.1)

    def test_a_start_that_is_no_equilibrium(self):
        # A body that a spring carries off before there are loads: from 0.3 m, the loads push it back by 0.1 m.
        body = '''
rigid_bodies: [{name: car, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0]}]
joints: [{name: rail, type: slider, between: [ground, car], point: [0, 0, 0], axis: [0, 1, 0], spring: {stiffness: 100, rest: 0.3}}]
loads: [{force: [0, -10, 0], volume: car}]
'''
        h, passed = self.follow(body + path(max_load=1, max_steps=20))
        np.testing.assert_allclose(h["rail_travel"][1:], 0.3 - 0.1 * h["load_factor"][1:], rtol=1e-7)
        self.assertGreater(np.diff(h["load_factor"]).min(), 0)
        self.assertEqual((h["load_factor"][-1], len(passed)), (1.0, 0))

    # What a load factor scales is the same on a path as in load steps: where both lead to one equilibrium, it is the same.
    def test_a_path_ends_where_load_steps_do(self):
        write_box(self.directory / "box.msh", (3, 2, 2), (0.3, 0.2, 0.2))
        solid = """
mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 0.1 MPa, poissons_ratio: 0.3}}]
probes: [{name: p, point: [0.3, 0.2, 0.2]}]
"""
        clamp = "  - {surface: left, displacement: [0, 0, 0]}\n"
        held = "constraints:\n" + clamp
        cases = {
            "gravity, a traction and a pressure without a potential":
                held + "loads: [{gravity: [0, 0, -9.81]}, {surface: right, traction: [500, 0, 0]}, {surface: top, pressure: 300}]\n",
            "a prescribed displacement and a rigid part that rotates freely":
                held + "  - {surface: right, rigid: {translation: [20 mm, 0, free]}}\nloads: [{gravity: [0, 5, -9.81]}]\n",
            "an equation, an oblique support, quadratic elements":
                held + "  - {surface: right, displacement_along: 10 mm, direction: [1, 0, 1]}\nelement: P2\n"
                "loads: [{gravity: [0, 0, -9.81]}]\n",
            "an expansion, a nearly incompressible body, an oblique support":
                held.replace("constraints", "volumetric: mixed\nconstraints") +
                "  - {surface: right, displacement_along: 10 mm, direction: [1, 0, 1]}\nloads: [{gravity: [0, 0, -9.81]}]\n",
            "a rigid body tied to a surface, a tendon and a spring":
                held + "rigid_bodies: [{name: lid, mass: 1, inertia: [1, 1, 1], center: [0.3, 0.1, 0.1], attached: [right]}]\n"
                "springs: [{name: s, points: [{body: ground, point: [0.5, 0, 0]}, {body: lid, point: [0.3, 0, 0]}], stiffness: 100}]\n"
                "loads: [{force: [0, 0, -3], volume: lid}, {torque: [0.2, 0, 0], volume: lid}]\n",
        }
        for name, keys in cases.items():
            with self.subTest(name):
                text = solid + keys
                if name.startswith("an expansion"):
                    text = text.replace("poissons_ratio: 0.3}", "poissons_ratio: 0.4999}, expansion: {stretch: 1.05}")
                steps = self.run_input(self.write("in.yaml", text + "time: {method: static, load_steps: 4}\n"))
                along, _ = self.follow(text + path(4, max_load=1))
                self.assertEqual(along["load_factor"][-1], 1)
                for axis in "xyz":
                    end = [h[f"p_u{axis}"][-1] for h in (steps, along)]
                    self.assertAlmostEqual(*end, delta=1e-6 * 0.3, msg=axis)

    def test_plots_show_the_load_over_what_it_moves(self):
        self.follow(TRUSS + PUSHED + path(20, max_load=2))
        self.pliant("plot", "out", "--output", "path.svg")  # the apex is not a probe: no such panel, but a length of the path
        self.assertIn("length of the path", texts(self.directory / "path.svg"))
        write_box(self.directory / "box.msh", (2, 1, 1))
        self.follow("""mesh: {file: box.msh}
bodies: [{elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{surface: right, traction: [0, 0, -1e4]}]
probes: [{name: tip, point: [1, 1, 1]}]
""" + path(4, max_load=1))
        self.pliant("plot", "out", "--output", "path.svg")
        shown = texts(self.directory / "path.svg")
        self.assertIn("-uz of tip [mm]", shown)
        self.assertIn("load factor", shown)
        if not (LONG and CHROMIUM):
            return
        self.pliant("report", "out")
        with Browser() as browser:
            browser.open(self.directory / "out/report.html")
            self.assertEqual(browser.evaluate("document.querySelectorAll('#plots svg.path').length"), 1)
            self.assertIn("path", browser.evaluate("document.getElementById('time').textContent"))

    def test_errors(self):
        def refused(text, *settings, command="run"):
            arguments = [a for s in settings for a in ("--set", s)]
            done = self.pliant(command, self.write("in.yaml", text), *arguments, status=2)
            return done.stderr

        text = TRUSS + PUSHED + path(20, max_load=2)
        self.assertIn("'path' follows equilibria and needs 'method: static'",
                      refused(text, "time.method=bdf2", "time.step=0.1", "time.end=1"))
        self.assertIn("which multigrid cannot solve", refused(text, "solver.linear=amg"))
        self.assertIn("cannot include contact",
                      refused(text, "contact={obstacles: [{name: floor, shape: plane, point: [0, 0, -1], normal: [0, 0, 1]}]}"))
        self.assertIn("is smaller than the first step", refused(text, "time.path.max_step=0.01"))
        self.assertIn("no column 'apex_w' (did you mean 'apex_", refused(text, "time.path.stop=[{column: apex_w, above: 1}]"))
        self.assertIn("at least one of above, below is needed", refused(text, "time.path.stop=[{column: apex_z}]"))
        self.assertIn("nothing to compare", self.pliant("converge", "in.yaml", "--in", "space", "--levels", "2", status=2).stderr)
        done = self.pliant("sensitivity", "in.yaml", "--of", "apex_z", "--to", "springs.0.stiffness", status=2)
        self.assertIn("derivatives along a path", done.stderr)
        unloaded = self.pliant("run", self.write("in.yaml", TRUSS + path(20, max_load=2)), status=3)
        self.assertIn("the load factor moves nothing that is free", unloaded.stderr)


if __name__ == "__main__":
    unittest.main()
