#!/usr/bin/python3
"""Rigid bodies with a shape of their own, points of reference on soft bodies, rigid ones and those in the mean, forces and torques."""
import unittest

import numpy as np

from program import (ALL_OR_SOME, ROOT, ProgramTest, box, finish, read_history, start, swept, write_box, write_cube,
                     write_mesh)


class RigidBodies(ProgramTest):
    def refused(self, text, *messages):
        self.write("in.yaml", text)
        for ranks in swept((1, 2), (1,)):
            done = self.call("run", "in.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            for message in messages:
                self.assertIn(message, done.stderr)

    def test_an_angular_velocity_takes_the_place_of_the_turning_of_the_field(self):
        text = """rigid_bodies: [{name: hub, mass: 1, inertia: [1, 1, 1], center: [0.5, 0, 0]ANGULAR}]
initial: {velocity: ["-12*y", "12*x", 0]}
"""
        for angular, expected in (("", 12), (", angular_velocity: [0, 0, 5]", 5)):
            h = self.solve(text.replace("ANGULAR", angular), "method: bdf2, step: 1 ms, end: 1 ms")
            self.assertAlmostEqual(h["hub_wz"][0], expected, places=12)
            self.assertAlmostEqual(h["hub_vy"][0], 6, places=12)

    def test_a_force_on_a_body_with_curved_sides_acts_at_its_center(self):
        self.write("half.geo", """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.05, 0.02, Pi};
Physical Volume("half") = {1};
Mesh.MeshSizeMax = 0.02;
Mesh.ElementOrder = 2;
""")
        file = self.write("half.yaml", """
mesh: {file: half.geo}
bodies: [{volume: half, density: 7800, rigid: true}]
element: P2
loads: [{force: [10, 0, 0], volume: half}]
time: {method: dirk33, step: 1 ms, end: 10 ms}
""")
        h = self.run_input(file)
        mass = 7800 * 0.5 * np.pi * 0.02**2 * 0.05
        self.assertAlmostEqual(h["half_y"][0], 4 * 0.02 / (3 * np.pi), delta=1e-4 * 0.02)
        self.assertAlmostEqual(h["half_vx"][-1] * mass / 0.1, 1, delta=1e-3)
        self.assertLess(abs(h["half_wz"][-1]), 1e-6)
        self.assertRegex(self.call("check", file).stdout, f"half: .* mass {mass:.3f}")

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
        cases = (("P1", 1), ("P2", 1), ("P1", 2), ("P2", 2))
        for element, ranks in swept(cases, cases[:2]):
            one = self.solve(text.replace("SURFACE", shape) + f"element: {element}\n", time, ranks)
            np.testing.assert_allclose(one["cube_z"], 0.02 - 0.5 * 9.81 * one["time"] ** 2, atol=1e-12)
            for column in ("cube_qw", "cube_qx", "cube_qy", "cube_qz", "cube_wx", "kinetic_energy"):
                np.testing.assert_allclose(one[column], without[column], rtol=1e-7, atol=1e-8, err_msg=column)

    def test_flies_straight_without_forces(self):
        # All forces of a stage are rounding errors.
        write_box(self.directory / "box.msh", (2, 2, 2))
        text = """mesh: {file: box.msh}
bodies: [{density: 1000, rigid: true}]
initial: {velocity: [0.3, 0, -1]}
"""
        methods = ("dirk33", "backward-euler", "dirk22", "bdf2", "dirk23", "bdf3", "implicit-midpoint", "symplectic-dirk22")
        for method in swept(methods, methods[:3]):
            one = self.solve(text, f"method: {method}, step: 1 ms, end: 50 ms")
            self.assertLess(max(one["newton_iterations"]), 10, method)
            np.testing.assert_allclose(one["pz"], -1000, rtol=1e-9, err_msg=method)

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
        one, *others = [self.solve(text, "method: static, load_steps: 2", ranks) for ranks in swept((1, 2), (1,))]
        np.testing.assert_allclose(one["bottom_fz"][-1], 100 * 9.81, rtol=1e-6)
        self.assertLess(one["cube_z"][-1], 1.2 - 0.008)
        for other in others:
            np.testing.assert_allclose(other["cube_z"][-1], one["cube_z"][-1], atol=1e-7)

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

    def test_the_start_moves_all_bodies(self):
        # Shifted and thrown as a whole, with a rigid body that it holds and one that it touches: nothing is strained.
        write_box(self.directory / "box.msh", (1, 1, 1))
        write_cube(self.directory / "lid.stl", (0, 0, 1.05), (1, 1, 1.2))
        h = self.solve("""mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: held, mass: 1, inertia: [1, 1, 1], center: [0.5, 0.5, -0.5], attached: [bottom]}
  - {name: lid, mass: 1, inertia: [1, 1, 1], center: [0.5, 0.5, 1.1], surface: {file: lid.stl}}
contact: {law: barrier, pairs: all, width: 0.01}
initial: {displacement: [2, 1, 3], velocity: [1, 0, 0]}
""", "method: bdf2, step: 1 ms, end: 3 ms")
        self.assertLess(h["elastic_energy"].max(), 1e-15)
        for name, z in (("held", 2.5), ("lid", 4.1)):
            np.testing.assert_allclose([h[f"{name}_{k}"][0] for k in "xyz"], [2.5, 1.5, z], atol=1e-12)
            np.testing.assert_allclose(h[f"{name}_vx"], 1, atol=1e-9)

    def test_parts_that_fit_exactly_are_attached(self):
        # Nodes that coincide are those of both parts, as in a mesh of gmsh without BooleanFragments.
        self.write("stack.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {0, 0, 1, 1, 1, 0.5};
Physical Volume("soft") = {1};
Physical Volume("palm") = {2};
Physical Surface("bottom") = {5};
Physical Surface("top") = {6};
Mesh.MeshSizeMin = 0.6;
Mesh.MeshSizeMax = 0.6;
""")
        h = self.solve("""mesh: {file: stack.geo}
bodies:
  - {volume: soft, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}
  - {volume: palm, density: 2000, rigid: true, attached: [top]}
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
""", "method: static")
        np.testing.assert_allclose(h["bottom_fz"][-1], 2000 * 9.81, rtol=1e-6)

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
        one, *others = [self.solve(turned, "method: static, load_steps: 4", ranks) for ranks in swept((1, 2), (1,))]
        np.testing.assert_allclose(2 * np.arctan2(one["hub_qy"][-1], one["hub_qw"][-1]), angle, rtol=0.005)
        for other in others:
            np.testing.assert_allclose(other["hub_qy"], one["hub_qy"], rtol=1e-7, atol=1e-12)
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
        one, *others = [self.solve(text, time, ranks) for ranks in swept((1, 2), (1,))]
        arm, inertia = 0.17, (0.3**2 + 0.05**2) / 12 + 0.17**2
        rate = 9.81 * arm / inertia * 0.1
        np.testing.assert_allclose(one["pivot_rate"][-1], rate, rtol=0.03)
        for other in others:
            np.testing.assert_allclose(other["pivot_angle"], one["pivot_angle"], atol=1e-9)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-9 * one["kinetic_energy"].max())

    def test_damping_of_a_soft_body_is_not_that_of_a_mass(self):
        write_box(self.directory / "box.msh", (2, 1, 1))
        self.write("in.yaml", """mesh: {file: box.msh}
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}, viscosity: {model: mass-proportional, decay_rate: 5}}
rigid_bodies: [{name: bob, mass: 0.3, inertia: [1e-3, 1e-3, 1e-3], center: [3, 0, 0]}]
rods: [{name: wire, points: [[4, 0, 0], [5, 0, 0]], segments: 2, radius: 10 mm, density: 1000, youngs_modulus: 10 MPa, poissons_ratio: 0.3}]
loads: [{gravity: [0, 0, -10]}]
probes: [{name: middle, point: [4.5, 0, 0]}, {name: box, point: [1, 0, 0]}]
time: {method: dirk33, step: 10 ms, end: 0.1}
""")
        memory = {"GLIBC_TUNABLES": "glibc.malloc.tcache_count=0"}
        for filling in ("1", "85", "254"):  # what glibc leaves in memory that is not initialised
            done = finish(start(("run", "in.yaml", "--output", "out"), self.directory, environment=memory | {"MALLOC_PERTURB_": filling}), 100)
            self.assertEqual(done.returncode, 0, done.stderr)
            h = read_history(self.directory / "out")
            for falling in ("bob_vz", "middle_vz"):
                self.assertAlmostEqual(h[falling][-1], -1.0, delta=1e-7, msg=falling)
            self.assertAlmostEqual(h["box_vz"][-1], -2 * (1 - np.exp(-0.5)), delta=1e-5)

    def test_forces_and_torques_move_rigid_bodies(self):
        write_box(self.directory / "box.msh", (2, 2, 2), (0.1, 0.1, 0.1))
        meshed = """mesh: {file: box.msh}
