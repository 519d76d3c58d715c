#!/usr/bin/python3
"""Bodies that touch one another: weight, impacts, what does not pass through what, ranks, and messages."""
import json
import unittest

import h5py
import numpy as np

from program import LONG, ROOT, ProgramTest, box, read_history, swept, write_mesh

BLOCKS = ROOT / "meshes/falling_blocks.geo"
GEOMETRY = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 1};
Box(2) = {-1, -1, %s, 2, 2, 2};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = {5};
Mesh.MeshSizeMin = 1;
Mesh.MeshSizeMax = 1;
"""
G = 9.81


def bodies(young="1e5", density=1000, rest=""):
    return "\n".join(f"  - {{volume: {name}, density: {density}, elasticity: {{model: neo-hookean, youngs_modulus: {young}, "
                     f"poissons_ratio: 0.3}}{rest}}}" for name in ("base", "block"))


def two_blocks(contact="law: barrier, pairs: all", time="method: backward-euler, step: 2 ms, end: 0.02", young="1e5", rest="",
               velocity="[0, 0, 0]", file="blocks.geo", element="P1"):
    """A block of 20 mm, 2 mm above a base of 40 x 40 x 10 mm."""
    return f"""
mesh: {{file: {file}, scale: 0.01}}
element: {element}
bodies:
{bodies(young, rest=rest)}
constraints: [{{surface: floor, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, 0, {-G}]}}]
initial: {{velocity: {velocity}}}
contact: {{{contact}}}
time: {{{time}}}
output: {{fields: [displacement, contact_pressure, contact_gap]}}
"""


def tetrahedra(cells, rest):
    """Linear ones: a quadratic cell as the eight between its nodes, whose outer sides are those that touch."""
    if cells.shape[1] == 4:
        return cells
    first = rest[cells[0]]
    at = {(a, b): int(np.linalg.norm(first - 0.5 * (first[a] + first[b]), axis=1).argmin()) for a in range(4) for b in range(a)}
    e = {pair: cells[:, n] for (a, b), n in at.items() for pair in ((a, b), (b, a))}
    corners = [(cells[:, a], *(e[a, b] for b in range(4) if b != a)) for a in range(4)]
    ring = [e[0, 2], e[1, 2], e[1, 3], e[0, 3]]  # around the axis from edge 01 to edge 23
    inner = [(e[0, 1], e[2, 3], ring[k], ring[(k + 1) % 4]) for k in range(4)]
    return np.concatenate([np.stack(nodes, axis=1) for nodes in corners + inner])


def places_inside(directory):
    """Nodes of one body inside a tetrahedron of another, in all frames, by comparing all with all."""
    found = 0
    with h5py.File(directory / "result.h5") as file:
        rest, cells, body = (file["mesh"][name][:] for name in ("coordinates", "cells", "body"))
        for frame in file["frames"].values():
            x = rest + frame["displacement"][:]
            for b in np.unique(body):
                own = tetrahedra(cells[body == b], rest)
                origin = x[own[:, 0]]
                to_local = np.linalg.inv(np.stack([x[own[:, i]] - origin for i in (1, 2, 3)], axis=2))
                for node in np.setdiff1d(cells[body != b], cells[body == b]):
                    local = np.einsum("tij,tj->ti", to_local, x[node] - origin)
                    found += np.any(np.minimum(local.min(axis=1), 1 - local.sum(axis=1)) > 0)
    return found


class BodyContact(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("blocks.geo", GEOMETRY % "1.2")

    def run_blocks(self, name, *, ranks=1, **options):
        return self.run_input(self.write(name + ".yaml", two_blocks(**options)), output=name, ranks=ranks)

    def test_a_block_at_rest_weighs_what_it_weighs(self):
        damped = ", viscosity: [{model: mass-proportional, decay_rate: 40}]"
        options = {"rest": damped, "time": "method: bdf2, step: 5 ms, end: 0.7"}
        h = self.run_blocks("rest", **options)
        weight = 1000 * G * (0.04 * 0.04 * 0.01 + 0.02**3)
        self.assertAlmostEqual(h["floor_fz"][-1] / weight, 1, delta=1e-5)
        self.assertGreater(h["contact_points"][-1], 3)
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * np.abs(h["load_potential"]).max())
        # The pressure on the base carries the block.
        with h5py.File(self.directory / "rest" / "result.h5") as file:
            frame = file["frames"][max(file["frames"])]
            touched = frame["contact_pressure"][:]
            self.assertGreater(touched.max(), 0.5 * 1000 * G * 0.02)
            gap = frame["contact_gap"][:]
            self.assertAlmostEqual(gap[touched > 0].min(), h["contact_gap_min"][-1], delta=0.5 * h["contact_gap_min"][-1])
        self.assertEqual(places_inside(self.directory / "rest"), 0)
        # Whatever cuts the interface.
        options["time"] = "method: bdf2, step: 5 ms, end: 0.06"
        h = self.run_blocks("alone", **options)
        for ranks in swept((2, 3), (2,)):
            self.assert_same_history(h, self.run_blocks(f"rest{ranks}", ranks=ranks, **options), 1e-5)

    def test_nothing_passes_however_fast(self):
        cases = (("P1", 40, "1e6"), ("P2", 3, "1e5"), ("P1", 2, "1e5"))
        for element, speed, young in swept(cases, cases[:1]):
            with self.subTest(element=element, speed=speed):
                name = f"fast{element}{speed}"
                h = self.run_blocks(name, element=element, young=young,
                                    velocity=f"[0, \"z > 0.011 ? {0.3 * speed} : 0\", \"z > 0.011 ? {-speed} : 0\"]",
                                    time="method: dirk22, step: 5 ms, end: 0.02")
                self.assertGreater(h["contact_gap_min"].min(), 0)
                self.assertEqual(places_inside(self.directory / name), 0)

    def test_bodies_with_pressures_and_rigid_ones_touch(self):
        # The first contact changes the pattern of a matrix that has been factorized before.
        speed = "[0, 0, \"z > 0.011 ? -0.5 : 0\"]"
        time = "method: backward-euler, step: 2 ms, end: 0.012"
        for name, change in (("mixed", ("element: P1", "element: P2\nvolumetric: mixed")),
                             ("rigid", ("constraints: [", "constraints: [{volume: block, rigid: {}}, "))):
            with self.subTest(name):
                text = two_blocks(velocity=speed, time=time).replace(*change)
                h = self.run_input(self.write(name + ".yaml", text), output=name)
                self.assertGreater(h["contact_points"].max(), 0)
                self.assertGreater(h["contact_gap_min"].min(), 0)
                self.assertEqual(places_inside(self.directory / name), 0)

    def test_what_spins_hits_what_is_in_its_way(self):
        # Steps of 11 degrees, and opposite sides of a blade with parallel edges; the stick is thrown away.
        self.write("blade.geo", """SetFactory("OpenCASCADE");
