#!/usr/bin/python3
"""Results that hold at the default tolerance, and runs that arrive wherever there is a solution."""
import json
import unittest

import numpy as np

from program import ROOT, ProgramTest, swept, write_box

CUBE = f"mesh: {{file: {ROOT}/meshes/unit_cube.msh, scale: 0.1, refine: 1}}\n"
METHODS = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk33", "implicit-midpoint", "dirk23", "symplectic-dirk22")
STIFFLY_ACCURATE = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk33")


def body(modulus, ratio=0.3, model="neo-hookean"):
    return f"bodies: [{{density: 1000, elasticity: {{model: {model}, youngs_modulus: {modulus}, poissons_ratio: {ratio}}}}}]\n"


class Robustness(ProgramTest):
    def run_text(self, text, *settings, **more):
        return self.run_input(self.write("case.yaml", text), *settings, **more)

    def summary(self, output="out"):
        return json.loads((self.directory / output / "summary.json").read_text())

    def assert_no_step_failed(self):
        self.assertEqual(self.summary()["steps"]["failed"], 0)


class Tolerance(Robustness):
    """Convergence is judged by the forces that balance, not by those of a guess."""

    def test_barrier_does_not_set_the_scale(self):
        text = CUBE + body("1e6") + """initial: {displacement: [0, 0, 0.05], velocity: [0, 0, -1]}
contact: {law: barrier, obstacles: [{name: o, shape: plane, normal: [0, 0, 1]}]}
time: {method: bdf2, step: 5 ms, end: 80 ms}
"""
        for method in swept(STIFFLY_ACCURATE, ("bdf2", "dirk33")):
            with self.subTest(method):
                h = self.run_text(text, f"time.method={method}")
                np.testing.assert_allclose(h["o_jz"][-1], h["pz"][-1] - h["pz"][0], rtol=1e-6)
                self.assertLess(self.summary()["solver"]["worst_rounding"], 1e-6)

    def test_stiff_block_spins_rigidly(self):
        """Without a failed step, with what the tolerance leaves far below the motion."""
        text = CUBE + body("1e11", 0.49) + """initial: {velocity: ["-6.3*(y - 0.05)", "6.3*(x - 0.05)", 0]}
time: {step: 25 ms, end: 0.25}
probes: [{name: p, point: [0.1, 0.1, 0.1]}]
"""
        for method in swept(STIFFLY_ACCURATE, ("bdf2", "dirk22")):
            with self.subTest(method):
                h = self.run_text(text, f"time.method={method}")
                self.assert_no_step_failed()
                exact = self.run_text(text, f"time.method={method}", "solver.newton.relative=1e-13")
                for column in ("p_x", "p_y", "p_z"):
                    self.assertLess(np.abs(h[column] - exact[column]).max(), 1e-5)
                # No two corners of a stiff body come closer: it has turned, and nothing else.
                self.assertLess(np.abs(h["Lz"] - exact["Lz"]).max(), 1e-4 * np.abs(exact["Lz"]).max())
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-4 * h["kinetic_energy"][0])

    def test_default_tolerance_is_good_to_four_digits(self):
        """Of what moves, against solves to the last digit."""
        write_box(self.directory / "bar.msh", (6, 2, 2), (1, 0.2, 0.2))
        clamped = "mesh: {file: bar.msh}\nconstraints: [{surface: left, displacement: [0, 0, 0]}]\n"
        probe = "probes: [{name: p, point: [1, 0.2, 0.2]}]\n"
        cases = {
            "swinging beam": clamped + body("1e6") + "loads: [{gravity: [0, 0, -9.81]}]\n",
            "stiff beam": clamped + body("1e9") + "loads: [{gravity: [0, 0, -9.81]}]\n",
            "tumbling block": "mesh: {file: bar.msh}\n" + body("1e7") + 'initial: {velocity: ["z", "3*z", "-3*y"]}\n',
            "follower pressure": clamped + body("1e6") + "loads: [{surface: top, pressure: 100}]\n",
        }
        for name, text in cases.items():
            for method in swept(("backward-euler", "bdf2", "dirk33"), ("bdf2",)):
                with self.subTest(name, method=method):
                    text_of_method = text + probe + f"time: {{method: {method}, step: 10 ms, end: 100 ms}}\n"
                    h = self.run_text(text_of_method)
                    exact = self.run_text(text_of_method, "solver.newton.relative=1e-13")
                    way = max(np.abs(exact[f"p_{x}"] - exact[f"p_{x}"][0]).max() for x in "xyz")
                    for x in "xyz":
                        self.assertLess(np.abs(h[f"p_{x}"] - exact[f"p_{x}"]).max(), 1e-4 * way)


