#!/usr/bin/python3
"""Rigid bodies with a shape of their own, points of reference on soft bodies, forces and torques on both."""
import unittest

import numpy as np

from program import ProgramTest, write_box, write_cube


class RigidBodies(ProgramTest):
    def refused(self, text, *messages):
        self.write("in.yaml", text)
        for ranks in (1, 2):
            done = self.call("run", "in.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            for message in messages:
                self.assertIn(message, done.stderr)

    def test_shapes_do_not_change_masses(self):
        # The mass, its centre and the moments of inertia are those that are given, whatever the shape is.
        write_cube(self.directory / "cube.stl", (0, 0, 0), (100, 100, 50))
        text = """rigid_bodies:
  - {name: cube, mass: 3, inertia: [0.02, 0.03, 0.04], center: [0.03, 0.06, 0.02], velocity: [0.1, 0, 0], angular_velocity: [2, 3, 4]SURFACE}
loads: [{gravity: [0, 0, -9.81]}]
"""
        time = "method: dirk33, step: 2 ms, end: 0.1"
        shape = ", surface: {file: cube.stl, scale: 0.001, size: 0.06}"
        without = self.solve(text.replace("SURFACE", ""), time)
        for element in ("P1", "P2"):
            for ranks in (1, 2):
                one = self.solve(text.replace("SURFACE", shape) + f"element: {element}\n", time, ranks)
                np.testing.assert_allclose(one["cube_z"], 0.02 - 0.5 * 9.81 * one["time"] ** 2, atol=1e-12)
                for column in ("cube_qw", "cube_qx", "cube_qy", "cube_qz", "cube_wx", "kinetic_energy"):
                    np.testing.assert_allclose(one[column], without[column], rtol=1e-7, atol=1e-8, err_msg=column)

    def test_a_shape_rests_on_a_soft_body(self):
        write_cube(self.directory / "cube.stl", (0.2, 0.2, 1.001), (0.8, 0.8, 1.4))
        write_box(self.directory / "box.msh", (3, 3, 2))
        text = """mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: cube, mass: 100, inertia: [1, 1, 1], center: [0.5, 0.5, 1.2], surface: {file: cube.stl}}
constraints:
  - {surface: bottom, displacement: [0, 0, 0]}
  - {volume: cube, rigid: {translation: [0, 0, free]}}
contact: {law: barrier, pairs: all}
loads: [{gravity: [0, 0, -9.81], volume: cube}]
"""
        one, two = [self.solve(text, "method: static, load_steps: 2", ranks) for ranks in (1, 2)]
        np.testing.assert_allclose(one["bottom_fz"][-1], 100 * 9.81, rtol=1e-6)
        self.assertLess(one["cube_z"][-1], 1.2 - 0.008)
        np.testing.assert_allclose(two["cube_z"][-1], one["cube_z"][-1], atol=1e-7)

    def test_a_shape_does_not_touch_what_is_attached_to_it(self):
        # The shape lies on the surface that it holds. Its weight goes through that, and not through contact.
        write_cube(self.directory / "cube.stl", (0.2, 0.2, 1.0), (0.8, 0.8, 1.4))
        write_box(self.directory / "box.msh", (3, 3, 2))
        text = """mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: cube, mass: 100, inertia: [1, 1, 1], center: [0.5, 0.5, 1.2], surface: {file: cube.stl}, attached: [top]}
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
"""
        time = "method: bdf2, step: 5 ms, end: 0.1"
        alone, touching = self.solve(text, time), self.solve(text + "contact: {law: barrier, pairs: all}\n", time)
        self.assertEqual(np.nanmax(touching["contact_points"]), 0)
        np.testing.assert_allclose(touching["cube_z"], alone["cube_z"], atol=1e-8)
        self.assertLess(alone["cube_z"][-1], 1.2 - 0.01)

    def test_a_point_of_reference_bends_a_beam(self):
        # A moment at the end of a beam: it turns by M L / (E I), whatever the material point of the torque is.
        write_box(self.directory / "beam.msh", (16, 2, 2), (0.1, 0.01, 0.01))
        text = """mesh: {file: beam.msh}
element: P2
bodies: [{density: 1000, elasticity: {model: fixed-corotated, youngs_modulus: 1 MPa, poissons_ratio: 0}}]
rigid_bodies: [{name: hub, center: [0.12, 0.005, 0.005], attached: [right]}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
"""
        moment, EI = 4e-3, 1e6 * 0.01**4 / 12
        angle = moment * 0.1 / EI
        turned = text + f"loads: [{{torque: [0, {moment}, 0], volume: hub}}]\n"
        one, two = [self.solve(turned, "method: static, load_steps: 4", ranks) for ranks in (1, 2)]
        np.testing.assert_allclose(2 * np.arctan2(one["hub_qy"][-1], one["hub_qw"][-1]), angle, rtol=0.005)
        np.testing.assert_allclose(two["hub_qy"], one["hub_qy"], rtol=1e-7, atol=1e-12)
        # A force at the point acts with its arm: M = F (0.12 - x).
        force = 1e-3
        bent = self.solve(text + f"loads: [{{force: [0, 0, {-force}], volume: hub}}]\n", "method: static")
        deflection = force / EI * (0.12**3 / 3 - 0.02**3 / 3)  # the last 2 cm are rigid
        np.testing.assert_allclose(0.005 - bent["hub_z"][-1], deflection, rtol=0.01)

    def test_a_joint_at_a_point_of_reference(self):
        # A soft bar hangs on a hinge through a point of reference: it swings as the rigid bar does.
        write_box(self.directory / "bar.msh", (6, 1, 1), (0.3, 0.05, 0.05))
        text = """mesh: {file: bar.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 MPa, poissons_ratio: 0.3}}]
rigid_bodies: [{name: hub, center: [-0.02, 0.025, 0.025], attached: [left]}]
joints: [{name: pivot, type: hinge, between: [ground, hub], point: [-0.02, 0.025, 0.025], axis: [0, 1, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
"""
        time = "method: bdf2, step: 1 ms, end: 0.1"
        one, two = [self.solve(text, time, ranks) for ranks in (1, 2)]
        arm, inertia = 0.17, (0.3**2 + 0.05**2) / 12 + 0.17**2
        rate = 9.81 * arm / inertia * 0.1
        np.testing.assert_allclose(one["pivot_rate"][-1], rate, rtol=0.03)
        np.testing.assert_allclose(two["pivot_angle"], one["pivot_angle"], atol=1e-9)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-9 * one["kinetic_energy"].max())

    def test_forces_and_torques_move_rigid_bodies(self):
        write_box(self.directory / "box.msh", (2, 2, 2), (0.1, 0.1, 0.1))
        meshed = """mesh: {file: box.msh}
bodies: [{volume: body, density: 1000, rigid: true}]
"""
        given = """rigid_bodies: [{name: body, mass: 1, inertia: [0.0016666666666666668, 0.0016666666666666668, 0.0016666666666666668], center: [0.05, 0.05, 0.05]}]
"""
        loads = 'loads: [{force: ["3*t", 0, 0], volume: body}, {torque: [0, 0, 0.01], volume: body}]\n'
        for text, ranks in ((meshed, 1), (given, 1), (given, 2)):
            h = self.solve(text + loads, "method: dirk33, step: 5 ms, end: 0.2", ranks)
            t = h["time"]
            np.testing.assert_allclose(h["body_x"], 0.05 + 0.5 * t**3, atol=1e-9)
            np.testing.assert_allclose(h["body_wz"], 0.01 / (1 / 600) * t, rtol=1e-5, atol=1e-12)
            work = h["kinetic_energy"]
            np.testing.assert_allclose(h["load_work"], work, atol=1e-4 * work[-1])

    def test_mistakes(self):
        body = "rigid_bodies: [{name: top, BODY}]\ntime: {method: bdf2, step: 1 ms, end: 1}\n"
        self.refused(body.replace("BODY", "center: [0, 0, 0]"), "rigid body 'top' has no mass", "in.yaml:1")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], surface: {file: none.stl}"), "none.stl", "does not exist")
        (self.directory / "open.stl").write_text("solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], surface: {file: open.stl}"), "open.stl", "closed")
        self.refused("loads: [{torque: [0, 0, 1], volume: tip}]\n" + body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1]"), "is not a rigid body", "top")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], attached: [end]"), "end")


if __name__ == "__main__":
    unittest.main()