Box(1) = {-5, -0.2, 0, 10, 0.4, 2};
Box(2) = {3, 0.4, 0.2, 1, 3, 1};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = {5};
Mesh.MeshSizeMax = 0.6;
""")
        text = two_blocks(file="blade.geo", young="5e6", time="method: bdf2, step: 2 ms, end: 0.03",
                          velocity='["y < 0.003 ? -100*y : 0", "y < 0.003 ? 100*x : 0", 0]')
        text = text.replace("constraints: [{surface: floor, displacement: [0, 0, 0]}]\n", "").replace(f"{-G}", "0")
        h = self.run_input(self.write("spin.yaml", text), output="spin")
        self.assertEqual(places_inside(self.directory / "spin"), 0)
        self.assertGreater(h["contact_points"].max(), 0)
        self.assertLess(np.abs(h["Lz"] / h["Lz"][0] - 1).max(), 0.2, "backward Euler starts bdf2, and loses some of it")

    def test_a_plate_that_is_moved_pushes_in_front_of_it(self):
        text = two_blocks(contact="law: barrier, pairs: [{surface: block, with: base}]", young="1e6",
                          time="method: bdf2, step: 4 ms, end: 0.1")
        text = text.replace("displacement: [0, 0, 0]}", "displacement: [0, 0, \"0.4*t\"]}").replace(f"{-G}", "0")
        h = self.run_input(self.write("pushed.yaml", text), output="pushed")
        self.assertEqual(places_inside(self.directory / "pushed"), 0)
        self.assertGreater(h["pz"][-1], 0.3 * 1000 * (0.04 * 0.04 * 0.01 + 0.02**3))

    def test_a_paddle_takes_along_what_is_thinner_than_its_step(self):
        # It is prescribed as a whole, so that nothing feels it before it touches; 8 mm a step, and a block of 3 mm.
        self.write("paddle.geo", """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 0.5};
