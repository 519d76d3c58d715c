#!/usr/bin/python3
"""Simulations that Python drives: the same numbers as the program, steps taken back, loads that change, coupling, and wrong use."""
import contextlib
import importlib.util
import io
import logging
import os
import re
import shutil
import signal
import subprocess
import sys
import unittest

import numpy as np

from program import ENVIRONMENT, PROGRAM, ROOT, ProgramTest, finish, read_history, write_box

sys.path.insert(0, str(ROOT / "src/python"))
os.environ.update(ENVIRONMENT, PLIANT=str(PROGRAM))

import pliant  # noqa: E402

logging.getLogger("pliant").setLevel(logging.ERROR)

BODY = """
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""
FALLING = BODY + "loads: [{gravity: [0, 0, -9.81]}]\n"
# Memory of every kind: of stresses, of friction, of contact.
SLIDING = """
mesh: {file: bar.msh}
bodies:
  - volume: body
    density: 1000
    elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}
    viscosity: {model: prony, ratio: 0.3, relaxation_time: 20 ms}
loads: [{gravity: [3, 0, -9.81]}]
initial: {velocity: [1, 0, -0.5]}
contact:
  law: penalty
  friction: 0.4
  obstacles: [{name: floor, shape: plane, point: [0, 0, -0.001], normal: [0, 0, 1]}]
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""
BDF2 = "time: {method: bdf2, step: 10 ms, end: 60 ms}\n"

# Prints rows in full: of a run of `in.yaml`, and of steps that were taken back.
ON_RANKS = """
import sys
sys.path.insert(0, {package!r})
import pliant
with pliant.Simulation("in.yaml") as sim:
    while not sim.done:
        sim.advance()
        if sim.own_nodes.start == 0:
            print("row", *map(repr, sim.row.values()))
with pliant.Simulation("in.yaml") as sim:
    sim.run(until=0.02)
    state = sim.save()
    sim.run()
    first, u = list(sim.row.values()), sim.displacement
    sim.restore(state)
    sim.surface("right").apply_forces(0 * sim.surface("right").coordinates + 1)
    sim.advance()
    sim.restore(state)
    sim.run()
    same = list(sim.row.values()) == first and (sim.displacement == u).all()
    if sim.own_nodes.start == 0:
        print("same", same, len(sim.own_nodes) < len(u))
"""