bodies: [{volume: body, density: 1000, rigid: true}]
"""
        given = """rigid_bodies: [{name: body, mass: 1, inertia: [0.0016666666666666668, 0.0016666666666666668, 0.0016666666666666668], center: [0.05, 0.05, 0.05]}]
"""
        loads = 'loads: [{force: ["3*t", 0, 0], volume: body}, {torque: [0, 0, 0.01], volume: body}]\n'
        cases = ((meshed, 1), (given, 1), (given, 2))
        for text, ranks in swept(cases, cases[:2]):
            h = self.solve(text + loads, "method: dirk33, step: 5 ms, end: 0.2", ranks)
            t = h["time"]
            np.testing.assert_allclose(h["body_x"], 0.05 + 0.5 * t**3, atol=1e-9)
            np.testing.assert_allclose(h["body_wz"], 0.01 / (1 / 600) * t, rtol=1e-5, atol=1e-12)
            work = h["kinetic_energy"]
            np.testing.assert_allclose(h["load_work"], work, atol=1e-4 * work[-1])

    def test_the_place_nearest_to_a_probe_is_on_a_mesh(self):
        """Not in the tetrahedron that stands for a body of which only its inertia is known."""
        write_box(self.directory / "bar.msh", (2, 1, 1), (0.2, 0.1, 0.1))
        text = f"""mesh: {{file: bar.msh}}