Box(2) = {-1, -1, 1, 2, 2, 0.3};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = {5};
Mesh.MeshSizeMax = 0.7;
""")
        text = two_blocks(file="paddle.geo", young="1e6", time="method: backward-euler, step: 4 ms, end: 0.024").replace(f"{-G}", "0")
        constraint = "constraints: [{surface: floor, displacement: [0, 0, 0]}]\n"
        self.assertIn(constraint, text)
        law = bodies("1e6").splitlines()[0].split("elasticity")[1].rstrip("}")
        rigid = text.replace("volume: base, density: 1000, elasticity" + law + "}", "volume: base, density: 1000, rigid: true")
        self.assertIn("rigid: true", rigid)
        given = 'constraints: [{volume: base, %s}]\n'
        slider = 'joints: [{name: rail, type: slider, between: [ground, base], point: [0, 0, 0], axis: [0, 0, 1], motion: "2*t"}]\n'
        ways = {"prescribed": text.replace(constraint, given % 'displacement: [0, 0, "2*t"]'),
                "turning": rigid.replace(constraint, given % 'rigid: {translation: [0, 0, "2*t"], rotation: free}'),
                "joint": rigid.replace(constraint, slider)}
        for name, way in ways.items():
            for method in swept(("backward-euler", "bdf2", "dirk22", "dirk33"), ("backward-euler", "dirk22")):
                h = self.run_input(self.write("paddle.yaml", way), f"time.method={method}", output="paddle")
                self.assertEqual(places_inside(self.directory / "paddle"), 0, name)
                block = 1000 * 0.02 * 0.02 * 0.003
                self.assertGreater(h["pz"][-1] - 1000 * 0.04 * 0.04 * 0.005 * 2, 0.9 * 2 * block, name)
                self.assertEqual(len(h["time"]), 7, f"{name}, {method}: no step fails")

    def test_load_steps_move_rigid_parts_across_gaps(self):
        # Load steps scale what is constant in time.
        text = two_blocks(young="1e6", time="method: static, load_steps: 2").replace(f"{-G}", "0")
        rigid = text.replace("volume: block, density: 1000, elasticity" + bodies("1e6").splitlines()[1].split("elasticity")[1].rstrip("}") + "}",
                             "volume: block, density: 1000, rigid: true")
        self.assertIn("rigid: true", rigid)
        forces = []
        for rotation in ("fixed", "free"):
            h = self.run_input(self.write("press.yaml", rigid.replace("constraints: [", "constraints: [{volume: block, rigid: {translation: "
                                          f"[0, 0, -0.003], rotation: {rotation}}}}}, ")), output="press")
            self.assertEqual(len(h["time"]), 3, "no step fails")
            self.assertEqual(places_inside(self.directory / "press"), 0)
            forces.append(h["floor_fz"][-1])
        self.assertGreater(forces[0], 100)
        np.testing.assert_allclose(forces[1], forces[0], rtol=0.05)  # it turns a little on the mesh below

    def test_the_same_bits_whether_interrupted_or_not(self):
        text = two_blocks(velocity="[0, 0, \"z > 0.011 ? -0.5 : 0\"]", time="method: bdf2, step: 1 ms, end: 0.02")
        self.run_input(self.write("whole.yaml", text + "checkpoint: {every: 8}\n"), output="whole")
        whole = (self.directory / "whole/history.csv").read_bytes()
        first, second = sorted((self.directory / "whole").glob("checkpoint-*.h5"))
        second.unlink()
        done = self.call("resume", first, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.directory / "whole/history.csv").read_bytes(), whole)

    def test_free_bodies_keep_their_momentum(self):
        text = two_blocks(velocity="[0, 0, \"z > 0.011 ? -1 : 0\"]", time="method: bdf2, step: 1 ms, end: 0.02")
        text = text.replace("constraints: [{surface: floor, displacement: [0, 0, 0]}]\n", "").replace(f"{-G}", "0")
        h = self.run_input(self.write("free.yaml", text), output="free")
        self.assertGreater(h["contact_points"].max(), 0)
        for name in ("px", "py", "pz"):
            self.assertLess(np.ptp(h[name]), 1e-8 * abs(h["pz"][0]))
        self.assertLess(h["kinetic_energy"][-1] + h["elastic_energy"][-1], h["kinetic_energy"][0] * (1 + 1e-9))

    def test_a_block_slides_down_a_slab_as_coulomb_says(self):
        """On a slope of 1/2: the block starts at a velocity that friction keeps or takes away."""
        self.write("blocks.geo", GEOMETRY % "1.005")
        cases = [(friction, update) for friction in (0.45, 0.55) for update in ("iterated", "frozen")]
        for number, (friction, update) in enumerate(swept(cases, cases[::3])):
            with self.subTest(friction=friction, update=update):
                text = two_blocks(f"law: barrier, friction_update: {update}, stick_velocity: 0.1 mm/s, "
                                  f"pairs: [{{name: grip, surface: block, with: base, friction: {friction}}}]",
                                  "method: bdf2, step: 2 ms, end: 0.08", young="1e7", velocity='["0.2*(z > 11e-3)", 0, 0]')
                text = text.replace(f"[0, 0, {-G}]", f"[{G / 5**0.5}, 0, {-2 * G / 5**0.5}]")
                h = self.run_input(self.write("slope.yaml", text), output="slope", ranks=1 + number // 2 if LONG else 1)
                # Whatever the block does: while it slides, friction is in proportion to the pressure.
                tolerance = 2e-3 if update == "iterated" else 0.1  # at the start of a step, which misses a part of impacts
                np.testing.assert_allclose(h["grip_jx"][-1], -friction * h["grip_jz"][-1], rtol=tolerance)
                weight = 1000 * 8e-6 * 2 * G / 5**0.5
                np.testing.assert_allclose(h["grip_jz"][-1], weight * h["time"][-1], rtol=0.15)  # it bounces
                self.assertGreater(h["dissipated_friction"][-1], 0)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * h["dissipated_friction"][-1])

    def test_what_nothing_holds_at_rest_is_named(self):
        (self.directory / "blocks.geo").write_text(GEOMETRY % "1.2")
        free = two_blocks("law: barrier, pairs: all", "method: quasistatic, step: 0.1, end: 1").replace(f"loads: [{{gravity: [0, 0, -{G}]}}]\n", "")
        for text in (free, free.replace("{volume: block, density: 1000, elast", "{volume: block, density: 1000, rigid: true} #")):
            done = self.pliant("check", self.write("in.yaml", text))
            self.assertIn("nothing but contact holds 1 of the mesh's 2 parts: without inertia it can move as a rigid body until it touches", done.stdout + done.stderr)
        text = text.replace("contact: {law: barrier, pairs: all}\n", "").replace(", contact_pressure, contact_gap", "")
        self.assertIn("warning: ", self.pliant("check", self.write("in.yaml", text)).stderr.split("nothing holds 1 of the mesh's 2 parts")[0].splitlines()[-1])
        held = free.replace("constraints: [", "constraints: [{volume: block, displacement: [0, 0, 0]}, ")
        done = self.pliant("check", self.write("in.yaml", held))
        self.assertNotIn(" holds 1 of", done.stdout + done.stderr)

    def test_friction_settles_although_points_change_sides(self):
        # Points of the block lie over edges of the plate, where the nearest facet jumps: both facets share the friction.
        plate, block = box((3, 3, 1), (1, 1, 0.3)), box((2, 2, 1), (0.4, 0.4, 0.299), (0.3, 0.3, 0.301))
        sides = [np.vstack([a, b + len(plate[0])]) for a, b in zip(plate[1], block[1])]
        write_mesh(self.directory / "blocks.msh", np.vstack([plate[0], block[0]]), sides, np.vstack([plate[2], block[2] + len(plate[0])]),
                   (["plate", "block"], np.repeat([0, 1], [len(plate[2]), len(block[2])])))
        law = "elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}"
        self.write("in.yaml", f"""
mesh: {{file: blocks.msh}}
bodies: [{{volume: plate, density: 1000, {law}}}, {{volume: block, density: 1000, {law}}}]
constraints:
  - {{box: [[-1, -1, -1], [2, 2, 1e-6]], displacement: [0, 0, 0]}}
  - {{name: lid, box: [[-1, -1, 0.599], [2, 2, 1]], displacement: [0, 0, -0.02*t]}}
