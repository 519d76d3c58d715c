#!/usr/bin/python3
"""Constraints beyond prescribed displacements, as users type them: planes of symmetry, periodic surfaces, rigid parts,
equations; against the same problems solved otherwise."""
import re
import unittest

import numpy as np

from program import LONG, ProgramTest, box, swept, write_box, write_mesh

LAW = "elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}"


def turned(points):
    """By 0.7 rad about (1, 2, 2) / 3."""
    n = np.array([1, 2, 2]) / 3
    c, s = np.cos(0.7), np.sin(0.7)
    return points * c + np.cross(n, points) * s + np.outer(points @ n, n).reshape(points.shape) * (1 - c)


def mirrored(points, triangles, cells):
    """The box and its mirror image across its side x = 0."""
    image = np.arange(len(points)) + len(points)
    on_plane = np.abs(points[:, 0]) < 1e-12
    image[on_plane] = np.flatnonzero(on_plane)
    both = np.vstack([points, points * [-1, 1, 1]])
    cells = np.vstack([cells, image[cells][:, [0, 2, 1, 3]]])
    sides = [image[triangles[1]][:, [0, 2, 1]]] + [np.vstack([t, image[t][:, [0, 2, 1]]]) for t in triangles[1:]]
    sides[1] = triangles[1]
    used = np.unique(cells)
    number = np.full(len(both), -1)
    number[used] = np.arange(len(used))
    return both[used], [number[side] for side in sides], number[cells]


