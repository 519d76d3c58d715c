#!/usr/bin/python3
"""Motion that is given in advance, as users type it: starts, kinks and jumps of it, on any number of ranks."""
import unittest

import numpy as np

from program import LONG, ProgramTest, box, swept, write_box, write_mesh

METHODS = ["backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33", "implicit-midpoint", "symplectic-dirk22"]
ADAPTIVE = [m for m in METHODS if m not in ("implicit-midpoint", "symplectic-dirk22")]


class Motion(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "cube.msh", (2, 2, 2))

    def input(self, constraints, time, more=""):
        lines = "".join(f"  - {c}\n" for c in constraints)
        self.write("in.yaml", "mesh: {file: cube.msh}\n"
                   "bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}]\n"
                   f"constraints:\n{lines}time: {{{time}}}\n"
                   "probes: [{name: lid, point: [0.5, 0.5, 1]}, {name: side, point: [1, 0.5, 0.5]}]\n" + more)

    def solve(self, constraints, time, ranks=1, more=""):
        self.input(constraints, time, more)
        return self.run_input("in.yaml", ranks=ranks)

    def test_a_start_is_the_same_on_any_ranks(self):
        held = "{surface: left, displacement: [0, 0, 0]}"
        cases = {
            "equation": [held, '{equation: [{surface: right, component: z}], value: "0.05*t"}'],
            "curved equation": [held, '{equation: [{surface: right, component: z}], value: "0.002*sin(40*t)"}'],
            "oblique": ['{surface: right, displacement_along: "0.1*t", direction: [1, 1, 0]}'],
            "periodic": ['{surface: right, periodic_with: left, difference: ["0.2*t", 0, free]}'],
            "rigid": [held, '{surface: right, rigid: {translation: ["0.1*t", free, 0], rotation: free}}'],
            "displaced": [held, '{equation: [{surface: right, component: x}], value: "0.05 + t"}'],
        }
        for name, constraints in swept(list(cases.items()), list(cases.items())[1::2]):
            with self.subTest(name):
                one, *others = [self.solve(constraints, "method: bdf2, step: 5 ms, end: 20 ms", ranks,
                                           "initial: {velocity: [0.01, 0.02, 0.03]}\n") for ranks in swept((1, 3, 2), (1, 3))]
                self.assertGreater(one["kinetic_energy"][0], 0.1)
                for other in others:
                    self.assert_same_history(other, one, 1e-7)
                scale = one["kinetic_energy"].max() + one["elastic_energy"].max()
                self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-6 * scale)

    def test_an_oblique_start_is_straight(self):
        history = self.solve(['{surface: right, displacement_along: "0.1*t", direction: [1, 1, 0]}'],
                             "method: bdf2, step: 1 ms, end: 5 ms")
        velocity = [history[f"side_v{i}"][0] for i in "xyz"]
        np.testing.assert_allclose(velocity, [0.1 / np.sqrt(2), 0.1 / np.sqrt(2), 0], atol=1e-12)

    def test_velocities_after_a_kink(self):
        # The lid rises at 1 m/s until 0.0105 s, and rests from then on; the time is between two nominal ones.
        lid = '{surface: top, displacement: [0, 0, "0.0105*min(t/0.0105, 1)"]}'
        for method in swept(METHODS, METHODS[::2]):
            with self.subTest(method):
                h = self.solve(["{surface: bottom, displacement: [0, 0, 0]}", lid], f"method: {method}, step: 2 ms, end: 20 ms")
                self.assertEqual(np.count_nonzero(np.abs(h["time"] - 0.0105) < 1e-12), 1)
                rises = h["time"] < 0.0106
                np.testing.assert_allclose(h["lid_vz"][rises], 1, rtol=1e-13)
                np.testing.assert_array_equal(h["lid_vz"][~rises], 0)
                np.testing.assert_allclose(h["lid_z"][~rises] - 1, 0.0105, rtol=1e-12)
                # The impulse at the kink is booked as work of the support.
                scale = h["kinetic_energy"].max() + h["elastic_energy"].max()
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * scale)

    def test_kinks_are_events(self):
        self.input(['{surface: bottom, displacement: [0, 0, "0.001*max(0, sin(500*t))"]}'],
                   "method: bdf2, step: 1 ms, end: 20 ms",
                   'loads: [{surface: top, traction: [0, 0, "t < 0.0033 ? 100 : 0"]}]\n')
        done = self.call("run", "in.yaml", "--output", "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout + done.stderr, r"note: .*steps end there, as at 'time.events': t = 0.0033, 0.00628319, ")
        self.input(['{surface: bottom, displacement: [0, 0, "0.001*abs(sin(1e5*t))"]}'], "method: bdf2, step: 1 ms, end: 20 ms")
        done = self.call("check", "in.yaml")
        self.assertRegex(done.stdout + done.stderr, "too many for steps to end at all of them")

    def test_kinks_that_move_are_warned_of(self):
        lid = '{surface: top, displacement: [0, 0, "%s"]}'
        time = "method: bdf2, step: 1 ms, end: 20 ms"
        for formula, words in (("0.1*min(t, 0.01*(1 + x))", r"in.yaml:5:5: the motion prescribed by '0.1\*min\(t, 0.01\*\(1 \+ x\)\)' has kinks .*such as "
                                r"t = 0.01 s at \(0, 0, 0\) and t = 0.015 s at \(0.5, 1, 1\): .*time.events"),
                               ("0.1*max(0, t - 0.01*x)^5", None), ("0.1*x*min(t, 0.01)", None), ("x > 0.5 ? t : 0", None)):
            with self.subTest(formula):
                texts = set()
                for ranks in swept((1, 2), (1, 2) if words else (1,)):
                    self.input(["{surface: bottom, displacement: [0, 0, 0]}", lid % formula], time)
                    done = self.call("check", "in.yaml", ranks=ranks)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    texts.add("".join(line for line in done.stderr.splitlines() if "kinks or jumps whose" in line))
                self.assertEqual(len(texts), 1)
                self.assertRegex(texts.pop(), words or "^$")

    def test_a_jump_follows_the_step_that_ends_there(self):
        # Both ends of the bar carry the same force in every row, and the energy is that of the work: the row of the event
        # is the equilibrium before the jump.
        held = "{surface: left, displacement: [0, 0, 0]}"
        jumps = {"displacement": "{surface: right, displacement: ['t < 0.05 ? 0 : 0.1', free, free]}",
                 "tie": "{equation: [{surface: right, component: x}], value: 't < 0.05 ? 0 : 0.1'}",
                 "rigid": "{surface: right, rigid: {translation: ['t < 0.05 ? 0 : 0.1', free, free], rotation: fixed}}",
                 "free turn": "{surface: right, rigid: {translation: ['t < 0.05 ? 0 : 0.1', 0, 0], rotation: free}}",
                 "turn": "{surface: right, rigid: {translation: [0, 0, 0], rotation: {axis: [1, 0, 0], angle: 't < 0.05 ? 0 : 0.2'}}}"}
        for name, jump in swept(list(jumps.items()), list(jumps.items())[1:4:2]):
            with self.subTest(name):
                h = self.solve([held, jump], "method: quasistatic, step: 20 ms, end: 0.1")
                self.assertEqual(np.abs(h["elastic_energy"][h["time"] < 0.051]).max(), 0)
                self.assertGreater(h["elastic_energy"][-1], 10)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * h["elastic_energy"][-1])

    def test_a_short_pulse_is_an_event(self):
        # Of two thousandths of a step, and yet all of its impulse is there.
        self.input(["{surface: bottom, displacement: [free, free, 0]}"], "method: backward-euler, step: 1 ms, end: 20 ms",
                   'loads: [{surface: top, traction: ["1e6*max(0, 1 - abs((t - 0.0052)/1e-6))", 0, 0]}]\n')
        h = self.run_input("in.yaml")
        self.assertAlmostEqual(h["px"][-1], 1, delta=1e-6)

    def test_adaptive_steps_go_on_where_a_velocity_jumps(self):
        constraints = ["{surface: left, displacement: [0, 0, 0]}",
                       '{surface: right, displacement: ["0.01*min(t/0.1, 1)", 0, 0]}']
        for method in swept(ADAPTIVE, ADAPTIVE[1::2]):
            for events in ("", ", events: [0.1]"):
                with self.subTest(method=method, events=events):
                    h = self.solve(constraints, f"method: {method}, end: 0.13{events}, adaptive: {{relative: 0.01}}")
                    self.assertIn(0.1, h["time"])
                    self.assertEqual(h["side_vx"][-1], 0)
                    self.assertAlmostEqual(h["side_x"][-1], 1.01, delta=1e-14)
                    scale = h["kinetic_energy"].max() + h["elastic_energy"].max()
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * scale)

    def test_an_impulse_is_that_of_free_bodies(self):
        # From rest: v = z, the nearest to 0 with z = 1 on the side, and T = z M z / 2. Stopped in flight: v = 1 - z. As
        # M z is nothing but impulses on the side, 1 M z = z M z, and the two energies sum up to that of the flight.
        time = "method: implicit-midpoint, step: 1 ms, end: 2 ms"
        start = self.solve(['{surface: left, displacement: ["t", free, free]}'], time)["kinetic_energy"][0]
        flying = self.solve(['{surface: left, displacement: [0, free, free]}'], time, more="initial: {velocity: [1, 0, 0]}\n")
        self.assertAlmostEqual(flying["kinetic_energy"][0], 500 - start, delta=1e-9 * 500)