contact: {{law: penalty, stick_velocity: 1e-4, pairs: [{{surface: block, with: plate, friction: 0.3}}]}}
time: {{method: quasistatic, step: 0.05, end: 0.5}}
""")
        done = self.pliant("run", "in.yaml", "--output", "out")
        self.assertNotIn("normal forces jump between two states", done.stderr + done.stdout)
        summary = json.loads((self.directory / "out/summary.json").read_text())
        self.assertEqual(summary["steps"]["failed"], 0)
        self.assertEqual(summary["solver"]["unsettled_stages"], 0)
        h = read_history(self.directory / "out")
        # Quadratic elements with pressures, on ranks.
        more = ("element=P2", "volumetric=mixed", "time.step=0.1", "time.end=0.2")
        one, three = (self.run_input("in.yaml", *more, ranks=ranks) for ranks in (1, 3))
        # The ranks' solves stop at different states, each of which may lack this part of the friction.
        self.assertLess(json.loads((self.directory / "out/summary.json").read_text())["solver"]["worst_unsettled"], 1e-2)
        for column in ("dissipated_friction", "lid_fx", "lid_fz"):
            np.testing.assert_allclose(three[column][1:], one[column][1:], rtol=1e-2)
        frozen = self.run_input("in.yaml", "contact.friction_update=frozen", "time.step=0.005")
        for column in ("dissipated_friction", "lid_fz"):
            np.testing.assert_allclose(h[column][-1], frozen[column][-1], rtol=0.01)

    def test_friction_settles_where_edges_of_both_bodies_lie_in_line(self):
        # A block sinks into a wider one and is dragged along. Both are mirror images of themselves, with edges in the middle.
        def with_image(points, sides, cells):
            inner = points[:, 1] < 1e-9
            image = np.where(inner, np.arange(len(points)), len(points) + np.cumsum(~inner) - 1)
            left, right, _, back, bottom, top = sides
            both = [np.vstack([side, image[side[:, [1, 0, 2]]]]) for side in (left, right, bottom, top)]
            return (np.vstack([points, points[~inner] * [1, -1, 1]]), [*both[:2], image[back[:, [1, 0, 2]]], back, *both[2:]],
                    np.vstack([cells, image[cells[:, [1, 0, 2, 3]]]]))

        parts = [with_image(*box((4, 2, 2), (0.2, 0.1, 0.05))), with_image(*box((2, 2, 1), (0.08, 0.06, 0.049), (0.05, 0, 0.051)))]
        first = len(parts[0][0])
        write_mesh(self.directory / "blocks.msh", np.vstack([part[0] for part in parts]),
                   [np.vstack([a, b + first]) for a, b in zip(parts[0][1], parts[1][1])], np.vstack([parts[0][2], parts[1][2] + first]),
                   (["low", "up"], np.repeat([0, 1], [len(part[2]) for part in parts])))
        self.write("in.yaml", """
mesh: {file: blocks.msh}
volumetric: mixed
bodies:
  - {volume: low, density: 1000, elasticity: {model: neo-hookean-isochoric, youngs_modulus: 1e5, poissons_ratio: 0.49}}
  - {volume: up, density: 1000, elasticity: {model: yeoh, c10: 5e4, c20: 1e3, poissons_ratio: 0.45}}
constraints:
  - {box: [[-1, -1, -1], [1, 1, 1e-6]], displacement: [0, 0, 0]}
  - {name: lid, box: [[-1, -1, 0.0999], [1, 1, 1]], displacement: ["1.5*(t>0.03?1:0)*(t-0.03)^2", free, "-0.006*min(t/0.03,1)"]}
contact: {law: penalty, friction: 0.4, stick_velocity: 10 mm/s, normal_damping: 0.1, pairs: [{surface: low, with: up}]}
time: {method: bdf2, step: 3 ms, end: 0.06}
solver: {newton: {relative: 1e-11}}
""")
        for volumetric in ("mixed", "standard"):
            h = self.run_input("in.yaml", f"volumetric={volumetric}", output="out", timeout=60)
            solver = json.loads((self.directory / "out/summary.json").read_text())
            self.assertEqual((len(h["step"]), solver["steps"]["failed"], solver["solver"]["unsettled_stages"]), (21, 0, 0))
            self.assertLess(abs(h["lid_fy"][-1]), 1e-3 * h["lid_fx"][-1])

    def test_a_block_is_gripped_and_lifted_without_inertia(self):
        parts = [box((2, 2, 2), (0.04,) * 3, (0, 0, 0)), box((1, 1, 1), (0.01, 0.02, 0.02), (-0.0115, 0.01, 0.01)),
                 box((1, 1, 1), (0.01, 0.02, 0.02), (0.0415, 0.01, 0.01))]
        first = np.cumsum([0] + [len(part[0]) for part in parts])
        cells = np.vstack([part[2] + n for part, n in zip(parts, first)])
        sides = [np.vstack([part[1][k] + n for part, n in zip(parts, first)]) for k in range(len(parts[0][1]))]
        write_mesh(self.directory / "grip.msh", np.vstack([part[0] for part in parts]), sides, cells,
                   (["block", "left", "right"], np.repeat([0, 1, 2], [len(part[2]) for part in parts])))
        rubber = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.4}"
        self.write("in.yaml", f"""
mesh: {{file: grip.msh}}
bodies: [{{volume: block, {rubber}}}, {{volume: left, {rubber}}}, {{volume: right, {rubber}}}]
constraints:
  - {{name: left_hand, box: [[-1, -1, -1], [-0.0114, 1, 1]], displacement: ["0.0025*min(t,1)", 0, "0.02*max(t-1,0)"]}}
  - {{name: right_hand, box: [[0.0514, -1, -1], [1, 1, 1]], displacement: ["-0.0025*min(t,1)", 0, "0.02*max(t-1,0)"]}}