class Constraints(ProgramTest):
    def solve(self, mesh, constraints, *settings, ranks=1, more=""):
        """History of an input with these constraints, in one static step unless `settings` say otherwise."""
        lines = "".join(f"  - {c}\n" for c in constraints)
        time = "" if "time:" in more else "time: {method: static, load_steps: 2}\n"
        self.write("in.yaml", f"mesh: {{file: {mesh}}}\nbodies: [{{density: 1000, {LAW}}}]\n"
                              f"solver: {{newton: {{relative: 1e-11}}}}\nconstraints:\n{lines}{time}{more}")
        return self.run_input("in.yaml", *settings, ranks=ranks)

    def test_half_a_model_is_the_whole_one(self):
        # Pressed, sheared along the plane, and pulled; the plane lies at any angle in space.
        half = box((2, 3, 3), (0.5, 1, 1))
        whole = mirrored(*half)
        write_mesh(self.directory / "half.msh", turned(half[0]), *half[1:])
        write_mesh(self.directory / "whole.msh", turned(whole[0]), *whole[1:])
        down, tip = turned(np.array([[0.0, 0.1, -0.2]]))[0], turned(np.array([[0.5, 1.0, 0.6]]))[0]
        lid = f"{{surface: top, displacement: [{down[0]}, {down[1]}, {down[2]}]}}"
        held = "{surface: bottom, displacement: [0, 0, 0]}"
        probes = f"probes: [{{name: tip, point: [{tip[0]}, {tip[1]}, {tip[2]}]}}]\n"
        full = self.solve("whole.msh", [held, lid], more=probes)
        for ranks in swept((1, 2), (2,)):
            part = self.solve("half.msh", [held, lid, "{surface: left, symmetry: plane}"], more=probes, ranks=ranks)
            self.assertAlmostEqual(2 * part["elastic_energy"][-1] / full["elastic_energy"][-1], 1, delta=1e-9)
            self.assertGreater(np.abs(part["tip_x"][-1] - tip[0]), 1e-3)
            for column in ("tip_x", "tip_y", "tip_z"):
                self.assertAlmostEqual(part[column][-1], full[column][-1], delta=1e-9)
            # What the plane holds points along its normal, and with the held ends' reactions sums to nothing.
            normal = turned(np.array([[1.0, 0.0, 0.0]]))[0]
            force = np.array([part[f"left_f{i}"][-1] for i in "xyz"])
            self.assertGreater(abs(force @ normal), 100)
            self.assertLess(np.linalg.norm(force - (force @ normal) * normal), 1e-6 * abs(force @ normal))
            total = force + sum(np.array([part[f"{name}_f{i}"][-1] for i in "xyz"]) for name in ("top", "bottom"))
            self.assertLess(np.linalg.norm(total), 1e-6 * np.linalg.norm(force))

    def test_what_holds_every_node_is_warned_of(self):
        write_box(self.directory / "box.msh", (2, 1, 1))
        text = (f"mesh: {{file: box.msh}}\nbodies: [{{density: 1000, {LAW}}}]\nconstraints: [{{box: [[-1, -1, -1], [1, 20, 20]], displacement: [0, 0, 0]}}]\n"
                "loads: [{gravity: [0, 0, -1]}]\ntime: {method: static}\n")
        for ranks in (1, 2):
            self.write("in.yaml", text)
            self.assertRegex(self.pliant("check", "in.yaml", ranks=ranks).stderr, "in.yaml:3:15: .*this holds every node, so nothing moves; .*metres")
            self.write("in.yaml", text.replace("[1, 20", "[0.5, 20"))
            self.assertNotIn("every node", self.pliant("check", "in.yaml", ranks=ranks).stderr)

    def test_a_straight_plane_is_a_prescribed_component(self):
        write_box(self.directory / "cube.msh", (2, 2, 2))
        lid = "{surface: top, displacement: [free, free, 0.2]}"
        others = [lid, "{surface: left, displacement: [0, free, free]}", "{surface: front, displacement: [free, 0, free]}"]
        expected = self.solve("cube.msh", [*others, "{surface: bottom, displacement: [free, free, 0]}"])
        self.assert_same_history(self.solve("cube.msh", [*others, "{surface: bottom, symmetry: plane}"]), expected, 1e-12)
        symmetric = [f"{{surface: {side}, symmetry: plane}}" for side in ("left", "front", "bottom")]
        lifted = self.solve("cube.msh", ["{surface: top, normal_displacement: 0.2}", *symmetric])
        self.assert_same_history({name: lifted[name] for name in expected}, expected, 1e-9)

    def test_periodic_cell(self):
        # Simple shear of the cell: the force on the surface is the derivative of the energy, and the ranks agree.
        write_box(self.directory / "cube.msh", (3, 3, 3))
        corner = "{box: [[-1, -1, -1], [1e-6, 1e-6, 1e-6]], displacement: [0, 0, 0]}"
        cell = [corner, '{surface: right, periodic_with: left, difference: [0, "0.3*t", 0]}',
                "{surface: back, periodic_with: front}", "{surface: top, periodic_with: bottom, difference: [0, 0, free]}"]
        time = "time: {method: quasistatic, step: 0.1, end: 1}\n"
        history = self.solve("cube.msh", cell, more=time)
        energy, force = history["elastic_energy"], history["right_fy"]
        slope = (8 * (energy[6] - energy[4]) - (energy[7] - energy[3])) / (12 * 0.03)
        self.assertAlmostEqual(force[5] / slope, 1, delta=1e-4)
        self.assertLess(np.abs(history["top_fz"]).max(), 1e-6 * np.abs(force).max())
        self.assertLess(np.abs(history["energy_balance_error"]).max(), 1e-9 * energy[-1])
        self.assertIn("none holds x", self.call("run", self.write("free.yaml", (self.directory / "in.yaml").read_text().replace(f"  - {corner}\n", ""))).stderr)
        again = self.solve("cube.msh", cell, more=time, ranks=3)
        for column in ("elastic_energy", "right_fy", "support_work"):
            np.testing.assert_allclose(again[column], history[column], rtol=1e-8, atol=0)

    def test_a_clamp_has_a_root_moment(self):
        """About the middle of what it holds, where that is now: a clamp that is carried along bears the same."""
        write_box(self.directory / "bar.msh", (4, 2, 2), (0.4, 0.1, 0.1))
        weight = 1000 * 0.981 * 0.4 * 0.1 * 0.1
        for ranks in (1, 2):
            h = self.solve("bar.msh", ['{name: root, surface: left, displacement: [0, "3*t", 0]}'], ranks=ranks,
                           more="loads: [{gravity: [0, 0, -0.981]}]\ntime: {method: static, end: 1}\n")
            tip = h["root_ty"][-1] / (-weight * 0.2)  # bent, the bar weighs a little nearer
            self.assertTrue(0.995 < tip < 1.0, tip)
            self.assertLess(max(abs(h["root_tx"][-1]), abs(h["root_tz"][-1])), 0.01 * weight * 0.2)
            np.testing.assert_allclose(h["root_fz"][-1], weight, rtol=1e-6)

    def test_reactions_of_constraints_that_repeat_one_another(self):
        # Where the surfaces meet, one of the constraints is implied by the others: which one must not depend on the ranks.
        write_box(self.directory / "box.msh", (3, 4, 3), (1, 1, 1))
        constraints = ["{surface: left, displacement: [0, 0, 0], name: clamp}",
                       "{surface: right, displacement_along: 0, direction: [1, 1, 1], name: slope}",
                       "{surface: back, periodic_with: front, difference: [0, free, 0], name: cell}"]
        runs = [self.solve("box.msh", constraints, more="loads: [{gravity: [0, 3, -9.81]}]\n", ranks=ranks) for ranks in (1, 2, 3)]
        for name in ("clamp", "slope", "cell"):
            forces = np.array([[run[f"{name}_f{axis}"][-1] for axis in "xyz"] for run in runs])
            np.testing.assert_allclose(forces, np.broadcast_to(forces[0], forces.shape), atol=1e-7 * np.abs(forces).max())

    def test_turning_grip(self):
        # A bar turned by a grip that also moves: the torque is the derivative of the energy, the ledger closes.
        write_box(self.directory / "bar.msh", (6, 2, 2), (3, 1, 1), origin=(0, -0.5, -0.5))
        grip = ('{surface: right, rigid: {translation: [free, "0.1*t", 0], '
                'rotation: {axis: [2, 0, 0], angle: "2*t"}, center: [3, 0, 0]}}')
        ends = ["{surface: left, displacement: [0, 0, 0]}", grip]
        history = self.solve("bar.msh", ends, more="time: {method: quasistatic, step: 0.1, end: 1}\n")
        power = 2 * history["right_tx"] + 0.1 * history["right_fy"]
        energy = history["elastic_energy"]
        slope = (8 * (energy[6] - energy[4]) - (energy[7] - energy[3])) / (12 * 0.1)
        self.assertAlmostEqual(power[5] / slope, 1, delta=1e-4)
        self.assertLess(np.abs(history["right_fx"]).max(), 1e-6 * history["right_tx"].max())
        moving = self.solve("bar.msh", ends, more="time: {method: bdf2, step: 0.02, end: 0.2}\n")
        self.assertLess(np.abs(moving["energy_balance_error"]).max(), 1e-9 * moving["elastic_energy"][-1])
        self.assertGreater(moving["support_work"][-1], moving["elastic_energy"][-1])

    PIN = """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.03, 0.02};
Physical Volume("pin") = {1};
Physical Surface("end") = {2};
Mesh.MeshSizeMax = 0.013;
Mesh.ElementOrder = 2;
"""

    def test_the_center_of_a_rigid_part_is_its_centroid(self):
        """The mean of the nodes of an irregular mesh lies beside the axis."""
        self.write("pin.geo", self.PIN)
        text = """mesh: {file: pin.geo}
element: P2
bodies: [{volume: pin, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
constraints: [{PART, rigid: {rotation: {axis: [0, 0, 1], angle: 30 deg}, translation: [0, 0, 0]}}]
time: {method: static}
output: {fields: [displacement]}
"""
        for part, height, columns in (("volume: pin", 0.015, "pin"), ("surface: end", 0.03, "end"), ("where: z > 0.029", 0.03, "constraint1")):
            input_file = self.write("pin.yaml", text.replace("PART", part))
            for ranks in (1, 2):
                check = self.pliant("check", input_file, ranks=ranks).stdout
                center = [float(x) for x in re.search(r"rigid parts\n  .*, center \((.*)\) by default", check)[1].split(", ")]
                self.assertAlmostEqual(center[2], height, delta=1e-7)
                off = np.hypot(center[0], center[1])
                (self.assertLess if columns != "constraint1" else self.assertGreater)(off, 1e-6)
            self.assertIn(f"{columns}_tz", self.run_input(input_file))
        given_text = text.replace("PART", "volume: pin").replace("rigid: {", "rigid: {center: [1 mm, 0, 0], ")
        given = self.write("pin.yaml", given_text)
        self.assertRegex(self.pliant("check", given).stdout, r"volume 'pin': \d+ nodes, center \(0.001, 0, 0\)\n")
        free_text = given_text.replace(", angle: 30 deg}", ", angle: free}").replace("[0, 0, 0]}}", "[0, free, free]}}")
        free_text = free_text.replace("{volume: pin, elasticity", "{volume: pin, density: 1000, elasticity").replace("method: static", "method: bdf2, step: 1, end: 1")
        free = self.write("free.yaml", free_text)
        self.assertIn("moves freely along y, z, turns freely about (0, 0, 1)\n", self.pliant("check", free).stdout)
        self.pliant("check", given, "--html")
        self.assertIn("center: [0.001, 0, 0]", (self.directory / "pin.html").read_text())

    def test_names_of_groups_that_joints_have(self):
        """A joint's columns of forces are its own."""
        write_box(self.directory / "bar.msh", (2, 1, 1))
        history = self.run_input(self.write("bar.yaml", """mesh: {file: bar.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
rigid_bodies: [{name: ball, mass: 1, inertia: [1, 1, 1], center: [3, 0, 0]}]
constraints: [{volume: body, displacement: [0, 0, 0]}]
joints: [{name: body, type: slider, between: [ground, ball], point: [3, 0, 0], axis: [1, 0, 0]}]
loads: [{gravity: [0, -9.81, 0]}]
time: {method: bdf2, step: 1 ms, end: 2 ms}
"""))
        self.assertAlmostEqual(history["body_fy"][-1], 9.81, delta=1e-6)
        self.assertAlmostEqual(history["constraint1_fy"][-1], 9810, delta=1e-3)

    HINGE = "{surface: top, rigid: {translation: [0, 0, 0], rotation: {axis: [0, 1, 0], angle: free}, center: [0, 0, 1]}}"

    def test_body_hanging_at_a_hinge(self):
        # With gravity aslant it hangs as with gravity straight down, turned about the hinge.
        write_box(self.directory / "bar.msh", (2, 2, 5), (0.4, 0.4, 1), origin=(-0.2, -0.2, 0))
        tilt, g = 0.6, 200.0
        more = "probes: [{name: foot, point: [0, 0, 0]}]\nloads: [{gravity: [%r, 0, %r]}]\n"
        straight = self.solve("bar.msh", [self.HINGE], more=more % (0.0, -g))
        x, z = straight["foot_x"][-1], straight["foot_z"][-1] - 1
        self.assertLess(z, -1.001)
        weight = 0.16 * 1000 * g
        for ranks in swept((1, 2), (1,)):
            h = self.solve("bar.msh", [self.HINGE], more=more % (-g * np.sin(tilt), -g * np.cos(tilt)), ranks=ranks)
            self.assertAlmostEqual(h["elastic_energy"][-1] / straight["elastic_energy"][-1], 1, delta=1e-8)
            self.assertAlmostEqual(h["foot_x"][-1], x * np.cos(tilt) + z * np.sin(tilt), delta=1e-8)
            self.assertAlmostEqual(h["foot_z"][-1], 1 + z * np.cos(tilt) - x * np.sin(tilt), delta=1e-8)
            self.assertAlmostEqual(h["top_fx"][-1], weight * np.sin(tilt), delta=1e-6 * weight)
            self.assertAlmostEqual(h["top_fz"][-1], weight * np.cos(tilt), delta=1e-6 * weight)
            self.assertLess(abs(h["top_ty"][-1]), 1e-6 * weight)

    def test_pendulum(self):
        # A stiff bar swings at a hinge as a rigid body: I theta'' = -m g a sin(theta).
        write_box(self.directory / "bar.msh", (2, 2, 5), (0.2, 0.2, 1), origin=(-0.1, -0.1, 0))
        rate, step, end = 3.0, 0.01, 0.8
        more = (f"probes: [{{name: foot, point: [0, 0, 0]}}]\nloads: [{{gravity: [0, 0, -9.81]}}]\n"
                f"initial: {{velocity: ['{rate}*(z-1)', 0, '-{rate}*x']}}\n"
                f"time: {{method: implicit-midpoint, step: {step}, end: {end}}}\n")
        h = self.solve("bar.msh", [self.HINGE], "bodies.0.elasticity.youngs_modulus=1e9", more=more)
        # About the hinge, per mass: (length^2 / 3 + width^2 / 12), by steps of a twentieth.
        inertia, y, dt = 1 / 3 + 0.04 / 12, np.array([0.0, rate]), step / 20
        slope = lambda y: np.array([y[1], -9.81 * 0.5 / inertia * np.sin(y[0])])  # noqa: E731
        for _ in range(round(end / dt)):
            k1 = slope(y)
            k2 = slope(y + dt / 2 * k1)
            k3 = slope(y + dt / 2 * k2)
            y = y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + slope(y + dt * k3))
        self.assertLess(y[1], 0)  # on its way back
        self.assertAlmostEqual(np.arctan2(-h["foot_x"][-1], 1 - h["foot_z"][-1]), y[0], delta=2e-3)
        scale = h["kinetic_energy"].max()
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-8 * scale)
        self.assertLess(np.abs(h["support_work"]).max(), 1e-8 * scale)  # the hinge does none

    def test_flying_body_with_rigid_ends(self):
        write_box(self.directory / "bar.msh", (4, 2, 2), (1, 0.4, 0.3))
        more = ("initial: {velocity: ['1+2*y*y', '3*z', '-3*y+2*x*x']}\n"
                "time: {method: implicit-midpoint, step: 0.01, end: 0.3}\n")
        for ranks in swept((1, 2), (1,)):
            h = self.solve("bar.msh", ["{surface: left, rigid: {}}", "{surface: right, rigid: {}}"], more=more, ranks=ranks)
            scale = np.abs([h[c] for c in ("px", "py", "pz", "Lx", "Ly", "Lz")]).max()
            for column in ("px", "py", "pz", "Lx", "Ly", "Lz"):
                self.assertLess(np.ptp(h[column]), 1e-10 * scale, column)
            self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * h["kinetic_energy"][0])
            self.assertLess(np.abs(h["left_fx"]).max(), 1e-3 * h["kinetic_energy"][0])

    def test_equation(self):
        # The mean of a surface is moved; what moves it is a force spread evenly over its nodes, as another run shows.
        write_box(self.directory / "cube.msh", (2, 2, 2))
        held = "{surface: bottom, displacement: [0, 0, 0]}"
        history = self.solve("cube.msh", [held, "{equation: [{surface: top, component: z, coefficient: 2}], value: 0.4}"])
        self.assertGreater(history["constraint2_fz"][-1], 0)
        self.assertAlmostEqual(history["constraint2_fz"][-1], -history["bottom_fz"][-1],
                               delta=1e-8 * history["constraint2_fz"][-1])
        pair = self.solve("cube.msh", [held, "{surface: top, displacement: [free, free, 0.2]}"])
        self.assertLess(history["elastic_energy"][-1], pair["elastic_energy"][-1])

    def refused(self, constraints, words, mesh="cube.msh"):
        lines = "".join(f"  - {c}\n" for c in constraints)
        text = f"mesh: {{file: {mesh}}}\nbodies: [{{density: 1000, {LAW}}}]\ntime: {{step: 0.1, end: 1}}\nconstraints:\n{lines}"
        at = text.index("@")
        place = f"in.yaml:{text[:at].count(chr(10)) + 1}:{at - text[:at].rfind(chr(10))}:"
        self.write("in.yaml", text.replace("@", ""))
        done = self.call("run", "in.yaml", ranks=2 if LONG else 1)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.assertIn(place, done.stderr)
        self.assertRegex(done.stderr, words)

    def test_what_cannot_be_compressed(self):
        # Every kind of constraint with pressures as unknowns and gas around the body, on any number of ranks.
        write_box(self.directory / "cube.msh", (2, 2, 2))
        kinds = {
            "tied": ["{surface: left, displacement: [0, 0, 0]}",
                     '{surface: right, displacement_along: "0.05*t^2", direction: [1, 1, 0]}'],
            "periodic": ['{surface: back, periodic_with: front, difference: [0, "0.1*t^2", free]}'],
            "turned": ['{surface: left, rigid: {rotation: {axis: [0, 0, 1], angle: "t^2"}, translation: [0, 0, 0]}}'],
            "turning": ['{surface: left, rigid: {translation: ["0.1*t^2", 0, 0]}}'],
            "equation": ["{surface: left, displacement: [0, 0, 0]}",
                         '{equation: [{surface: right, component: z}], value: "0.05*t^2"}'],
            "insert": ["{box: [[-1, -1, -1], [0.6, 2, 2]], rigid: {translation: [0, 0, 0]}}"],
            "held inside": ["{box: [[-1, -1, -1], [0.6, 2, 2]], displacement: [0, 0, 0]}"]}
        more = ('loads: [{force_density: [0, 0, "-2e4*t*x"]}]\nelement: P2\nvolumetric: mixed\n'
                'cavities: [{name: gas, where: "x > -1", volume: 3, gas: {pressure: 1 kPa, ambient: 1 kPa}}]\n'
                "time: {method: dirk22, step: 10 ms, end: 40 ms}\n")
        for name, constraints in kinds.items():
            for nu in swept(("0.5", "0.49"), ("0.5",)):
                with self.subTest(name, nu=nu):
                    material = f"bodies.0.elasticity.poissons_ratio={nu}"
                    one = self.solve("cube.msh", constraints, material, more=more)
                    self.assertGreater(one["kinetic_energy"][-1], 1e-3)
                    self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-7 * one["kinetic_energy"].max())
                    for ranks in swept((2, 3), (2,) if name in ("periodic", "turning", "equation") else ()):
                        other = self.solve("cube.msh", constraints, material, "time.end=20 ms", more=more, ranks=ranks)
                        self.assert_same_history(other, {column: values[:3] for column, values in one.items()}, 1e-7)

    def test_a_step_that_fails_with_pressures(self):
        write_box(self.directory / "box.msh", (2, 2, 2), (0.1, 0.1, 0.1))
        self.write("in.yaml", """mesh: {file: box.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 3e5, poissons_ratio: 0.49}}]
volumetric: mixed
constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: right, displacement_along: 0.01, direction: [1, 2, 3]}]
loads: [{surface: right, traction: [-3e8, 1e8, 4e8]}]
time: {method: backward-euler, step: 0.1, end: 0.2, min_step: 0.05}
solver: {newton: {max_iterations: 10}}
""")
        for ranks in (1, 2):
            done = self.call("run", "in.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
            self.assertIn("Post-mortem", done.stderr)
            self.assertTrue((self.directory / "out/in/post-mortem/report.yaml").exists())

    def test_integrators_of_petsc(self):
        # The same motion as by a method of Pliant, and closer to it by the method's order as steps are halved.
        write_box(self.directory / "cube.msh", (1, 1, 1))
        kinds = {
            "tied": ["{surface: left, displacement: [0, 0, 0]}",
                     '{surface: right, displacement_along: "0.05*sin(20*t)^2", direction: [1, 1, 0]}'],
            "periodic": ['{surface: back, periodic_with: front, difference: [0, "5*t^2", free]}'],
            "turned": ['{surface: left, rigid: {rotation: {axis: [0, 0, 1], angle: "20*t^2"}, translation: [0, 0, 0]}}']}
        probes = "probes: [{name: tip, point: [1, 1, 1]}]\n"
        for name, constraints in swept(list(kinds.items()), list(kinds.items())[2:]):
            def end(method, step, ranks=1):
                more = f'loads: [{{force_density: [0, 0, "-1e7*t^3"]}}]\ntime: {{method: {method}, step: {step}, end: 0.1}}\n'
                history = self.solve("cube.msh", constraints, more=probes + more, ranks=ranks)
                return np.array([history[f"tip_{i}"][-1] for i in "xyz"])

            exact = end("dirk33", 0.1 / 320)
            for method, order in (("alpha2", 2), ("bdf", 2), ("arkimex", 3)):
                with self.subTest(name, method=method):
                    one, finer = (end(f"{{petsc: {method}}}", 0.1 / n) for n in (40, 80))
                    errors = [np.linalg.norm(found - exact) for found in (one, finer)]
                    self.assertGreater(np.log2(errors[0] / errors[1]), order - 0.3, errors)
                    self.assertLess(errors[1], 1e-3)
                    if LONG or method == "bdf":
                        ends = [end(f"{{petsc: {method}}}", 0.1 / 10, ranks) for ranks in (1, 2)]
                        np.testing.assert_allclose(*ends, rtol=1e-9)

    def test_bodies_that_can_turn_get_a_note(self):
        write_box(self.directory / "cube.msh", (2, 2, 2))
        base = f"mesh: {{file: cube.msh}}\nbodies: [{{density: 1000, {LAW}}}]\nconstraints:\n"

        def told(constraints, method="static", ranks=1):
            time = "{method: static}" if method == "static" else f"{{method: {method}, step: 0.1, end: 0.1}}"
            self.write("in.yaml", base + "".join(f"  - {c}\n" for c in constraints) + f"time: {time}\n")
            done = self.pliant("check", "in.yaml", ranks=ranks)
            return done.stdout + done.stderr

        edge, corner = "{where: x + z < 1e-9, displacement: [0, 0, 0]}", "{where: x + y + z < 1e-9, displacement: [0, 0, 0]}"
        line = r"the body free to rotate about the line through \(0, 0.5, 0\) m along \(0, 1, 0\)"
        for ranks in (1, 2):
            self.assertRegex(told([edge], ranks=ranks), line)
        self.assertRegex(told([corner, "{where: y > 0.9 && x + z < 1e-9, displacement: [0, free, 0]}"], "quasistatic"), line)
        self.assertIn("free to rotate about the point (0, 0, 0) m", told([corner]))
        slanted = "{where: abs(x - z) < 1e-9, displacement: [0, free, 0]}"
        planes = [f"{{surface: {side}, symmetry: plane}}" for side in ("left", "front", "bottom")]
        for held in ([edge, "{where: x + y > 1.9 && z < 0.1, displacement: [free, free, 0]}"], planes, [corner, slanted]):
            self.assertNotIn("free to rotate", told(held))
        self.assertNotIn("free to rotate", told([edge], "bdf2"))

    def test_mistakes_against_the_mesh(self):
        write_box(self.directory / "cube.msh", (2, 3, 2))
        bent = box((2, 3, 2))
        write_mesh(self.directory / "bent.msh", bent[0] + 0.1 * bent[0][:, [1, 2, 0]] ** 2, *bent[1:])
        self.refused(["{surface: @left, symmetry: plane}"], "surface 'left' is not plane", "bent.msh")
        self.refused(["{volume: @body, symmetry: plane}"], "volume 'body' has no normal")
        self.refused(["{surface: left, periodic_with: @front}"], "nodes? of surface 'left' and .* have no partner")
        self.refused(["{surface: left, periodic_with: @left}"], "surface 'left' cannot repeat itself")
        self.refused(["{surface: @lefd, symmetry: plane}"], "did you mean 'left'")
        self.refused(["@{surface: left, rigid: {translation: [0, 0, 0], center: [-1, 0, 0]}}"], "does not hold its `center`")
        self.refused(["@{box: [[0, 0, 0], [0.1, 0.1, 0.1]], rigid: {}}"], "has a single node")
        self.refused(["@{where: x + y < 1e-6, rigid: {translation: [0, 0, 0]}}"], "lies on one line")
        self.refused(["@{surface: left, rigid: {}}", "{surface: top, displacement: [0, free, free]}"],
                     "surface 'left' turns freely, .* surface 'top'")
        self.refused(["@{surface: left, rigid: {}}", "{surface: top, rigid: {}}"],
                     "turns freely")
        self.refused(["{surface: left, displacement: [0, 0, 0]}", "{surface: right, displacement: [0.1, 0, 0]}",
                      "@{surface: right, periodic_with: left}"], "surface 'right' .*contradict")
        self.refused(["{surface: left, displacement: [0, 0, 0]}",
                      "@{surface: left, rigid: {rotation: {axis: [1, 0, 0], angle: t}}}"], "surface 'left' .*contradict")


if __name__ == "__main__":
    unittest.main()