class Passage(ProgramTest):
    """Bodies that come to pass through one another, between which there is no contact."""

    PASSING = """mesh: {file: two.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}]
initial: {velocity: ["%s*(x > 1.3)", 0, 0]}
time: {method: bdf2, step: 10 ms, end: 0.2}
output: {every: 0.2}
"""

    def warnings(self, velocity, ranks, more=""):
        points, triangles, cells = box((2, 2, 2))
        volumes = (["post", "ball"], np.repeat([0, 1], len(cells)))
        write_mesh(self.directory / "two.msh", np.vstack([points, points + (1.4, 0.1, 0.1)]), triangles,
                   np.vstack([cells, cells + len(points)]), volumes)
        law = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}"
        text = (self.PASSING % velocity + more).replace(f"[{{{law}}}]", f"[{{volume: ball, {law}}}, {{volume: post, {law}}}]")
        done = self.call("run", self.write("two.yaml", text), "--output", "out", ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stderr)
        return [line for line in done.stderr.splitlines() if "pass through" in line]

    def test_is_warned_of_once_with_names_and_the_time(self):
        # 0.4 m apart at 15 m/s: they meet after 27 ms and are apart again after 0.16 s, long before the frame at 0.2 s.
        texts = set()
        for ranks in swept((1, 3, 2), (1, 3)):
            with self.subTest(ranks=ranks):
                said = self.warnings("-15", ranks)
                self.assertEqual(len(said), 1, said)
                self.assertRegex(said[0], r"two.yaml:1:14: at t = 0.03 s 'ball' and 'post' pass through one another, 0.05 m deep")
                texts.add(said[0])
        self.assertEqual(len(texts), 1, texts)

    def test_is_of_the_bodies_at_the_place(self):
        """Not of others that share nodes with them, or are tied to them."""
        points, triangles, cells = box((4, 2, 2))
        points[:, 0] *= 2.0
        is_palm = points[cells, 0].mean(axis=1) > 1.0
        volumes = (["post", "ball", "palm"], np.concatenate([np.zeros(len(cells), int), 1 + is_palm]))
        write_mesh(self.directory / "two.msh", np.vstack([points - (1, 0, 0), points + (1.4, 0.1, 0.1)]), triangles, np.vstack([cells, cells + len(points)]), volumes)
        law = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}"
        bodies = ", ".join(f"{{volume: {name}, {law}}}" for name in ("palm", "ball", "post"))
        self.write("two.yaml", (self.PASSING % "-15").replace(f"[{{{law}}}]", f"[{bodies}]"))
        for ranks in (1, 2):
            done = self.pliant("run", "two.yaml", "--output", "out", ranks=ranks)
            self.assertIn("at t = 0.03 s 'ball' and 'post' pass through one another", done.stderr)

    def test_that_does_not_come_to_be_is_not_warned_of(self):
        self.assertEqual(self.warnings("-1.9", 1), [])

    def test_depends_on_what_contact_keeps_apart(self):
        for pair, is_told in (("{surface: ball, with: post}", False), ("{surface: left, with: ball}", True)):
            with self.subTest(pair):
                contact = f"contact: {{law: barrier, pairs: [{pair}]}}\n"
                self.assertEqual(len(self.warnings("-5", 2 if LONG else 1, contact)), int(is_told))


if __name__ == "__main__":
    unittest.main()