loads: [{{gravity: [0, 0, -{G}]}}]
contact:
  {{law: penalty, stick_velocity: 1e-4, pairs: all, friction: 0.8, obstacles: [{{name: floor, shape: plane, normal: [0, 0, 1], friction: 0.5}}]}}
time: {{method: quasistatic, step: 0.1, end: 1.5}}
probes: [{{name: middle, point: [0.02, 0.02, 0.02]}}]
""")
        h = self.run_input("in.yaml", ranks=2 if LONG else 1)
        block, pads = 1000 * G * 0.04**3, 2 * 1000 * G * 0.01 * 0.02**2
        self.assertAlmostEqual(h["floor_fz"][2] / block, 1, delta=1e-6)
        self.assertEqual(h["floor_fz"][-1], 0)
        self.assertAlmostEqual((h["left_hand_fz"][-1] + h["right_hand_fz"][-1]) / (block + pads), 1, delta=1e-6)
        self.assertAlmostEqual(h["middle_z"][-1] - h["middle_z"][10], 0.01, delta=1e-3)

    def test_a_wedge_goes_in_and_out(self):
        """tan(15 deg +- phi) times the force of the spring, phi the angle of friction; at the end both just part."""
        extruded = """SetFactory("OpenCASCADE");
Point(1) = {%s}; Point(2) = {%s}; Point(3) = {%s}; Point(4) = {%s};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
e[] = Extrude{0, %g, 0}{Surface{1};};
Physical Volume("body") = {e[1]};
MeshSize{:} = 0.03;
"""
        side, gap = 0.1 * np.tan(np.radians(15)), 1e-4 / np.cos(np.radians(15))
        profile = ("-0.02, -0.02, 0", "0.02, -0.02, 0", f"{0.02 + side:.9f}, -0.02, 0.1", f"{-0.02 - side:.9f}, -0.02, 0.1")
        self.write("wedge.geo", extruded % (*profile, 0.04))
        slope = (f"{0.02 - 0.5 * side + gap:.9f}, -0.03, -0.05", "0.12, -0.03, -0.05", "0.12, -0.03, 0.15", f"{0.02 + 1.5 * side + gap:.9f}, -0.03, 0.15")
        self.write("block.geo", extruded % (*slope, 0.06))
        h = self.solve("""
rigid_bodies:
  - {name: wedge, mass: 1, inertia: [1, 1, 1], center: [0, 0, 0.05], surface: {file: wedge.geo}}
  - {name: block, mass: 1, inertia: [1, 1, 1], center: [0.1, 0, 0.05], surface: {file: block.geo}}
joints:
  - {name: shaft, type: slider, between: [ground, wedge], point: [0, 0, 0.05], axis: [0, 0, 1], motion: "-0.005*sin(pi*t)"}
  - {name: rail, type: slider, between: [ground, block], point: [0.1, 0, 0.05], axis: [1, 0, 0], spring: {stiffness: 1e4}}