class SimulationTest(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2))
        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        os.chdir(self.directory)

    def python(self, code, ranks=1, timeout=100):
        """The code as a script of its own."""
        self.write("script.py", code)
        call = ["/usr/bin/python3", "script.py"]
        if ranks > 1:
            call = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), *call]
        process = subprocess.Popen(call, cwd=self.directory, env=os.environ, text=True, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        return finish(process, timeout)


class TestHistory(SimulationTest):
    def assert_same_as_program(self, text):
        self.write("in.yaml", text)
        expected = self.run_input("in.yaml")
        with pliant.Simulation("in.yaml") as sim:
            self.assertEqual(sim.columns, list(expected))
            rows = [list(sim.row.values())]
            while not sim.done:
                sim.advance()
                rows.append(list(sim.row.values()))
        np.testing.assert_array_equal(np.array(rows).T, np.array(list(expected.values())))

    def test_whole_turns_are_restored(self):
        # A spring that has been wound up by a turn and a half has its energy again.
        text = """rigid_bodies: [{name: wheel, mass: 2, inertia: [0.1, 0.1, 0.05], center: [0, 0, 0]}]
joints: [{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 5, rest: 6}, motor: {effort: 0}}]
time: {method: dirk33, step: 5 ms, end: 1}
"""
        with pliant.Simulation(self.write("wheel.yaml", text), output=None) as sim:
            sim.run(until=0.2)
            state, angle = sim.save(), sim.row["axle_angle"]
            sim.run(until=0.4)
            sim.restore(state)
            sim.set("joints.0.motor.effort", 0.1)
            sim.advance()
            self.assertGreater(angle, 8)
            self.assertAlmostEqual(sim.row["axle_angle"], angle, delta=0.5)
            self.assertLess(abs(sim.row["load_work"]), 0.1)

    def test_every_column_is_that_of_the_program_to_the_last_bit(self):
        for text in (FALLING + BDF2, SLIDING + "time: {method: dirk22, step: 10 ms, end: 40 ms}\n",
                     FALLING + "time: {method: bdf2, step: 5 ms, end: 40 ms, adaptive: {relative: 1e-3}}\n",
                     FALLING + "time: {method: static, load_steps: 3}\n",
                     BODY + "loads: [{surface: right, traction: [0, 0, \"1e3*x\"]}]\n" + BDF2):
            with self.subTest(text=text):
                self.assert_same_as_program(text)

    def test_two_ranks(self):
        self.write("in.yaml", FALLING + BDF2)
        expected = self.run_input("in.yaml", ranks=2)
        done = self.python(ON_RANKS.format(package=str(ROOT / "src/python")), ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("row")]
        np.testing.assert_array_equal(np.array(rows, dtype=float).T, np.array(list(expected.values()))[:, 1:])
        self.assertIn("same True True", done.stdout)

    def test_files_are_those_of_the_program(self):
        # Where a run writes a checkpoint it forgets what only makes it faster, as it does where a state is saved.
        self.write("in.yaml", FALLING + BDF2 + "output: {every: 20 ms}\ncheckpoint: {every: 3}\n")
        self.run_input("in.yaml")
        with pliant.Simulation("in.yaml", output="driven") as sim:
            sim.run(until=0.03)
            state = sim.save()
            sim.run()
            sim.restore(state)
            sim.run()
        self.assertEqual((self.directory / "driven/history.csv").read_bytes(), (self.directory / "out/history.csv").read_bytes())
        ours, theirs = pliant.Result("driven"), pliant.Result("out")
        self.assertEqual(list(ours.times), list(theirs.times))
        np.testing.assert_array_equal(ours[-1]["displacement"], theirs[-1]["displacement"])

    def test_no_files_without_a_directory(self):
        before = sorted(os.listdir())
        with pliant.Simulation(FALLING + BDF2) as sim:
            sim.run()
            with self.assertRaisesRegex(pliant.InputError, "writes no files"):
                sim.write_frame()
        self.assertEqual(sorted(os.listdir()), before)


class TestSavedStates(SimulationTest):
    def test_repeated_steps_are_the_same_to_the_last_bit(self):
        mixed = FALLING.replace("poissons_ratio: 0.4", "poissons_ratio: 0.49")
        for text in (FALLING + BDF2, FALLING + BDF2.replace("bdf2", "dirk22"), SLIDING + BDF2, SLIDING + BDF2.replace("bdf2", "dirk22"),
                     "volumetric: mixed\nelement: P1\n" + mixed + BDF2, FALLING + "time: {method: static, load_steps: 6}\n",
                     FALLING + "time: {method: bdf2, step: 5 ms, end: 60 ms, adaptive: {relative: 1e-3}}\n"):
            with self.subTest(text=text), pliant.Simulation(text) as sim:
                sim.advance()
                sim.advance()
                state = sim.save()
                at_save = list(sim.row.values())
                first = self.steps(sim, 3)
                sim.restore(state)
                self.assertEqual(list(sim.row.values()), at_save)
                sim.set("loads.0.gravity", [0, 4, -2])
                self.assertNotEqual(str(self.steps(sim, 2)), str(first[:2]))
                sim.restore(state)
                for ours, theirs in zip(self.steps(sim, 3), first):
                    np.testing.assert_array_equal(ours, theirs)

    @staticmethod
    def steps(sim, number):
        states = []
        for _ in range(number):
            sim.advance()
            states.append(np.concatenate([list(sim.row.values()), sim.displacement.ravel(), sim.velocity.ravel()]))
        return states


class TestChanges(SimulationTest):
    def driven(self, text, key, value, at):
        with pliant.Simulation(text) as sim:
            sim.run(until=at)
            sim.set(key, value)
            sim.run()
            return sim.row

    def assert_near(self, row, expected, tolerance=1e-7):
        for name in ("tip_x", "tip_z", "tip_vz", "elastic_energy", "kinetic_energy", "load_work"):
            scale = max(abs(expected[name]).max(), 1e-12)
            self.assertLess(abs(row[name] - expected[name][-1]), tolerance * scale, name)

    def test_a_motion_takes_the_step_that_is_set_with_it(self):
        text = BODY.replace("probes: [", "probes: [{name: root, point: [0, 0, 0]}, ") + BDF2
        with pliant.Simulation(text) as sim:
            sim.advance()
            sim.set({"time.step": sim.dt / 4, "constraints.0.displacement.2": 0.01})
            for _ in range(2):
                sim.advance()
                self.assertAlmostEqual(sim.get("root_z"), 0.01, delta=1e-12)

    def test_a_load_jumps_as_by_a_formula(self):
        euler = "time: {method: backward-euler, step: 10 ms, end: 60 ms}\n"
        for kind, before, after, formula in (("traction", "[0, 0, 0]", [0, 0, 500.0], "[0, 0, \"t < 0.03 ? 0 : 500\"]"),
                                             ("force", "[0, 0, \"t\"]", [0, 0, "20*sin(30*t)"], "[0, 0, \"t < 0.03 ? t : 20*sin(30*t)\"]")):
            load = "loads: [{{surface: right, {}: {}}}]\n"
            expected = self.solve(BODY + load.format(kind, formula), "method: backward-euler, step: 10 ms, end: 60 ms")
            row = self.driven(BODY + load.format(kind, before) + euler, f"loads.0.{kind}", after, 0.03)
            # A load that was constant counts with its potential until it is replaced.
            self.assert_near(row | {"load_work": row["load_work"] - row["load_potential"]}, expected, 1e-6)
            self.assertLess(abs(row["energy_balance_error"]), 1e-7 * row["elastic_energy"])

    # (lines of the input, key, value at the start, value from 0.03 s on)
    FORCES = (
        ("loads: [{surface: right, pressure: VALUE}]", "loads.0.pressure", "0", "30 kPa"),
        ("loads: [{gravity: [0, 0, VALUE]}]", "loads.0.gravity.2", "-1", "-9.81"),
        ("tendons: [{name: pull, points: [[0, 0.1, 0.15], [1, 0.1, 0.15]], tension: VALUE}]", "tendons.pull.tension", "10", "100 N"),
        ("tendons: [{name: pull, points: [[0, 0.1, 0.15], [1, 0.1, 0.15]], stiffness: 1000, pull: VALUE}]", "tendons.pull.pull", "1e-3", "0.1"),
        ("loads: [{surface: right, force: [0, 0, \"50*y + VALUE\"]}]", "loads.0.force.2", "0", "9"),
        ("rigid_bodies: [{name: wheel, mass: 1, inertia: [1, 1, 1], center: [0, 0, 2]}]\njoints: [{name: axle, type: hinge, "
         "between: [ground, wheel], point: [0, 0, 2], axis: [1, 0, 0], motor: {target: VALUE, stiffness: 20, damping: 1}}]",
         "joints.axle.motor.target", "0", "0.5"),
        ("rigid_bodies: [{name: wheel, mass: 1, inertia: [1, 1, 1], center: [0, 0, 2]}]\njoints: [{name: axle, type: hinge, "
         "between: [ground, wheel], point: [0, 0, 2], axis: [1, 0, 0]}]\nloads: [{volume: wheel, torque: [VALUE, 0, 0]}]",
         "loads.0.torque.0", "1", "-2"),
        ("active", "bodies.0.active.stress", "1e3", "40 kPa"),
        ("expansion", "bodies.0.expansion.stretch", "1", "1.05"),
    )
    IN_BODY = {"active": "active: {fibre: [1, 0, 0], stress: VALUE}", "expansion": "expansion: {stretch: VALUE}"}
    # Likewise, in addition to what holds the left side; motions that are reached from 0.03 s to 0.04 s.
    MOTIONS = (
        ("{surface: right, normal_displacement: VALUE}", "constraints.1.normal_displacement", "0", "-20 mm"),
        ("{surface: right, displacement_along: VALUE, direction: [1, 1, 0]}", "constraints.1.displacement_along", "1 mm", "20 mm"),
        ("{surface: right, rigid: {translation: [0, 0, 0], rotation: {axis: [1, 0, 0], angle: VALUE}}}",
         "constraints.1.rigid.rotation.angle", "0", "0.5"),
        ("{surface: right, rigid: {translation: [0, 0, VALUE], rotation: free}}", "constraints.1.rigid.translation.2", "0", "0.05"),
        ("{equation: [{surface: right, component: z}], value: VALUE}", "constraints.1.value", "0", "0.05"),
        ("contact", "contact.obstacles.press.motion.translate.2", "0", "-30 mm"),
    )
    PRESS = """contact:
  law: penalty
  friction: 0.3
  obstacles: [{name: press, shape: plane, point: [0, 0, 0.201], normal: [0, 0, -1], motion: {translate: [0, 0, VALUE]}}]
constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: bottom, displacement: [free, free, 0]}]
"""

    def test_every_kind_of_load_as_by_a_formula(self):
        for lines, key, before, after in self.FORCES:
            with self.subTest(lines):
                time = "method: backward-euler, step: 10 ms, end: 50 ms"
                si = {"30 kPa": "30e3", "100 N": "100", "40 kPa": "40e3"}.get(after, after)
                formula = f"(t < 0.03 ? {before} : {si})"
                text = BODY.replace("0.4}}", f"0.4}}, {self.IN_BODY[lines]}}}") if lines in self.IN_BODY else BODY + lines + "\n"
                # In the middle of a formula there are quotes already.
                quoted = text.replace("VALUE\"", formula + "\"").replace("VALUE", f"\"{formula}\"")
                expected = self.solve(quoted, time)
                value = after if "50*y" not in lines else "50*y + 9"
                row = self.driven(text.replace("VALUE", before) + f"time: {{{time}}}\n", key, value, 0.03)
                self.assert_same_motion(row, expected)

    def test_every_kind_of_motion_as_by_a_formula(self):
        for lines, key, before, after in self.MOTIONS:
            with self.subTest(lines):
                time = "method: quasistatic, step: 10 ms, end: 50 ms"
                low, high = (float(value.split()[0]) * (1e-3 if "mm" in value else 1) for value in (before, after))
                formula = f"\"{low} + {high - low}*min(max((t - 0.03)/0.01, 0), 1)\""
                text = BODY.replace("}]\nprobes", f"}}, {lines}]\nprobes")
                if lines == "contact":
                    text = BODY.replace("constraints: [{surface: left, displacement: [0, 0, 0]}]\n", self.PRESS)
                expected = self.solve(text.replace("VALUE", formula), time)
                row = self.driven(text.replace("VALUE", before) + f"time: {{{time}}}\n", key, after, 0.03)
                self.assertGreater(abs(expected["elastic_energy"]).max(), 0.1)
                self.assert_same_motion(row, expected)

    def assert_same_motion(self, row, expected):
        told = {"load_work", "load_potential", "newton_iterations", "linear_iterations", "energy_balance_error", "numerical_dissipation"}
        for name in set(expected) - told:
            kind = name.rstrip("xyz")
            scale = max(abs(expected[other]).max() for other in expected if other.rstrip("xyz") == kind)
            self.assertLessEqual(abs(row[name] - expected[name][-1]), 1e-6 * scale + 1e-10, name)

    def test_numbers_for_the_motion_of_a_joint(self):
        # A turn at constant velocity: what brings it to that is an impulse, whose work is the kinetic energy.
        for method in ("bdf2", "dirk33", "implicit-midpoint"):
            with self.subTest(method), pliant.Simulation(f"""rigid_bodies: [{{name: wheel, mass: 2, inertia: [0.1, 0.1, 0.1], center: [0.5, 0, 0]}}]
joints: [{{name: axle, type: hinge, between: [ground, wheel], point: [0, 0, 0], axis: [0, 0, 1], motion: 0}}]
time: {{method: {method}, step: 10 ms, end: 0.1}}
""") as sim:
                sim.advance()
                for k in range(1, 6):
                    sim.set("joints.axle.motion", 0.1 * k)
                    sim.advance()
                    self.assertAlmostEqual(sim.get("axle_angle"), 0.1 * k, delta=1e-12)
                    self.assertLess(abs(sim.get("axle_tz")), 5)
                self.assertAlmostEqual(sim.get("kinetic_energy"), 30, delta=1e-6)
                self.assertAlmostEqual(sim.get("support_work"), 30, delta=0.6)
                sim.advance()
                self.assertLess(sim.get("kinetic_energy"), 1e-6)
                self.assertAlmostEqual(sim.get("axle_angle"), 0.5, delta=1e-12)

    def test_balance_of_energy_when_a_constant_load_changes(self):
        with pliant.Simulation(FALLING + BDF2) as sim:
            for k in range(5):
                sim.advance()
                sim.set("loads.0.gravity", [0, 0, -9.81 + k])
                sim.set({"loads.0.gravity.0": k, "loads.0.gravity.1": f"{k}*t"})
            sim.advance()
            row = sim.row
        self.assertLess(abs(row["energy_balance_error"]), 1e-7 * row["elastic_energy"])
        self.assertLess(abs(row["numerical_dissipation"]), 0.2 * row["elastic_energy"])

    def test_a_prescribed_displacement_is_reached_at_constant_velocity(self):
        time = "method: quasistatic, step: 10 ms, end: 60 ms"
        held = BODY.replace("0.4}}", "0.4}, viscosity: {model: kelvin-voigt, shear: 1000, bulk: 1000}}").replace("}]\nprobes", """},
  {surface: right, displacement: [FORMULA, 0, 0]}]
probes""")
        expected = self.solve(held.replace("FORMULA", "\"0.02*min(max((t - 0.03)/0.01, 0), 1)\""), time)
        row = self.driven(held.replace("FORMULA", "0") + f"time: {{{time}}}\n", "constraints.1.displacement.0", "20 mm", 0.03)
        self.assertGreater(row["dissipated_kelvin_voigt"], 1.0)
        for name in ("tip_x", "elastic_energy", "dissipated_kelvin_voigt", "support_work"):
            self.assertAlmostEqual(row[name], expected[name][-1], delta=1e-7 * abs(expected[name]).max(), msg=name)
        with pliant.Simulation(BODY + BDF2) as sim:
            sim.run(until=0.02)
            sim.set("constraints.0.displacement", [0, 0, "20 mm"])
            sim.advance()
            left = sim.surface("left")
            np.testing.assert_allclose(left.displacement - [0, 0, 0.02], 0, atol=1e-15)
            np.testing.assert_allclose(left.velocity - [0, 0, 2], 0, atol=1e-9)
            sim.advance()
            np.testing.assert_array_equal(left.velocity, np.zeros((4, 3)))
            self.assertLess(abs(sim.get("energy_balance_error")), 1e-7 * sim.get("elastic_energy"))

    def test_a_surface_is_moved_node_by_node_as_by_its_formula_at_rest(self):
        time = "method: static, load_steps: 2"
        held = BODY.replace("}]\nprobes", "}, {surface: right, displacement: [\"0.1*y\", 0, \"0.2*(1 + z)\"]}]\nprobes")
        expected = self.solve(held, time)
        with pliant.Simulation(held.replace("[\"0.1*y\", 0, \"0.2*(1 + z)\"]", "[0, 0, 0]") + f"time: {{{time}}}\n") as sim:
            right = sim.surface("right")
            _, y, z = right.coordinates.T
            right.move(np.column_stack([0.1 * y, 0 * y, 0.2 * (1 + z)]))
            sim.run()
            self.assertAlmostEqual(sim.get("elastic_energy"), expected["elastic_energy"][-1], delta=1e-9 * sim.get("elastic_energy"))
            np.testing.assert_allclose(right.reaction.sum(axis=0), [expected[f"right_f{i}"][-1] for i in "xyz"], rtol=1e-9, atol=1e-9)

    def test_forces_on_nodes_are_those_of_a_traction(self):
        time = "method: bdf2, step: 10 ms, end: 40 ms"
        expected = self.solve(BODY + "loads: [{surface: right, force: [0, 0, 10]}]\n", time)
        with pliant.Simulation(BODY + f"time: {{{time}}}\n") as sim:
            right = sim.surface("right")
            # The shares of a uniform traction on two triangles: nodes on the diagonal belong to both.
            corner = right.coordinates[:, 1:]
            shares = np.array([self.share(corner, point) for point in corner])
            right.apply_forces(np.outer(shares, [0, 0, 10]))
            sim.run()
            self.assertAlmostEqual(sim.get("tip_z"), expected["tip_z"][-1], delta=1e-7)
            self.assertLess(abs(sim.get("energy_balance_error")), 1e-7 * sim.get("elastic_energy"))

    def share(self, corners, point):
        mesh = pliant.Result("out").mesh()
        faces = pliant.Surface(mesh, 1)
        x = faces.of_nodes(mesh.coordinates)
        total = 0.0
        for triangle in faces.triangles:
            if (x[triangle, 0] > 1 - 1e-9).all():
                total += np.isclose(x[triangle, 1:], point).all(axis=1).any() / 6
        return total

    def test_time_step(self):
        with pliant.Simulation(FALLING + BDF2) as sim:
            sim.run(until=0.02)
            sim.set("time.step", "5 ms")
            self.assertAlmostEqual(sim.next_dt, 0.005)
            sim.advance()
            self.assertAlmostEqual(sim.time, 0.025)
            self.assertAlmostEqual(sim.dt, 0.005)

    def test_time_step_with_adaptive_steps(self):
        # Defaults of other keys follow from the step.
        adaptive = BDF2.replace("end: 60 ms", "end: 60 ms, adaptive: {relative: 1e-3}")
        self.assertIn("adaptive", adaptive)
        with pliant.Simulation(FALLING + adaptive) as sim:
            sim.advance()
            sim.set("time.step", "2 ms")
            sim.set("loads.0.gravity.2", -5)
            sim.advance()
            with self.assertRaisesRegex(pliant.PliantError, "this cannot change while a simulation runs"):
                sim.set("bodies.0.density", 7)

    def test_entries_of_lists_by_name(self):
        tendon = "tendons: [{name: pull, points: [[0, 0.1, 0.15], [0.5, 0.1, 0.15], [1, 0.1, 0.15]], tension: 0}]\n"
        with pliant.Simulation(BODY + tendon + BDF2) as sim:
            sim.set("tendons.pull.tension", "20 N")
            sim.advance()
            self.assertEqual(sim.get("pull_tension"), 20)
            with self.assertRaisesRegex(pliant.InputError, "'push' does not name an entry .* their names: pull"):
                sim.set("tendons.push.tension", 1)


class TestCoupling(SimulationTest):
    """Two halves of a bar, one driven by forces and one by displacements where they meet, against the whole bar."""

    HALF = """
mesh: {{file: {file}.msh}}
bodies:
  - {{volume: body, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, 0, -9.81]}}]
time: {{method: {method}, step: 10 ms, end: 50 ms}}
"""

    def test_halves_move_as_the_whole(self):
        write_box("whole.msh", (8, 1, 1), (1, 0.2, 0.2))
        write_box("first.msh", (4, 1, 1), (0.5, 0.2, 0.2))
        write_box("second.msh", (4, 1, 1), (0.5, 0.2, 0.2), origin=(0.5, 0, 0))
        for method in ("backward-euler", "bdf2"):
            whole, first, second = (pliant.Simulation(self.HALF.format(file=file, method=method)) for file in ("whole", "first", "second"))
            near, far = first.surface("right"), second.surface("left")
            np.testing.assert_allclose(near.coordinates, far.coordinates, atol=1e-12)
            iterations = 0
            while not first.done:
                whole.advance()
                iterations += self.step(first, second, near, far)
            difference = abs(second.displacement[self.nearest(second, [1, 0.1, 0])] - whole.displacement[self.nearest(whole, [1, 0.1, 0])])
            self.assertGreater(abs(whole.displacement).max(), 0.01)
            self.assertLess(difference.max(), 1e-6 * abs(whole.displacement).max())
            self.assertLess(iterations, 5 * 25)

    @staticmethod
    def nearest(sim, point):
        return np.argmin(np.linalg.norm(sim.coordinates - point, axis=1))

    @staticmethod
    def step(first, second, near, far):
        """One implicit step by Aitken's relaxation of the displacement of the interface; returns the iterations."""
        states = first.save(), second.save()
        u, before, relaxation = near.displacement + near.velocity * first.next_dt, None, 0.5
        for iteration in range(1, 50):
            first.restore(states[0])
            second.restore(states[1])
            far.move(u)
            second.advance()
            near.apply_forces(-far.reaction)
            first.advance()
            residual = near.displacement - u
            if abs(residual).max() < 1e-10:
                return iteration
            if before is not None:
                change = residual - before
                relaxation *= -(before * change).sum() / (change * change).sum()
            u, before = u + relaxation * residual, residual
        raise AssertionError("the coupling does not converge")


class TestWrongUse(SimulationTest):
    def test_what_is_wrong_is_said(self):
        with pliant.Simulation(FALLING + BDF2) as sim:
            right = sim.surface("right")
            for error, expected, call in (
                    (ValueError, "cannot change while a simulation runs; what can: loads", lambda: sim.set("bodies.0.density", 900)),
                    (ValueError, "cannot change while a simulation runs", lambda: sim.set("mesh.file", "other.msh")),
                    (ValueError, "cannot change while a simulation runs", lambda: sim.set("time.method", "dirk22")),
                    (ValueError, "did you mean 'gravity'", lambda: sim.set("loads.0.gravty", [0, 0, 1])),
                    (ValueError, "its only entry has the number 0", lambda: sim.set("loads.1.gravity", [0, 0, 1])),
                    (ValueError, "is a length, but an acceleration", lambda: sim.set("loads.0.gravity", [0, 0, "1 m"])),
                    (ValueError, "has no surface 'rigth' .did you mean 'right'", lambda: sim.surface("rigth")),
                    (ValueError, r"shape \(4, 3\) is needed, not \(3,\)", lambda: right.apply_forces([0, 0, 1])),
                    (ValueError, "1 of 12 numbers are not finite", lambda: right.apply_forces([[0, 0, np.nan]] + 3 * [[0, 0, 0]])),
                    (ValueError, "cannot be moved node by node; hold it", lambda: right.move(np.zeros((4, 3)))),
                    (ValueError, "^set loads.0.gravity=9.81: 'gravity' must be", lambda: sim.set("loads.0.gravity", 9.81)),
                    (ValueError, "^set loads.0.gravity: a value is expected, not nothing", lambda: sim.set("loads.0.gravity", None)),
                    (ValueError, "^set loads.0.gravity.2: a value is expected, not nothing", lambda: sim.set({"loads.0.gravity.2": ""})),
                    (ValueError, "^set time.step: a finite number is expected, not nan", lambda: sim.set("time.step", np.nan)),
                    (ValueError, "no column 'tip_zz'; there are tip_", lambda: sim.get("tip_zz")),
                    (ValueError, "takes what save returned", lambda: sim.restore(3)),
                    (ValueError, "not a field of nodes", lambda: sim.of_nodes("stress")),
                    (ValueError, "name of a surface is expected, not 5; there are back, bottom", lambda: sim.surface(5)),
                    (ValueError, "a key of the input is a text, .*not 3", lambda: sim.set(3, 1)),
                    (ValueError, "set takes a key and a value", lambda: sim.set("loads.0.gravity")),
                    (ValueError, "of real numbers is expected, not 'up'", lambda: right.apply_forces("up")),
                    (ValueError, r"\(4, 3\) of real numbers is expected, not \[\[1, 2\], \[3\]\]", lambda: right.move([[1, 2], [3]])),
                    (ValueError, "of real numbers", lambda: right.apply_forces(np.full((4, 3), 1j))),
                    (ValueError, "until, a time .s.: a finite number is expected, not nan", lambda: sim.run(until=np.nan)),
                    (ValueError, "output: the name is empty", lambda: pliant.Simulation(FALLING + BDF2, output="")),
                    (ValueError, "comm: a communicator of mpi4py is expected", lambda: pliant.Simulation(FALLING + BDF2, comm=3))):
                with self.assertRaisesRegex(error, expected):
                    call()
            with pliant.Simulation(FALLING + BDF2) as other, self.assertRaisesRegex(pliant.InputError, "another simulation"):
                other.restore(sim.save())
            self.assertEqual(os.listdir("."), ["bar.msh"])
            sim.run()
            with self.assertRaisesRegex(pliant.PliantError, "has reached its end, 0.06 s"):
                sim.advance()
        for call in (sim.advance, lambda: sim.time, lambda: right.displacement, sim.save, lambda: sim.set("loads.0.gravity", [0, 0, 0])):
            with self.assertRaisesRegex(pliant.PliantError, "is closed"):
                call()
        self.assertEqual(repr(sim), "Simulation(closed)")
        with self.assertRaisesRegex(pliant.InputError, "did you mean 'bodies'"):
            pliant.Simulation(FALLING.replace("bodies", "bodis") + BDF2)
        with self.assertRaisesRegex(pliant.InputError, "nothing.yaml"):
            pliant.Simulation("nothing.yaml")

    def test_a_failed_solve_leaves_the_last_good_state(self):
        text = BODY + "loads: [{surface: right, traction: [0, 0, 0]}]\ntime: {method: bdf2, step: 10 ms, end: 60 ms, min_step: 5 ms}\n"
        with pliant.Simulation(text) as sim, pliant.Simulation(text) as other:
            for one in (sim, other):
                one.set("loads.0.traction", [0, 0, 100])
                one.run(until=0.02)
                one.save()
            row, u = sim.row, sim.displacement
            sim.set("loads.0.traction.0", "-1e12")
            with self.assertRaisesRegex(pliant.SolveError, "the solve failed at t = 0.02: .*stays at this state") as raised:
                sim.advance()
            self.assertEqual(raised.exception.code, 3)
            self.assertEqual(sim.row, row)
            np.testing.assert_array_equal(sim.displacement, u)
            sim.set("loads.0.traction.0", 0)
            self.assertAlmostEqual(sim.next_dt, 0.01)
            for one in (sim, other):
                one.run()
            np.testing.assert_allclose(sim.displacement, other.displacement, rtol=0, atol=1e-9)

    def test_a_rank_that_ends_alone_ends_the_others(self):
        self.write("in.yaml", FALLING + BDF2)
        for opened in ("sim = pliant.Simulation('in.yaml')\nif True:", "with pliant.Simulation('in.yaml') as sim:"):
            with self.subTest(opened):
                done = self.python(f"import sys\nsys.path.insert(0, {str(ROOT / 'src/python')!r})\n"
                                   f"import pliant\nimport pliant.simulation\npliant.simulation.PATIENCE = 0.5\n{opened}\n"
                                   "    if sim.own_nodes.start > 0:\n        raise RuntimeError('a controller fails')\n    sim.run()\n", ranks=2, timeout=60)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn("a controller fails", done.stderr)

    def test_interrupt(self):
        """Ctrl-C is a KeyboardInterrupt after the step."""
        with pliant.Simulation(FALLING + BDF2) as sim:
            sim.advance()
            with self.assertRaises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
                sim.advance()
            sim.run()
            self.assertTrue(sim.done)


class TestOthers(SimulationTest):
    """Beside mpi4py and petsc4py, which start MPI and PETSc themselves, and h5py, which brings an HDF5 of its own."""

    def test_whoever_started_mpi(self):
        self.write("in.yaml", FALLING + BDF2)
        tips = set()
        for first in ("", "from mpi4py import MPI", "import petsc4py; petsc4py.init(); from petsc4py import PETSc"):
            second = "from mpi4py import MPI\ncomm = MPI.COMM_SELF" if first else "comm = None"
            with self.subTest(first=first):
                if first and importlib.util.find_spec(first.replace(";", " ").split()[1]) is None:
                    continue
                done = self.python(f"{first}\nimport sys\nsys.path.insert(0, {str(ROOT / 'src/python')!r})\nimport pliant\n{second}\n"
                                   "sim = pliant.Simulation('in.yaml', comm=comm)\nsim.run()\nprint('tip', repr(sim.get('tip_z')))\n")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                tips.add(re.search(r"tip (\S+)", done.stdout).group(1))
        self.assertEqual(len(tips), 1)


class TestPage(SimulationTest):
    def test_blocks(self):
        """The blocks of the page one after another, as a reader types them."""
        for folder in ("input", "meshes"):
            shutil.copytree(ROOT / folder, self.directory / folder)
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / "docs/coupling.md").read_text(), re.S)
        self.assertGreater(len(blocks), 4)
        printed, names = io.StringIO(), {}
        with contextlib.redirect_stdout(printed):
            for block in blocks:
                exec(compile(block, "docs/coupling.md", "exec"), names)
        self.assertGreater(len(printed.getvalue().splitlines()), 4)
        self.assertAlmostEqual(names["sim"].get("tip_uz"), names["target"], delta=1e-3, msg="the controller holds its target")
        halves, whole = (names[name].surface("right").displacement for name in ("second", "whole"))
        self.assertLess(abs(halves.mean(axis=0) - whole.mean(axis=0)).max(), 1e-6 * abs(whole).max())
        self.assertRegex(printed.getvalue(), r"reward -1\.\d+; \d+\.\d+ s of motion per second")


if __name__ == "__main__":
    unittest.main()
