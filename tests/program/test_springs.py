#!/usr/bin/python3
"""Springs and dampers between points of bodies, as users type them: motions that are known, orders, ranks, restart."""
import unittest

import numpy as np

from program import ALL_OR_SOME, ProgramTest, read_history, swept, write_box

BOB = """rigid_bodies:
  - {name: bob, mass: 2, inertia: [0.1, 0.1, 0.1], center: [0.5, 0, 0]MORE}
springs:
  - {name: coil, points: [{body: ground, point: [0, 0, 0]}, {body: bob, point: [0.5, 0, 0]}], SPRING}
"""
# Two bodies that tumble, held by springs and dampers at points off their centers.
TUMBLING = """rigid_bodies:
  - {name: one, mass: 1, inertia: [0.01, 0.02, 0.025], center: [0.5, 0, 0], angular_velocity: [3, 1, 2]}
  - {name: two, mass: 2, inertia: [0.02, 0.03, 0.04, 0.005, 0, 0.002], center: [1.5, 0.1, 0], velocity: [0, 2, 0]}
springs:
  - {name: hanger, points: [{body: ground, point: [0, 0, 0.5]}, {body: one, point: [0.4, 0.1, 0.1]}], stiffness: 60, damping: 3}
  - {name: link, points: [{body: one, point: [0.6, -0.1, 0.05]}, {body: two, point: [1.3, 0.2, 0.1]}], stiffness: 80, rest: 0.6, damping: 2}
  - {name: brake, points: [{body: two, point: [1.7, 0, 0]}, {body: ground, point: [2, 1, 0]}], damping: 4}
loads: [{gravity: [0, 0, -9.81]}]
"""
# A soft bar between the ground and a rigid body that hangs from it, with springs across the ranks.
SOFT = """mesh: {file: bar.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 40 kPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: ball, mass: 0.5, inertia: [0.001, 0.001, 0.001], center: [0.6, 0.05, 0]}
constraints: [{surface: left, displacement: [0, 0, 0]}]
springs:
  - {name: rope, points: [[0.4, 0.05, 0.05], {body: ball, point: [0.58, 0.05, 0]}], stiffness: 80, damping: 0.3}
  - {name: brace, points: [[0.13, 0.03, 0.08], [0.33, 0.07, 0.02]], stiffness: 100, rest: 0.18}
  - {name: guy, points: [[0.21, 0.04, 0.1], {body: ground, point: [0.2, 0.05, 0.4]}], stiffness: 50, damping: 0.2}
loads: [{gravity: [0, 0, -9.81]}]
"""


def integrated(acceleration, x, v, end, steps=20000):
    """Place and velocity at `end` by the classical method of order 4."""
    y, h = np.array([x, v], dtype=float), end / steps

    def rate(y):
        return np.array([y[1], acceleration(*y)])

    for _ in range(steps):
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))
    return y