bodies: [{{volume: body, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}}}]
rigid_bodies: [{{name: jaw, mass: 1, inertia: [0.1, 0.1, 0.1], center: [1, 0, 0], attached: [right]}}]
probes: [{{name: tip, point: [3, 0.1, 0.1]}}]
time: {{method: bdf2, step: 1 ms, end: 1 ms}}
"""
        self.refused(text, "probe 'tip' lies outside the mesh, 2.8 m from its nearest point (0.2, 0.1, 0.1)")
        soft = text.replace("[3, 0.1, 0.1]", "[0.2, 0.1, 0.1]")
        self.refused(soft + "loads: [{force: [1, 0, 0], volume: body}]\n", "in.yaml:6:36: volume 'body' is not a rigid body, and only those take a force or torque as a "
                     "whole; on a soft body: 'force' on a 'surface', 'curve' or 'point' of it, or 'force_density' [N/m^3] on the volume; rigid bodies are: jaw")
        self.refused(soft + "loads: [{torque: [1, 0, 0], volume: body}]\n", "'coupled'")
        self.refused(soft + "loads: [{torque: [1, 0, 0], volume: jwa}]\n", "(did you mean 'jaw'?); rigid bodies are: jaw")

    def test_mistakes(self):
        body = "rigid_bodies: [{name: top, BODY}]\ntime: {method: bdf2, step: 1 ms, end: 1}\n"
        self.refused(body.replace("BODY", "center: [0, 0, 0]"), "rigid body 'top' has no mass", "in.yaml:1")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], surface: {file: none.stl}"), "none.stl", "does not exist")
        (self.directory / "open.stl").write_text("solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], surface: {file: open.stl}"), "open.stl", "closed")
        self.refused("loads: [{torque: [0, 0, 1], volume: tip}]\n" + body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1]"), "is not a rigid body", "top")
        self.refused(body.replace("BODY", "mass: 1, center: [0, 0, 0], inertia: [1, 1, 1], attached: [end]"), "end")
        meshed = f"mesh: {{file: {ROOT}/meshes/unit_cube.msh}}\nbodies: [{{volume: beam, density: 1000, rigid: true}}]\ntime: {{method: bdf2, step: 1 ms, end: 1}}\n"
        self.refused(meshed + "constraints: [{volume: beam, displacement: [0, 0, 0]}]\n", "in.yaml:4:15: volume 'beam' is a rigid body: hold or move")
        self.write("in.yaml", meshed.replace("beam", "palm"))
        self.assertEqual(self.pliant("run", "in.yaml", status=2).stderr.count("no volume 'palm' in the mesh"), 1)

BAR = """mesh: {file: bar.msh}
element: P2
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
"""
LENGTH, WIDTH, E = 0.4, 0.04, 1e6
EI = E * WIDTH**4 / 12
SYMMETRY = """  - {surface: left, displacement: [0, free, free]}
  - {surface: bottom, displacement: [free, free, 0]}
  - {surface: front, displacement: [free, 0, free]}