contact: {law: barrier, width: 0.1 mm, friction: 0.4, stick_velocity: 0.02 mm/s, pairs: [{surface: wedge, with: block}]}
""", "method: quasistatic, step: 20 ms, end: 1")
        self.assertEqual(len(h["time"]), 51, "no step is repeated")
        slope, friction = np.radians(15), np.arctan(0.4)
        for k, angle in ((15, slope + friction), (35, slope - friction)):
            self.assertAlmostEqual(h["shaft_fz"][k] / h["rail_spring"][k], np.tan(angle), delta=1e-5)
        self.assertLess(abs(h["rail_spring"][-1]), 1e-6)

    def test_friction_alone_holds_a_block_on_a_slope_without_inertia(self):
        # Above the slope at first, where there is no friction yet. The tangent of the slope is 0.576.
        self.write("slope.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.3, 0.06, 0.02};
Box(2) = {0.03, 0.01, 0.0201, 0.04, 0.04, 0.02};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = Surface In BoundingBox{-1, -1, -0.001, 1, 1, 0.001};
Mesh.MeshSizeMin = 0.02;
Mesh.MeshSizeMax = 0.02;
""")
        weight = 1000 * 0.04 * 0.04 * 0.02
        for law, friction, code in swept((("penalty", 0.7, 0), ("barrier", 0.7, 0), ("penalty", 0.3, 3)), (("penalty", 0.7, 0), ("penalty", 0.3, 3))):
            with self.subTest(law=law, friction=friction):
                file = self.write("slope.yaml", f"""
mesh: {{file: slope.geo}}
bodies:
{bodies("1e6")}
constraints: [{{surface: floor, displacement: [0, 0, 0]}}]
contact: {{law: {law}, friction: {friction}, pairs: [{{name: seat, surface: block, with: base}}]}}
loads: [{{gravity: [4.9, 0, -8.5]}}]
time: {{method: quasistatic, step: 0.1, end: 0.2}}
""")
                done = self.call("run", file)
                self.assertEqual(done.returncode, code, done.stderr)
                if code != 0:
                    self.assertIn("nothing holds the bodies against the loads, not even friction", done.stderr)
                    continue
                h = read_history(self.directory / "out/slope")
                np.testing.assert_allclose([h["seat_fx"][-1], h["seat_fz"][-1]], [-4.9 * weight, 8.5 * weight], rtol=1e-5)
                self.assertEqual(len(h["time"]), 3)

    def test_a_penalty_holds_what_lies_on_it(self):
        damped = ", viscosity: [{model: mass-proportional, decay_rate: 40}]"
        weight = 1000 * G * 0.02**3
        cases = (("P1", "[{name: grip, surface: block, with: base}]"), ("P1", "all"), ("P2", "all"))
        for element, pairs in swept(cases, cases[:1]):
            with self.subTest(element=element, pairs=pairs):
                options = {"rest": damped, "time": "method: bdf2, step: 5 ms, end: 0.5", "element": element,
                           "contact": f"law: penalty, pairs: {pairs}"}
                h = self.run_blocks("soft", **options)
                self.assertAlmostEqual((h["floor_fz"][-1] - 1000 * G * 0.04 * 0.04 * 0.01) / weight, 1, delta=1e-5)
                if pairs != "all":
                    self.assertAlmostEqual(h["grip_fz"][-1] / weight, 1, delta=1e-5)
                self.assertLess(h["contact_gap_min"][-1], 0)
                self.assertGreater(h["contact_gap_min"].min(), -2e-4)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * np.abs(h["load_potential"]).max())
                with h5py.File(self.directory / "soft" / "result.h5") as file:
                    frame = file["frames"][max(file["frames"])]
                    self.assertAlmostEqual(frame["contact_gap"][:].min(), h["contact_gap_min"][-1], delta=5e-5)
                    self.assertGreater(frame["contact_pressure"][:].max(), 0.5 * 1000 * G * 0.02)
                options["time"] = "method: bdf2, step: 5 ms, end: 0.06"
                h = self.run_blocks("alone", **options)
                for ranks in swept((2, 3), ()):
                    self.assert_same_history(h, self.run_blocks(f"soft{ranks}", ranks=ranks, **options), 1e-5)

    def test_the_force_of_a_pair_is_all_that_its_bodies_exert(self):
        # A block sinks into a soft base, which rises around its foot and presses on its sides.
        self.write("rim.geo", (GEOMETRY % "1.0").replace("MeshSizeMin = 1", "MeshSizeMin = 0.7").replace("MeshSizeMax = 1", "MeshSizeMax = 0.7")
                   + 'Physical Surface("top") = {6};\nPhysical Surface("foot") = {11};\nPhysical Surface("lid") = {12};\n')
        file = self.write("rim.yaml", """
mesh: {file: rim.geo, scale: 0.01}
bodies:
  - {volume: base, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}
  - {volume: block, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}}
constraints: [{surface: floor, displacement: [0, 0, 0]}, {surface: lid, displacement: ["0.002*t", 0, "-0.004*t"]}]
contact: {law: penalty, friction: 0.5, pairs: [{name: seat, surface: foot, with: top}]}
time: {method: quasistatic, step: 0.25, end: 0.5}
""")
        for ranks in swept((1, 2), (1,)):
            h = self.run_input(file, ranks=ranks)
            for axis in "xyz":
                np.testing.assert_allclose(h[f"lid_f{axis}"], -h[f"seat_f{axis}"], atol=1e-5 * abs(h["lid_fz"][-1]))

    def test_every_method_keeps_momentum_on_a_penalty(self):
        # Free blocks that meet at 2 m/s.
        methods = ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33", "implicit-midpoint", "symplectic-dirk22")
        for method in swept(methods, ("bdf2", "dirk23", "symplectic-dirk22")):
            with self.subTest(method):
                text = two_blocks("law: penalty, friction: 0.3, pairs: [{name: grip, surface: base, with: block}]",
                                  f"method: {method}, step: 0.2 ms, end: 12 ms", young="1e6", velocity='[0.3, 0, "z > 0.011 ? -1 : 0"]')
                text = text.replace("constraints: [{surface: floor, displacement: [0, 0, 0]}]\nloads: [{gravity: [0, 0, -9.81]}]\n", "")
                self.assertNotIn("gravity", text)
                h = self.run_input(self.write("free.yaml", text), output="free")
                for name in ("px", "py", "pz"):
                    self.assertLess(np.abs(h[name] - h[name][0]).max(), 1e-8 * np.abs(h["pz"][0]), name)
                self.assertGreater(np.abs(h["grip_jz"][-1]), 0.5 * np.abs(h["pz"][0]))
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * h["kinetic_energy"][0])
                if method in ("implicit-midpoint", "symplectic-dirk22"):
                    lost = h["dissipated_friction"][-1]
                    total = (h["kinetic_energy"] + h["elastic_energy"])[-1] + lost
                    self.assertAlmostEqual(total / h["kinetic_energy"][0], 1, delta=0.08)

    def test_laws_of_pairs_stand_side_by_side_and_go_on_elsewhere(self):
        self.write("three.geo", (GEOMETRY % "1.1").replace("Physical Volume", "Box(3) = {-1, -1, 3.2, 2, 2, 2};\nPhysical Volume", 1)
                   + 'Physical Volume("top") = {3};\n')
        text = two_blocks("pairs: [{name: soft, surface: base, with: block}, {name: hard, surface: block, with: top, law: barrier}]",
                          "method: bdf2, step: 1 ms, end: 30 ms", file="three.geo").replace(
            "bodies:\n", "bodies:\n  - {volume: top, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}\n")
        file = self.write("mixed.yaml", text + "checkpoint: {every: 24}\n")
        whole = self.run_input(file, output="whole")
        self.assertLess(whole["soft_fz"].min(), 0)
        self.assertLess(whole["hard_fz"].min(), 0)
        self.run_input(file, output="part")
        for later in sorted((self.directory / "part").glob("checkpoint-*.h5"))[1:]:
            later.unlink()
        done = self.call("resume", "part", "--quiet", ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_history(whole, read_history(self.directory / "part"), 1e-5)

    def test_a_penalty_says_what_it_cannot_hold(self):
        # A thin plate, and a block that would be beyond it after one step.
        self.write("thin.geo", GEOMETRY.replace("-2, -2, 0, 4, 4, 1", "-2, -2, 0.8, 4, 4, 0.2") % "1.2")
        cases = ((30, 1), (3, 1), (3, 2), (30, 2))
        for speed, ranks in swept(cases, cases[:2]):
            text = two_blocks("law: penalty, pairs: all", "method: bdf2, step: 4 ms, least_step: 1 ms, end: 0.02", file="thin.geo",
                              velocity=f'[0, 0, "z > 0.011 ? -{speed} : 0"]', young="1e4").replace("least_step: 1 ms, ", "")
            done = self.call("run", self.write("thin.yaml", text), ranks=ranks)
            self.assertIn("too deep to be pushed back by a penalty", done.stderr)
            with h5py.File(self.directory / "out/thin/result.h5") as file:
                rest, cells, body = (file["mesh"][name][:] for name in ("coordinates", "cells", "body"))
                for frame in file["frames"].values():
                    height = rest[:, 2] + frame["displacement"][:][:, 2]
                    self.assertGreater(height[cells[body == 1]].min(), height[cells[body == 0]].min())
        # What starts in contact is pushed; what starts far inside is refused.
        for height, code, expected in (("0.999", 0, "would throw the bodies apart with .* J"), ("0.5", 2, "too deep for a penalty to part them")):
            self.write("blocks.geo", GEOMETRY % height)
            done = self.call("run", self.write("two.yaml", two_blocks("law: penalty, pairs: all")))
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr, expected)

    def test_a_penalty_holds_what_turns_onto_it_without_inertia(self):
        # A lever, 1 mm above a pad of 100 kPa: nothing else keeps its weight from turning it right through.
        self.write("lever.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0.05, 0.5, 0.05, 0.02};
Box(2) = {0.35, 0, 0, 0.1, 0.05, 0.049};
Physical Volume("lever") = {1};
Physical Volume("pad") = {2};
Physical Surface("floor") = Surface In BoundingBox{-1, -1, -0.001, 1, 1, 0.001};
Mesh.MeshSizeMax = 0.02;
""")
        cases = (("penalty", "quasistatic", 1), ("barrier", "quasistatic", 1), ("penalty", "static", 2))
        found = {}
        for law, method, ranks in cases:
            file = self.write("lever.yaml", f"""
mesh: {{file: lever.geo}}
bodies:
  - {{volume: lever, rigid: true, density: 2000}}
  - {{volume: pad, density: 1000, elasticity: {{model: neo-hookean, youngs_modulus: 100 kPa, poissons_ratio: 0.3}}}}
constraints: [{{surface: floor, displacement: [0, 0, 0]}}]
joints: [{{name: pin, type: hinge, between: [ground, lever], point: [0, 0.025, 0.06], axis: [0, 1, 0]}}]
contact: {{pairs: [{{name: seat, surface: lever, with: pad, law: {law}}}]}}
loads: [{{gravity: [0, 0, {-G}]}}]
time: {{method: {method}{"" if method == "static" else ", step: 0.1, end: 0.1"}}}
""")
            done = self.call("run", file, ranks=ranks)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertRegex(done.stdout, "; [01] repeated after a failed solve")
            found[law, method] = read_history(self.directory / "out/lever")
        weight = 2000 * G * 0.5 * 0.05 * 0.02
        for case, h in found.items():
            # About the pin: the weight at 0.25 m, the pad between 0.35 and 0.45 m.
            self.assertTrue(weight * 0.25 / 0.45 < abs(h["seat_fz"][-1]) < weight * 0.25 / 0.35, case)
            self.assertTrue(0.001 / 0.45 < h["pin_angle"][-1] < 0.006, case)
        self.assertAlmostEqual(found["penalty", "static"]["pin_angle"][-1], found["penalty", "quasistatic"]["pin_angle"][-1], delta=1e-7)

    def test_a_penalty_resolves_an_overlap_by_strain(self):
        # The patch test of Tribol and MFEM: cubes of lambda = mu = 50 that overlap by 0.01 in the mesh, held above and below. What
        # coincides exactly there, edges on faces and corners on edges, has a pressure and a direction.
        text = (ROOT / "meshes/contact_patch.geo").read_text()
        self.assertIn("gap = 1e-4;", text)
        self.write("patch.geo", text.replace("gap = 1e-4;", "gap = -0.01;"))
        law = "elasticity: {model: linear, youngs_modulus: 125, poissons_ratio: 0.25}"
        for element in swept(("P1", "P2"), ("P1",)):
            with self.subTest(element):
                file = self.write("patch.yaml", f"""
mesh: {{file: patch.geo}}
element: {element}
bodies: [{{volume: lower, {law}}}, {{volume: upper, {law}}}]
constraints: [{{surface: left, symmetry: plane}}, {{surface: front, symmetry: plane}},
              {{surface: bottom, displacement: [free, free, 0]}}, {{surface: lid, displacement: [free, free, 0]}}]
contact: {{law: penalty, stiffness: 1e6, width: 1e-6, threshold: 1e-6, pairs: [{{name: patch, surface: lower_face, with: upper_face}}]}}
time: {{method: static}}
output: {{fields: [cauchy_stress]}}
""")
                done = self.call("run", file)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("warning", done.stderr)
                self.assertAlmostEqual(read_history(self.directory / "out/patch")["patch_fz"][-1], -0.625, delta=1e-3 * 0.625)
                with h5py.File(self.directory / "out/patch/result.h5") as file:
                    vertical = file["frames"][max(file["frames"])]["cauchy_stress"][:, 2]
                np.testing.assert_allclose(vertical, -0.625, rtol=0.01)

    def test_rims_on_one_another_take_few_factorizations(self):
        # Points that slide off a rim make the Hessian indefinite. Barriers lose their negative curvature then, without further attempts.
        self.write("rims.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {0, 0, 1.00001, 1, 1, 1};
MeshSize{ PointsOf{ Volume{1}; } } = 0.16;
MeshSize{ PointsOf{ Volume{2}; } } = 0.12;
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
Physical Surface("bottom") = {5};
Physical Surface("lid") = {12};
""")
        law = "elasticity: {model: linear, youngs_modulus: 125, poissons_ratio: 0.25}"
        done = self.call("run", self.write("rims.yaml", f"""
mesh: {{file: rims.geo}}
bodies: [{{volume: lower, {law}}}, {{volume: upper, {law}}}]
constraints: [{{surface: bottom, displacement: [0, 0, 0]}}, {{surface: lid, displacement: [0, 0, -0.01]}}]
contact: {{law: barrier, pairs: [{{surface: upper, with: lower}}]}}
time: {{method: static, load_steps: 4}}
"""))
        self.assertEqual(done.returncode, 0, done.stderr)
        summary = json.loads((self.directory / "out/rims/summary.json").read_text())
        self.assertEqual(summary["steps"]["failed"], 0)
        solver = summary["solver"]
        self.assertGreater(solver["projections"], 0)
        self.assertLess(solver["factorizations"], 0.75 * solver["newton_iterations"], solver)

    def test_a_penalty_does_not_end_at_a_plane_of_symmetry(self):
        # A quarter of two balls on coarse meshes, which touch on the axis alone, where both planes meet. With springs so stiff that
        # nothing sinks in, penalty and barrier are the same.
        forces = {}
        text = (ROOT / "input/verification/contact_balls.yaml").read_text().replace("../../meshes", str(ROOT / "meshes"))
        for law, keys in (("barrier", "width: 1e-6"), ("penalty", "width: 1e-6, stiffness: 1e16")):
            self.assertIn("  law: barrier\n", text)
            file = self.write("balls.yaml", text.replace("contact:\n  law: barrier\n", f"contact:\n  law: {law}\n  "
                                                         + keys.replace(", ", "\n  ") + "\n"))
            forces[law] = self.run_input(file, "mesh.size=6", "element=P1", "time.load_steps=4", output=law)["balls_fz"][-1]
        self.assertLess(forces["barrier"], -1e5)
        self.assertAlmostEqual(forces["penalty"] / forces["barrier"], 1, delta=2e-3)

    def test_parts_of_one_body_that_a_penalty_lets_pass_are_warned_of(self):
        self.write("one.geo", (GEOMETRY % "1.1").replace('Physical Volume("base") = {1};\nPhysical Volume("block") = {2};',
                                                         'Physical Volume("base") = {1, 2};'))
        text = two_blocks("law: penalty, pairs: all", file="one.geo", velocity='[0, 0, "z > 0.0105 ? -1 : 0"]')
        text = "\n".join(line for line in text.splitlines() if "volume: block" not in line)
        done = self.call("run", self.write("one.yaml", text))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("two parts of 'base', which share no node, pass through one another", done.stderr)

    def test_messages(self):
        touching = self.write("touching.geo", GEOMETRY % "1")
        within = self.write("within.geo", GEOMETRY % "0.3")
        for name, options, expected in (
                ("itself", {"contact": "pairs: [{surface: base}]"}, "contact of a part with itself needs 'law: barrier'"),
                ("one body", {"contact": "pairs: [{surface: floor, with: base}]"},
                 "'floor' with 'base' are parts of one body, and contact of a body with itself needs 'law: barrier'"),
                ("none", {"contact": "law: barrier"}, "at least one of pairs, obstacles is needed"),
                ("excluded", {"contact": "law: barrier, exclude: [[base, block]]"}, "'exclude' can only be given with 'pairs'"),
                ("unknown", {"contact": "law: barrier, pairs: [{surface: blok}]"}, "no volume, surface or rigid body 'blok'"),
                ("method", {"time": "method: implicit-midpoint, step: 1 ms, end: 0.01"}, "stiffly accurate"),
                ("repeated", {"contact": "law: barrier, pairs: [{surface: base, with: block}, {surface: block, with: base}]"},
                 "contact.pairs[1] repeats contact.pairs[0]"),
                ("touching", {"file": touching}, "'base' and 'block' touch at the start in 1 place"),
                ("within", {"file": within}, "'base' and 'block' overlap at the start in 1 place")):
            with self.subTest(name):
                file = self.write(name + ".yaml", two_blocks(**options))
                for ranks in swept((1, 2), (1,)):
                    done = self.call("run", file, "--quiet", ranks=ranks)
                    self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
                    self.assertEqual(done.stderr.count(expected), 1, done.stderr)

    def test_excluded_bodies_pass_and_a_warning_names_the_key_where_none_is_asked_for(self):
        speed = "[0, 0, \"z > 0.011 ? -1 : 0\"]"
        h = self.run_blocks("excluded", contact="law: barrier, pairs: all, exclude: [[base, block]]", velocity=speed)
        self.assertEqual(h["contact_points"].max(), 0)
        # They pass on purpose.
        told = json.loads((self.directory / "excluded/summary.json").read_text())["warnings"]
        self.assertFalse([line for line in told if "pass through" in line], told)
        text = two_blocks(velocity=speed, time="method: backward-euler, step: 2 ms, end: 0.02")
        done = self.call("run", self.write("through.yaml", text.replace("contact: {law: barrier, pairs: all}\n", "").replace(
            ", contact_pressure, contact_gap", "")), "--quiet")
        self.assertEqual(done.returncode, 0)
        self.assertIn("'contact: {law: barrier, pairs: all}' keeps bodies apart", done.stderr)


if __name__ == "__main__":
    unittest.main()