class Arrival(Robustness):
    def test_static_analysis_under_a_formula_of_time(self):
        constraints = ('{where: "x > 0.999", displacement: ["1.5*t", 0, 0]}',
                       '{where: "x > 0.999", normal_displacement: "1.5*t"}',
                       '{where: "x > 0.999", displacement_along: "1.5*t", direction: [2, 1, 0]}',
                       '{where: "x > 0.999", rigid: {translation: ["1.5*t", 0, 0], rotation: fixed}}')
        for constraint in swept(constraints, constraints[::2]):
            with self.subTest(constraint):
                self.run_text(f"mesh: {{file: {ROOT}/meshes/unit_cube.msh, refine: 1}}\n" + body("1e5") + f"""constraints:
  - {{where: "x < 1e-6", displacement: [0, 0, 0]}}
  - {constraint}
time: {{method: static, end: 1, load_steps: 10}}
""")
                self.assert_no_step_failed()

    def test_stage_that_starts_inside_out(self):
        """A method may extrapolate the start of a stage to where the energy is infinite."""
        text = CUBE + body("1e4") + """initial: {displacement: [0, 0, 1e-3], velocity: [0, 0, -10]}
contact: {obstacles: [{name: o, shape: plane, normal: [0, 0, 1]}]}
time: {step: 2 ms, end: 16 ms}
"""
        for method in swept(("bdf2", "dirk22", "dirk33"), ("bdf2", "dirk33")):
            with self.subTest(method):
                self.run_text(text, f"time.method={method}")
                self.assert_no_step_failed()

    def test_end_of_a_step_is_never_inside_out(self):
        """Of methods whose steps end at none of their stages."""
        text = CUBE + body("1e3", 0.45) + """initial: {velocity: ["-50*(y - 0.05)", "50*(x - 0.05)", 0]}
time: {step: 25 ms, end: 0.1}
"""
        for method in sorted(set(METHODS) - set(STIFFLY_ACCURATE)):
            with self.subTest(method):
                case = self.write("case.yaml", text)
                done = self.call("run", case, "--output", "out", "--set", f"time.method={method}")
                self.assertIn(done.returncode, (0, 3), done.stderr)
                history = (self.directory / "out/history.csv").read_text()
                self.assertNotIn("inf", history.splitlines()[-1])
                self.assertNotIn("nan", history.splitlines()[-1])
                self.assertGreater(self.summary()["steps"]["failed"], 0)
                self.assertIn("inside out at the end of the step", done.stdout + done.stderr)

    def test_sliding_under_follower_pressure(self):
        """A block lands askew on a plane with friction, under a pressure that no potential has: Newton's method does not
        go to and fro where friction changes its sign."""
        text = CUBE + body("1e7", 0.45) + """loads: [{where: "z > 0.0999", pressure: "2e5*sin(300*t)"}]
contact: {law: penalty, obstacles: [{name: o, shape: plane, normal: [0, 0, 1], friction: 1, normal_damping: 0.2}]}
initial: {velocity: ["2 - 20*(y - 0.05)", "20*(x - 0.05)", -1]}
time: {step: 3 ms, end: 30 ms}
"""
        methods = ("backward-euler", "bdf2", "dirk22", "dirk33", "implicit-midpoint")
        cases = [(method, update) for method in methods for update in ("frozen", "iterated")]
        for method, update in swept(cases, (("bdf2", "frozen"), ("dirk33", "iterated"))):
            with self.subTest(method, update=update):
                self.run_text(text, f"time.method={method}", f"contact.friction_update={update}")
                self.assert_no_step_failed()

    def test_thin_beam_under_follower_pressure(self):
        """Clamped, 200 times as long as thick, rolled up by a pressure that stays normal to it: in a few iterations."""
        length, width, thickness, modulus, pressure = 1.0, 0.05, 0.005, 1e6, 0.8
        write_box(self.directory / "beam.msh", (40, 1, 1), (length, width, thickness))
        text = "mesh: {file: beam.msh}\nelement: P2\n" + body(modulus, 0) + f"""constraints: [{{where: "x < 1e-9", displacement: [0, 0, 0]}}]
loads: [{{where: "z < 1e-9", pressure: {pressure}}}]
time: {{method: static, load_steps: 20}}
probes: [{{name: tip, point: [{length}, {width / 2}, {thickness / 2}]}}]
"""
        h = self.run_text(text)
        self.assert_no_step_failed()
        self.assertLess(h["newton_iterations"][1:].max(), 12)
        x, z = tip_of_elastica(length, pressure / (modulus * thickness**3 / 12))
        np.testing.assert_allclose([h["tip_x"][-1], h["tip_z"][-1] - thickness / 2], [x, z], atol=0.01 * length)

        text = text.replace("density: 1000", "density: 0.01").replace(f"pressure: {pressure}", f'pressure: "{pressure}*t"')
        h = self.run_text(text.replace("static, load_steps: 20", "bdf2, step: 0.05, end: 1"))
        self.assert_no_step_failed()
        self.assertLess(h["newton_iterations"].sum(), 20 * 10)

    def test_block_that_snaps_arrives(self):
        """Bonded ends of a nearly incompressible block are pulled apart or pressed together: there are bifurcations on
        the way, and the equilibrium that is left ends in a fold. The body goes down to another, far away."""
        laws = {"neo": "neo-hookean-isochoric, shear_modulus: 4e5", "mooney": "mooney-rivlin, c10: 1.5e5, c01: 0.5e5"}
        cases = (("P1", "standard", "mooney", 7, 3), ("P2", "mixed", "neo", 0.4, 2), ("P2", "mean-dilatation", "neo", 0.3, 2))
        for element, treatment, law, stretch, n in swept(cases, cases[1:2]):
            with self.subTest(treatment):
                self.write("block.geo", f"""Point(1) = {{0, 0, 0}};
line[] = Extrude {{0, 1, 0}} {{ Point{{1}}; Layers{{{n}}}; }};
face[] = Extrude {{0, 0, 1}} {{ Curve{{line[1]}}; Layers{{{n}}}; }};
block[] = Extrude {{2, 0, 0}} {{ Surface{{face[1]}}; Layers{{{2 * n}}}; }};
Physical Volume("block") = {{block[1]}};
""")
                text = f"""mesh: {{file: block.geo}}
element: {element}
volumetric: {treatment}
bodies: [{{density: 1000, elasticity: {{model: {laws[law]}, bulk_modulus: 2e9}}}}]
constraints:
  - {{where: "x < 1e-6", displacement: [0, 0, 0]}}
  - {{where: "x > 1.999999", displacement: ["{2 * (stretch - 1)}*t", 0, 0]}}
time: {{method: quasistatic, step: 0.05, end: 1}}
"""
                h = self.run_text(text)
                self.assertEqual(h["time"][-1], 1.0)
                self.assertLess(abs(h["energy_balance_error"][-1]), 1e-3 * h["elastic_energy"][-1])

    def test_a_load_beyond_a_limit_point_is_told(self):
        # Suction on all sides of a cube, which no compressible neo-Hookean cube bears without end.
        near = ["[[-1, -1, -1], [1e-6, 2, 2]]", "[[-1, -1, -1], [2, 1e-6, 2]]", "[[-1, -1, -1], [2, 2, 1e-6]]"]
        far = ["[[0.0999, -1, -1], [2, 2, 2]]", "[[-1, 0.0999, -1], [2, 2, 2]]", "[[-1, -1, 0.0999], [2, 2, 2]]"]
        text = f"""{CUBE}bodies: [{{elasticity: {{model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}}}]
constraints: [{", ".join("{box: " + box + ", symmetry: plane}" for box in near)}]
loads: [{", ".join("{box: " + box + ", pressure: -2 MPa}" for box in far)}]
time: {{method: static, load_steps: 8}}
"""
        done = self.pliant("run", self.write("suction.yaml", text), "--quiet", status=3)
        self.assertRegex(done.stderr, "displacements grow [0-9]+ times as fast as on average, so that there may be no equilibrium")


def tip_of_elastica(length, load, n=4000):
    """Of an inextensible beam under a follower load per length, over its bending stiffness [1/m^3].

    The axial force is -EI k^2 / 2 and k'' = load - k^3 / 2 for the curvature k, which vanishes with k' at the tip.
    """
    def rate(y):
        return np.array([y[1], load - y[0]**3 / 2])

    h = -length / n
    y, k = np.zeros(2), [0.0]
    for _ in range(n):
        k1 = rate(y)
        k2 = rate(y + h / 2 * k1)
        k3 = rate(y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + h * k3))
        k.append(y[0])
    k = np.array(k[::-1])
    angle = np.concatenate([[0.0], np.cumsum((k[1:] + k[:-1]) / 2)]) * length / n
    return np.trapz(np.cos(angle), dx=length / n), np.trapz(np.sin(angle), dx=length / n)


if __name__ == "__main__":
    unittest.main()