"""


def hub(more="", x=LENGTH, held="coupled: [right]"):
    return f"rigid_bodies: [{{name: hub, center: [{x}, {WIDTH / 2}, {WIDTH / 2}], {held}{more}}}]\n"


class CoupledSurfaces(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (8, 2, 2), (LENGTH, WIDTH, WIDTH))

    def test_a_face_is_free_to_contract(self):
        # Uniaxial tension: the bar that a uniform traction pulls, which a rigid face does not allow.
        force = 0.2 * E * WIDTH**2
        probes = "probes:\n" + "".join(
            f"  - {{name: {name}, point: [{x}, {y * WIDTH}, {y * WIDTH}]}}\n"
            for name, x, y in (("corner", LENGTH, 1), ("middle", LENGTH, 0.5), ("inside", LENGTH / 2, 1)))
        held = BAR + probes + "constraints:\n" + SYMMETRY
        expected = self.solve(held + f"loads: [{{surface: right, traction: [{force / WIDTH**2}, 0, 0]}}]\n", "method: static")
        through_hub = f"loads: [{{force: [{force}, 0, 0], volume: hub}}]\n"
        for ranks in swept((1, 2, 3), (1,)):
            h = self.solve(held + through_hub + hub(), "method: static", ranks)
            for column in (f"{probe}_{axis}" for probe in ("corner", "middle", "inside") for axis in "xyz"):
                self.assertLess(abs(h[column][-1] - expected[column][-1]), 1e-9 * LENGTH, column)
            np.testing.assert_allclose(h["left_fx"][-1], -force, rtol=1e-9)
            np.testing.assert_allclose(h["elastic_energy"][-1], expected["elastic_energy"][-1], rtol=2e-4)  # and the coupling's
            np.testing.assert_allclose(h["hub_x"][-1], expected["middle_x"][-1], atol=1e-4 * LENGTH)
        guided = "constraints:\n  - {surface: left, displacement: [0, free, free]}\n  - {volume: hub, rigid: {translation: [free, 0, 0], rotation: fixed}}\n"
        rigid = self.solve(BAR + probes + guided + through_hub + hub(held="attached: [right]"), "method: static")
        self.assertLess(rigid["hub_x"][-1], expected["middle_x"][-1] - 1e-3 * LENGTH)
        self.assertGreater(rigid["corner_y"][-1], expected["corner_y"][-1] + 0.05 * WIDTH)

    def test_a_body_with_a_mesh_follows_a_face_as_one_without(self):
        points, sides, cells = box((4, 1, 1), (LENGTH, WIDTH, WIDTH))
        beside, _, of_cap = box((2, 2, 2), (WIDTH, WIDTH, WIDTH), origin=(LENGTH + 0.01, 0, 0))
        write_mesh(self.directory / "two.msh", np.vstack([points, beside]), sides, np.vstack([cells, of_cap + len(points)]),
                   (["bar", "cap"], np.repeat([0, 1], [len(cells), len(of_cap)])))
        write_box(self.directory / "bar.msh", (4, 1, 1), (LENGTH, WIDTH, WIDTH))
        more = f"""constraints: [{{surface: left, displacement: [0, 0, 0]}}]