class Springs(ProgramTest):
    def test_an_oscillator_is_that_of_the_closed_form(self):
        h = self.solve(BOB.replace("SPRING", "stiffness: 200, rest: 0.47, damping: 4").replace("MORE", ", velocity: [0.5, 0, 0]"),
                       "method: dirk33, step: 2 ms, end: 0.4")
        decay, omega, t = 4 / (2 * 2), np.sqrt(200 / 2 - 1), h["time"]
        wave = 0.03 * np.cos(omega * t) + (0.5 + 0.03 * decay) / omega * np.sin(omega * t)
        slope = -0.03 * omega * np.sin(omega * t) + (0.5 + 0.03 * decay) * np.cos(omega * t)
        stretch, rate = np.exp(-decay * t) * wave, np.exp(-decay * t) * (slope - decay * wave)
        np.testing.assert_allclose(h["coil_length"], 0.47 + stretch, atol=1e-7)
        np.testing.assert_allclose(h["bob_x"], 0.47 + stretch, atol=1e-7)
        np.testing.assert_allclose(h["coil_force"], 200 * stretch + 4 * rate, atol=2e-5)
        np.testing.assert_allclose(h["elastic_energy"], 100 * stretch**2, atol=1e-5)
        lost = h["kinetic_energy"][0] + h["elastic_energy"][0] - h["kinetic_energy"][-1] - h["elastic_energy"][-1]
        self.assertAlmostEqual(h["dissipated_spring_dampers"][-1], lost, delta=1e-5 * lost)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-12)

    def test_a_damper_alone_slows_down(self):
        h = self.solve(BOB.replace("SPRING", "damping: 8").replace("MORE", ", velocity: [0.5, 0, 0]"), "method: dirk33, step: 2 ms, end: 0.4")
        np.testing.assert_allclose(h["bob_vx"], 0.5 * np.exp(-4 * h["time"]), atol=1e-6)
        np.testing.assert_allclose(h["coil_force"], 8 * h["bob_vx"], atol=1e-11)
        self.assertAlmostEqual(h["dissipated_spring_dampers"][-1], 0.25 * (1 - np.exp(-3.2)), delta=1e-5)

    def test_a_spring_pendulum(self):
        h = self.solve(BOB.replace("SPRING", "stiffness: 100, damping: 1").replace("MORE", "") + "loads: [{gravity: [0, -9.81, 0]}]\n",
                       "method: dirk33, step: 2 ms, end: 1")

        def acceleration(x, v):
            length = np.hypot(*x)
            force = 100 * (length - 0.5) + x @ v / length
            return -force / 2 * x / length - np.array([0, 9.81])

        x, v = integrated(acceleration, [0.5, 0], [0, 0], 1)
        np.testing.assert_allclose([h["bob_x"][-1], h["bob_y"][-1]], x, atol=2e-6)
        np.testing.assert_allclose([h["bob_vx"][-1], h["bob_vy"][-1]], v, atol=2e-5)
        self.assertAlmostEqual(h["coil_length"][-1], np.hypot(*x), delta=2e-6)

    def test_slack_springs_do_not_push(self):
        # A fall until the rope is taut; below, an oscillation about m g / k.
        rope = BOB.replace("SPRING", "stiffness: 800, rest: 0.7, tension_only: true").replace("MORE", "") + "loads: [{gravity: [9.81, 0, 0]}]\n"
        h = self.solve(rope, "method: dirk33, step: 1 ms, end: 0.4")
        taut = np.sqrt(2 * 0.2 / 9.81)
        falls = h["time"] < taut
        np.testing.assert_allclose(h["bob_x"][falls], 0.5 + 0.5 * 9.81 * h["time"][falls] ** 2, atol=1e-12)
        self.assertEqual(np.abs(h["coil_force"][falls]).max(), 0)
        t, sag, omega = h["time"] - taut, 2 * 9.81 / 800, 20
        hangs = ~falls & (t < 0.2)
        exact = 0.7 + sag - sag * np.cos(omega * t) + 9.81 * taut / omega * np.sin(omega * t)
        hangs &= exact > 0.7
        self.assertGreater(hangs.sum(), 50)
        np.testing.assert_allclose(h["bob_x"][hangs], exact[hangs], atol=1e-5)

    def test_coinciding_points(self):
        # A bushing: both points are one, without a length at rest, and again with one.
        for spring in ("stiffness: 400", "stiffness: 400, damping: 3", "stiffness: 400, rest: 0.01"):
            with self.subTest(spring):
                text = BOB.replace("SPRING", spring).replace("MORE", "").replace("point: [0, 0, 0]", "point: [0.5, 0, 0]")
                h = self.solve(text + "loads: [{gravity: [0, 0, -9.81]}]\n", "method: bdf2, step: 1 ms, end: 0.1")
                self.assertTrue(all(np.isfinite(column).all() for column in h.values()))
                self.assertLess(h["bob_z"][-1], -0.02)
        sag = -2 * 9.81 / 400
        h = self.solve(BOB.replace("SPRING", "stiffness: 400").replace("MORE", "").replace("point: [0, 0, 0]", "point: [0.5, 0, 0]")
                       + "loads: [{gravity: [0, 0, -9.81]}]\n", "method: implicit-midpoint, step: 1 ms, end: 0.1")
        np.testing.assert_allclose(h["bob_z"], sag * (1 - np.cos(np.sqrt(200) * h["time"])), atol=1e-5)

    def test_every_method_keeps_its_order(self):
        self.write("in.yaml", TUMBLING + "time: {method: bdf2, step: 5 ms, end: 80 ms}\n")
        self.pliant("converge", "in.yaml", "--in", "time", "--levels", "4", "--methods", ALL_OR_SOME)

    def test_the_ledger_closes(self):
        for method in ("bdf2", "dirk33", "implicit-midpoint"):
            with self.subTest(method):
                h = self.solve(TUMBLING, f"method: {method}, step: 2 ms, end: 0.2")
                scale = h["kinetic_energy"].max()
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * scale)
                self.assertGreater(h["dissipated_spring_dampers"][-1], 0.05 * scale)
        # Nothing from outside, nothing lost: momenta and energy stay.
        free = TUMBLING[: TUMBLING.index("  - {name: hanger")] + next(line for line in TUMBLING.splitlines() if "link" in line)
        h = self.solve(free.replace(", damping: 2", "") + "\nsolver: {newton: {relative: 1e-12}}\n", "method: implicit-midpoint, step: 2 ms, end: 0.2")
        for column in ("px", "py", "pz", "Lx", "Ly", "Lz"):
            np.testing.assert_allclose(h[column], h[column][0], atol=1e-10)
        energy = h["kinetic_energy"] + h["elastic_energy"]
        np.testing.assert_allclose(energy, energy[0], rtol=1e-3)

    def test_a_soft_body_hangs_on_springs(self):
        # At rest the forces of springs and supports carry the weight.
        write_box(self.directory / "bar.msh", (4, 1, 1), (0.4, 0.1, 0.1))
        text = SOFT[: SOFT.index("rigid_bodies")] + SOFT[SOFT.index("constraints"):].replace(
            next(line for line in SOFT.splitlines(True) if "rope" in line), "")
        h = self.solve(text, "method: static, load_steps: 4")
        probe = h["guy_force"][-1]
        self.assertGreater(probe, 1)
        self.assertAlmostEqual(probe, 50 * (h["guy_length"][-1] - h["guy_length"][0]), delta=1e-9)
        self.assertAlmostEqual(h["brace_force"][-1], 100 * (h["brace_length"][-1] - 0.18), delta=1e-9)
        self.assertLess(h["left_fz"][-1], 0.99 * 1000 * 4e-3 * 9.81)
        moved = 1000 * 4e-3 * 9.81 - h["left_fz"][-1]
        self.assertGreater(probe, moved)  # its vertical part carries the rest
        self.assertAlmostEqual(probe**2, moved**2 + h["left_fx"][-1] ** 2 + h["left_fy"][-1] ** 2, delta=1e-5 * probe**2)

    def test_springs_hold_a_body_at_rest(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (0.4, 0.1, 0.1))
        ends = {"a": ([0.05, 0.05, 0.1], [0.05, 0.05, 0.3]), "b": ([0.35, 0.02, 0.1], [0.35, 0.02, 0.3]), "c": ([0.35, 0.08, 0.1], [0.35, 0.08, 0.3]),
                "d": ([0.05, 0, 0.05], [0.05, -0.2, 0.05]), "e": ([0.35, 0, 0.05], [0.35, -0.2, 0.05]), "f": ([0, 0.05, 0.05], [-0.2, 0.05, 0.05])}
        springs = "".join(f"  - {{name: {name}, points: [{at}, {{body: ground, point: {to}}}], stiffness: 3000}}\n" for name, (at, to) in ends.items())
        h = self.solve(SOFT[: SOFT.index("rigid_bodies")] + "springs:\n" + springs + "loads: [{gravity: [0, 0, -9.81]}]\n", "method: static, load_steps: 2")
        self.assertAlmostEqual(sum(h[f"{name}_force"][-1] for name in "abc"), 1000 * 4e-3 * 9.81, delta=0.1)

    def test_a_release_does_not_carry_on(self):
        # A shallow truss that a stretched spring presses down by 0.17 m, where it has an equilibrium before it snaps:
        # the small load, or none, that the steps after it add does not make it move on by as much again.
        truss = '''
rigid_bodies: [{name: apex, mass: 1, inertia: [1, 1, 1], center: [0, 0.3, 0]}]
joints: [{name: guide, type: slider, between: [ground, apex], point: [0, 0.3, 0], axis: [0, 1, 0], spring: {stiffness: 50, rest: REST}}]
springs:
  - {name: left, points: [{body: ground, point: [-1, 0, 0]}, {body: apex, point: [0, 0.3, 0]}], stiffness: 1000}
  - {name: right, points: [{body: ground, point: [1, 0, 0]}, {body: apex, point: [0, 0.3, 0]}], stiffness: 1000}
loads: [{force: [0, FORCE, 0], volume: apex}]
'''
        pressed = truss.replace("REST", "-0.35368").replace("FORCE", "0.1")

        def force(y):
            length = np.hypot(1, y)
            return -50 * (y - 0.3 + 0.35368) - 2000 * (length - np.hypot(1, 0.3)) * y / length

        rows = self.solve(pressed, "method: static, load_steps: 5")["apex_y"][1:]
        np.testing.assert_allclose(force(rows), -0.02 * np.arange(1, 6), atol=1e-5)
        self.assertGreater(rows.min(), 0.13)
        rows = self.solve(pressed, "method: quasistatic, step: 0.25, end: 1")["apex_y"][1:]
        np.testing.assert_allclose(rows, 0.1361076, atol=1e-6)
        jump = truss.replace("REST", "0").replace("FORCE", '"t < 0.3 ? 0 : -17.6"')
        h = self.solve(jump, "method: quasistatic, step: 0.25, end: 1")
        np.testing.assert_allclose(h["apex_y"][h["time"] > 0.4], 0.1352328, atol=1e-6)

    def test_springs_that_are_stretched_at_the_start_move_bodies(self):
        self.write("in.yaml", BOB.replace("SPRING", "stiffness: 20, rest: 0.4").replace("MORE", "") + "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
        self.assertNotIn("nothing moves", self.pliant("check", "in.yaml").stderr)
        self.write("in.yaml", BOB.replace("SPRING", "stiffness: 20").replace("MORE", "") + "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
        self.assertIn("nothing moves", self.pliant("check", "in.yaml").stderr)

    def test_ranks_and_restart_do_not_matter(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (0.4, 0.1, 0.1))
        texts = (TUMBLING, "element: P2\n" + SOFT, SOFT)
        for text in swept(texts, texts[::2]):
            one, *others = [self.solve(text, "method: bdf2, step: 4 ms, end: 40 ms", ranks) for ranks in swept((1, 3, 2), (1, 3))]
            self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-8 * one["kinetic_energy"].max())
            for other in others:
                self.assert_same_history(other, one, 1e-7)
        self.write("in.yaml", SOFT + "time: {method: bdf2, step: 4 ms, end: 20 ms}\n")
        self.pliant("run", "in.yaml", "--quiet", "--output", "half", "--set", "checkpoint={}")
        self.pliant("resume", "half", "--quiet", "--set", "time.end=40ms", ranks=2)
        self.assert_same_history(read_history(self.directory / "half"), one, 1e-7)  # of the last text

    def test_points_in_rigid_volumes(self):
        # A rigid brick with a mesh, held by a point beside it: the same as one without a mesh.
        write_box(self.directory / "brick.msh", (1, 1, 1), (0.2, 0.1, 0.1))
        spring = "springs: [{name: s, points: [{body: NAME, point: [0.5, 0.2, 0]}, {body: ground, point: [0.5, 0.6, 0]}], stiffness: 100, damping: 1}]\n"
        time = "method: dirk33, step: 4 ms, end: 0.2"
        gravity = "loads: [{gravity: [0, -9.81, 0]}]\n"
        meshed = self.solve("mesh: {file: brick.msh}\nbodies: [{volume: body, density: 1000, rigid: true}]\n"
                            + spring.replace("NAME", "body") + gravity, time)
        inertia = [2 / 12 * 0.02, 2 / 12 * 0.05, 2 / 12 * 0.05]
        given = self.solve(f"rigid_bodies: [{{name: brick, mass: 2, inertia: {inertia}, center: [0.1, 0.05, 0.05]}}]\n"
                           + spring.replace("NAME", "brick") + gravity, time)
        for column in ("s_length", "s_force", "kinetic_energy", "elastic_energy"):
            np.testing.assert_allclose(meshed[column], given[column], rtol=1e-6, atol=1e-9, err_msg=column)

    def test_errors_say_what_is_wrong(self):
        bob = BOB.replace("SPRING", "stiffness: 1").replace("MORE", "")
        write_box(self.directory / "bar.msh", (4, 1, 1), (0.4, 0.1, 0.1))
        cases = {
            "does nothing: give it 'stiffness', 'damping' or both": bob.replace("stiffness: 1", "rest: 1"),
            "'stiffness' must be": bob.replace("stiffness: 1", "stiffness: -1"),
            "'damping' must be": bob.replace("stiffness: 1", "damping: -1"),
            "would jump where the spring becomes slack": bob.replace("stiffness: 1", "stiffness: 1, damping: 1, tension_only: true"),
            "both points of spring 'coil' are fixed in 'bob'": bob.replace("body: ground", "body: bob"),
            "which is not a rigid body (did you mean 'bob'?)": bob.replace("{body: bob,", "{body: bop,"),
            "and there is no mesh: name its body": bob.replace("{body: bob, point: [0.5, 0, 0]}", "[0.5, 0, 0]"),
            "outside the mesh": SOFT.replace("[[0.21, 0.04, 0.1],", "[[0.21, 0.04, 0.2],"),
            "as a place in the mesh": SOFT.replace("bodies: [{density", "bodies: [{volume: body, density").replace("[[0.21, 0.04, 0.1],", "[{body: body, point: [0.2, 0, 0]},"),
            "missing key 'point'": bob.replace("{body: ground, point: [0, 0, 0]}", "{body: ground}"),
            "a place [x, y, z], or {body: name, point: [x, y, z]}": bob.replace("{body: ground, point: [0, 0, 0]}", "ground"),
            "must be a list of 2 values": bob.replace("{body: ground, point: [0, 0, 0]}, ", ""),
            "the spring name 'coil' is given twice": bob + "  - {name: coil, points: [{body: ground, point: [0, 0, 0]}, {body: bob, point: [0, 0, 0]}], damping: 1}\n",
            "'bob' names a rigid body and a spring": bob.replace("name: coil", "name: bob"),
        }
        for message, text in cases.items():
            with self.subTest(message):
                self.write("in.yaml", text + "time: {method: bdf2, step: 10 ms, end: 0.1}\n")
                for ranks in swept((1, 2), (1,)):
                    errors = self.pliant("check", "in.yaml", ranks=ranks, status=2).stderr
                    self.assertIn(message, errors)
                    self.assertIn("in.yaml:", errors)


if __name__ == "__main__":
    unittest.main()