probes: [{{name: end, point: [{LENGTH}, 0, 0]}}]
loads: [{{force: [0, 0.01, 0.02], volume: NAME}}, {{torque: [0.02, 0, 0], volume: NAME}}]
"""
        without = BAR + hub(x=LENGTH + 0.01 + WIDTH / 2) + more.replace("NAME", "hub")
        meshed = BAR.replace("bar.msh", "two.msh").replace("[{density", "[{volume: bar, density").replace(
            "0.3}}]", "0.3}}, {volume: cap, density: 1000, rigid: true, coupled: [right]}]") + more.replace("NAME", "cap")
        expected = self.solve(without, "method: static")
        for ranks in swept((1, 2), (1,)):
            h = self.solve(meshed, "method: static", ranks)
            for axis in "xyz":
                np.testing.assert_allclose(h[f"end_{axis}"], expected[f"end_{axis}"], atol=1e-8 * LENGTH)
                np.testing.assert_allclose(h[f"cap_{axis}"], expected[f"hub_{axis}"], atol=1e-8 * LENGTH)
        self.assertGreater(h["end_z"][-1], 1e-3 * LENGTH)

    def test_torques_and_forces_act_as_on_a_beam(self):
        # A moment M turns the end by M L / (E I); a force acts with its arm beyond the end, and shears.
        text = BAR + "constraints: [{surface: left, displacement: [0, 0, 0]}]\n"
        moment, force, beyond = 0.25, 0.01, 0.05
        for nu, error in swept(((0, 2e-3), (0.3, 0.02)), ((0, 2e-3),)):  # the clamp keeps the bar from contracting
            bar = text.replace("poissons_ratio: 0.3", f"poissons_ratio: {nu}")
            turned = self.solve(bar + hub() + f"loads: [{{torque: [0, {moment}, 0], volume: hub}}]\n", "method: static, load_steps: 2")
            angle = 2 * np.arctan2(turned["hub_qy"][-1], turned["hub_qw"][-1])
            np.testing.assert_allclose(angle, moment * LENGTH / EI, rtol=error)
            bent = self.solve(bar + hub(x=LENGTH + beyond) + f"loads: [{{force: [0, 0, {-force}], volume: hub}}]\n", "method: static")
            shear = 1.2 * force * LENGTH / (E / (2 + 2 * nu) * WIDTH**2)
            deflection = force / EI * ((LENGTH + beyond) ** 3 - beyond**3) / 3 + shear
            np.testing.assert_allclose(WIDTH / 2 - bent["hub_z"][-1], deflection, rtol=error)
            # What holds the bar at the other end is what acts on the point: force and moment.
            np.testing.assert_allclose(bent["left_fz"][-1], force, rtol=1e-8)

    def test_a_mass_at_the_point_vibrates(self):
        # A bar with its own mass at its end: b L tan(b L) = 1, period 2 pi / (b sqrt(E / rho)); started in this mode.
        mass, v = 1000 * LENGTH * WIDTH**2, 0.01
        b = 0.8603335890193797 / LENGTH
        period = 2 * np.pi / (b * np.sqrt(E / 1000))
        J = mass * WIDTH**2 / 6
        text = BAR + "constraints:\n" + SYMMETRY + f"initial: {{velocity: ['{v}*sin({b}*x)', 0, 0]}}\n"
        text += hub(f", mass: {mass}, inertia: [{J}, {J}, {J}], velocity: [{v * np.sin(b * LENGTH)}, 0, 0]")
        h = self.solve(text, f"method: dirk33, step: {period / 64}, end: {1.03 * period}")
        moved, t = h["hub_x"] - LENGTH, h["time"]
        crossings = [n for n in range(1, len(t) - 1) if moved[n] * moved[n + 1] < 0]
        self.assertEqual(len(crossings), 2)
        n = crossings[1]
        found = t[n] + (t[n + 1] - t[n]) * moved[n] / (moved[n] - moved[n + 1])
        np.testing.assert_allclose(found, period, rtol=2e-3)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * h["kinetic_energy"].max())

    def test_a_motor_at_the_point(self):
        # A hinge holds the end, a motor turns it: 4 E I / L (with shear) of the bar against the stiffness of the motor.
        motor = "{target: TARGET, stiffness: 2, damping: 0.05}"
        text = BAR + "constraints: [{surface: left, displacement: [0, 0, 0]}]\n" + hub()
        text += (f"joints: [{{name: pivot, type: hinge, between: [ground, hub], point: [{LENGTH}, {WIDTH / 2}, {WIDTH / 2}],"
                 f" axis: [0, 1, 0], motor: {motor}}}]\n")
        shear = 12 * EI / (E / 2.6 / 1.2 * WIDTH**2 * LENGTH**2)
        stiffness = 4 * EI / LENGTH * (1 + shear / 4) / (1 + shear)
        h = self.solve(text.replace("TARGET", "0.05"), "method: static")
        np.testing.assert_allclose(h["pivot_angle"][-1], 0.05 * 2 / (2 + stiffness), rtol=0.02)
        np.testing.assert_allclose(h["pivot_fz"][-1], -h["left_fz"][-1], rtol=1e-6)
        moving = text.replace("TARGET", "'0.5*min(t/0.02, 1)'")
        one, *others = [self.solve(moving, "method: bdf2, step: 2 ms, end: 0.04", ranks) for ranks in swept((1, 2, 3), (1,))]
        self.assertGreater(one["pivot_angle"][-1], 0.05)
        self.assertLess(np.abs(one["energy_balance_error"]).max(), 1e-7 * one["kinetic_energy"].max())
        for other in others:
            np.testing.assert_allclose(other["pivot_angle"], one["pivot_angle"], atol=1e-8)
            np.testing.assert_allclose(other["elastic_energy"], one["elastic_energy"], rtol=1e-6, atol=1e-9)

    def thrown(self):
        inertia = "inertia: [1e-4, 2e-4, 1e-4]"
        text = BAR.replace("P2", "P1") + "initial: {velocity: ['-2*(y-0.02)+0.3', '2*x', 0.1]}\n"
        return text + hub(f", mass: 0.3, {inertia}, velocity: [0.3, {2 * (LENGTH + 0.1)}, 0.1], angular_velocity: [0, 0, 2]",
                          x=LENGTH + 0.1)

    def test_momenta_are_conserved(self):
        one, *others = [self.solve(self.thrown(), "method: implicit-midpoint, step: 2 ms, end: 0.1", ranks) for ranks in swept((1, 3, 2), (1, 3))]
        for h in (one, *others):
            for column in ("px", "py", "pz", "Lx", "Ly", "Lz"):
                self.assertLess(np.ptp(h[column]), 1e-9 * np.abs(h[column]).max(), column)
            np.testing.assert_allclose(h["hub_qz"], one["hub_qz"], atol=1e-9)
        self.assertGreater(np.ptp(one["hub_qz"]), 0.09)

    def test_every_method_keeps_its_order(self):
        loads = "loads: [{force: [0, '0.1*(50*t)^4', '-0.15*(50*t)^4'], volume: hub}, {torque: ['0.01*(50*t)^4', 0, 0], volume: hub}]\n"
        text = BAR.replace("P2", "P1") + "constraints: [{surface: left, displacement: [0, 0, 0]}]\n" + loads
        write_box(self.directory / "bar.msh", (6, 1, 1), (LENGTH, WIDTH, WIDTH))
        massive = ", mass: 0.3, inertia: [1e-4, 1e-4, 1e-4]"
        for more in swept((massive, ""), (massive,)):
            with self.subTest(more):
                self.write("in.yaml", text + hub(more) + "time: {method: bdf2, step: 1 ms, end: 16 ms}\n")
                self.pliant("converge", "in.yaml", "--in", "time", "--levels", "4", "--methods", ALL_OR_SOME)

    def test_a_hub_rests_when_its_load_is_gone(self):
        """It is turned back to where it was: what is left of displacements is rounding of those before."""
        write_box(self.directory / "bar.msh", (5, 1, 1), (1, 0.2, 0.2))
        h = self.solve("""mesh: {file: bar.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}]
constraints: [{surface: left, displacement: [0, 0, 0]}]
rigid_bodies: [{name: hub, mass: 1, inertia: [0.01, 0.01, 0.01], center: [1.1, 0.1, 0.1], attached: [right]}]
loads: [{volume: hub, force: [0, 0, "t < 0.15 ? -20 : 0"]}]
""", "method: quasistatic, step: 0.1, end: 1")
        self.assertGreater(np.abs(h["hub_z"] - 0.1).max(), 0.01)
        self.assertLess(abs(h["hub_z"][-1] - 0.1), 1e-12)

    def test_a_run_goes_on_on_other_ranks(self):
        text = self.thrown() + "time: {method: bdf3, step: 2 ms, end: END}\noutput: {every: 1}\ncheckpoint: {every: 5}\n"
        self.write("whole.yaml", text.replace("END", "0.04"))
        whole = self.run_input("whole.yaml", output="whole")
        self.write("in.yaml", text.replace("END", "0.02"))
        self.run_input("in.yaml", ranks=2, output="part")
        self.pliant("resume", "part", "--quiet", "--set", "time.end=0.04", ranks=3)
        part = read_history(self.directory / "part")
        for column in ("hub_x", "hub_qz", "hub_wz", "elastic_energy", "Lz"):
            np.testing.assert_allclose(part[column], whole[column], atol=1e-7 * np.abs(whole[column]).max(), err_msg=column)

    def test_a_shape_does_not_touch_what_is_coupled_with_it(self):
        write_cube(self.directory / "cube.stl", (0.2, 0.2, 1.0), (0.8, 0.8, 1.4))
        write_box(self.directory / "box.msh", (3, 3, 2))
        text = """mesh: {file: box.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: cube, mass: 100, inertia: [1, 1, 1], center: [0.5, 0.5, 1.2], surface: {file: cube.stl}, coupled: [top]}
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
"""
        time = "method: bdf2, step: 5 ms, end: 0.05"
        alone, touching = self.solve(text, time), self.solve(text + "contact: {law: barrier, pairs: all}\n", time)
        self.assertEqual(np.nanmax(touching["contact_points"]), 0)
        np.testing.assert_allclose(touching["cube_z"], alone["cube_z"], atol=1e-8)

    def test_a_prescribed_surface_leads_the_body(self):
        text = BAR + "constraints: [{surface: right, displacement: [0.01, 0, 0]}]\n" + hub()
        h = self.solve(text, "method: static")
        np.testing.assert_allclose(h["hub_x"][-1], LENGTH + 0.01, atol=1e-12)

    def test_mistakes(self):
        def refused(text, *messages, ranks=1):
            self.write("in.yaml", BAR + text + "time: {method: bdf2, step: 1 ms, end: 1}\n")
            done = self.call("run", "in.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            for message in messages:
                self.assertIn(message, done.stderr)

        refused(hub(held="coupled: [rigth]"), "in.yaml:4", "rigth", "right")
        refused(hub(held="attached: [left], coupled: [bottom]"), "in.yaml:4", "surface 'bottom'", "'hub'", "rigid", ranks=2)
        refused(hub(held="coupled: [right], attached: [right]"), "surface 'right'", "rigid")
        refused(hub(held="coupling_stiffness: 1e5"), "coupling_stiffness", "coupled")
        refused(hub(held="coupled: [right], coupling_stiffness: 0"), "coupling_stiffness")
        refused(hub(held="coupled: []"), "coupled")
        refused(hub(", inertia: [1, 1, 1]"), "has no mass")
        refused("constraints: [{surface: right, rigid: {translation: [0, 0, 0], rotation: free}}]\n" + hub(), "surface 'right'", "rigid")


if __name__ == "__main__":
    unittest.main()
