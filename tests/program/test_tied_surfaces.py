#!/usr/bin/python3
"""Surfaces of meshes that do not match, tied to one another: patch tests, what is conserved, ranks, and messages."""
import itertools
import unittest

import h5py
import numpy as np

from program import LONG, SIDES, TETRAHEDRON, TETRAHEDRON_10, TRIANGLE, TRIANGLE_6, ProgramTest, box, read_history, swept

YOUNG, POISSON = 900.0, 0.25
TREATMENTS = {"P1": ("standard",), "P2": ("standard", "mean-dilatation", "mixed")}
COUNTS = {"P1": (3, 5), "P2": (2, 3)}  # bricks along an edge of the lower and of the upper body


def skewed(points):
    """Moves the points inside a plane of constant z, as far as they are inside the box; the box remains what it is."""
    x, y, z = points.T
    inside = x * (1 - x) * y * (1 - y)
    return np.stack([x + 0.9 * inside * (0.5 - z), y + 0.7 * inside * (z - 0.2), z], axis=1)


def write_bodies(path, bodies):
    """`bodies`: name and (points, triangles per side, cells); the groups are NAME and NAME_SIDE."""
    groups, elements, points, number = [], [], np.zeros((0, 3)), 0
    for name, (own, triangles, cells) in bodies.items():
        kinds = (TRIANGLE_6, TETRAHEDRON_10) if cells.shape[1] == 10 else (TRIANGLE, TETRAHEDRON)
        parts = [(2, kinds[0], f"{name}_{side}", t) for side, t in zip(SIDES, triangles)] + [(3, kinds[1], name, cells)]
        for dimension, kind, title, members in parts:
            number += 1
            groups.append(f'{dimension} {number} "{title}"')
            elements += [f"{kind} 2 {number} {number} " + " ".join(map(str, m + len(points) + 1)) for m in members]
        points = np.vstack([points, own])
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", len(groups), *groups, "$EndPhysicalNames",
             "$Nodes", len(points), *(f"{k + 1} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(points.tolist())),
             "$EndNodes", "$Elements", len(elements), *(f"{k + 1} {e}" for k, e in enumerate(elements)), "$EndElements", ""]
    path.write_text("\n".join(map(str, lines)), encoding="ascii")


def halves(lower=3, upper=5, gap=0.0, shift=0.0, order=1, turn=np.eye(3)):
    """The unit cube as two bodies of different meshes, one above the other."""
    bottom = box((lower, lower, 2), (1, 1, 0.5), order=order, shape=lambda x: skewed(x) @ turn.T)
    top = box((upper, upper, 2), (1, 1, 0.5), (0, 0, 0.5), order=order,
              shape=lambda x: (skewed(x) + [shift, 0, gap]) @ turn.T)
    return {"lower": bottom, "upper": top}


def linear(H):
    """The formulas of H X."""
    return ", ".join('"' + " + ".join(f"({H[i, j]})*{'xyz'[j]}" for j in range(3)) + '"' for i in range(3))


class TiedSurfaces(ProgramTest):
    def write_input(self, constraints, more="", element="P1", volumetric="standard", law="", mesh="halves.msh", bodies=None):
        law = law or f"{{model: neo-hookean, youngs_modulus: {YOUNG}, poissons_ratio: {POISSON}}}"
        lines = "".join(f"  - {c}\n" for c in constraints)
        listed = ", ".join(f"{{volume: {name}, density: 1000, elasticity: {law}}}" for name in bodies or ("lower", "upper"))
        time = "" if "time:" in more else "time: {method: static}\n"
        self.write("in.yaml", f"mesh: {{file: {mesh}}}\nelement: {element}\nvolumetric: {volumetric}\nbodies: [{listed}]\n"
                              f"solver: {{newton: {{relative: 1e-13}}}}\nconstraints:\n{lines}{time}{more}")

    def fields(self, *settings, ranks=1):
        """Rest positions and displacements at the end, sorted by position and body."""
        self.run_input("in.yaml", *settings, ranks=ranks)
        with h5py.File(self.directory / "out/result.h5") as file:
            rest = file["mesh/coordinates"][:]
            u = list(file["frames"].values())[-1]["displacement"][:]
        order = np.lexsort(np.round(rest, 9).T)
        return rest[order], u[order]

    def assert_linear(self, rest, u, gradient, tolerance):
        expected = rest @ np.asarray(gradient).T
        self.assertGreater(np.abs(expected).max(), 1e-3)
        self.assertLess(np.abs(u - expected).max(), tolerance * np.abs(expected).max())

    def test_linear_motion_of_the_boundary(self):
        # All sides move by H X, shear of the interface included: so does all that is inside, whichever side depends.
        H = np.array([[0.03, 0.05, -0.08], [0.01, -0.04, 0.06], [0.02, 0.03, 0.05]])
        sides = [("lower", side) for side in SIDES if side != "top"] + [("upper", side) for side in SIDES if side != "bottom"]
        held = [f"{{surface: {body}_{side}, displacement: [{linear(H)}]}}" for body, side in sides]
        for element, treatments in TREATMENTS.items():
            write_bodies(self.directory / "halves.msh", halves(*COUNTS[element]))
            cases = list(itertools.product(treatments, (("lower_top", "upper_bottom"), ("upper_bottom", "lower_top"))))
            for treatment, (a, b) in swept(cases, cases[::5] if len(cases) > 2 else cases[1:]):
                self.write_input([*held, f"{{surface: {a}, tied_to: {b}}}"], "", element, treatment)
                for ranks in swept((1, 2, 3), (2,)) if treatment == treatments[-1] else (1,):
                    with self.subTest(element=element, treatment=treatment, dependent=a, ranks=ranks):
                        self.assert_linear(*self.fields(ranks=ranks), H, 1e-11)

    def test_constant_stress(self):
        # Pressed by a traction of 100, small enough here for the linear solution: (1/36, 1/36, -1/9) at the far corner of
        # the cube for 100. Only symmetry holds it.
        held = [f"{{surface: {body}_{side}, symmetry: plane}}" for body in ("lower", "upper") for side in ("left", "front")]
        held.append("{surface: lower_bottom, symmetry: plane}")
        exact = np.diag([1 / 36, 1 / 36, -1 / 9])
        law = f"{{model: saint-venant-kirchhoff, youngs_modulus: {YOUNG}, poissons_ratio: {POISSON}}}"
        for element, treatments in TREATMENTS.items():
            write_bodies(self.directory / "halves.msh", halves(*COUNTS[element]))
            cases = list(itertools.product(treatments, (("lower_top", "upper_bottom"), ("upper_bottom", "lower_top"))))
            for treatment, (a, b) in swept(cases, cases[::5] if len(cases) > 2 else cases[1:]):
                used = law if treatment == "standard" else ""
                self.write_input([*held, f"{{surface: {a}, tied_to: {b}}}"],
                                 "loads: [{surface: upper_top, traction: [0, 0, -1e-4]}]\n", element, treatment, used)
                for ranks in swept((1, 2, 3), (1,)) if treatment == treatments[-1] else (1,):
                    with self.subTest(element=element, treatment=treatment, dependent=a, ranks=ranks):
                        rest, u = self.fields(ranks=ranks)
                        u = 1e6 * u
                        # The body is nonlinear: a part of its strain, 1e-7.
                        self.assertLess(np.abs(u - rest @ exact).max(), 1e-6)
                        self.assertLess(np.abs(u[-1] - np.diag(exact)).max(), 1e-6)

    def test_ties_that_meet_at_an_edge(self):
        # A block in the corner between a floor and a wall, which are tied as well.
        H = np.array([[0.03, 0.05, -0.08], [0.01, -0.04, 0.06], [0.02, 0.03, 0.05]])
        write_bodies(self.directory / "corner.msh", {
            "floor": box((4, 3, 2), (1.5, 1, 0.5), (-0.5, 0, -0.5)), "wall": box((2, 4, 3), (0.5, 1, 1), (-0.5, 0, 0)),
            "block": box((3, 5, 4))})
        outside = [("floor", side) for side in SIDES if side != "top"]
        outside += [("wall", side) for side in ("left", "front", "back", "top")]
        outside += [("block", side) for side in ("right", "front", "back", "top")]
        held = [f"{{surface: {body}_{side}, displacement: [{linear(H)}]}}" for body, side in outside]
        ties = [f"{{surface: {a}, tied_to: {b}}}" for a, b in (("block_bottom", "floor_top"), ("block_left", "wall_right"),
                                                                ("wall_bottom", "floor_top"))]
        orders = list(itertools.permutations(ties))
        for order in swept(orders, orders[::2]):
            self.write_input([*order, *held], mesh="corner.msh", bodies=("floor", "wall", "block"))
            self.assert_linear(*self.fields(ranks=2 if LONG and order[0] == ties[0] else 1), H, 1e-11)

    def test_a_periodic_cell(self):
        # Its sides are periodic above and below the tie, and its ends move.
        H = np.array([[0.03, 0.05, -0.08], [0.01, -0.04, 0.06], [0.02, 0.03, 0.05]])
        for element, (lower, upper) in COUNTS.items():
            straight = {"lower": box((lower, lower, 2), (1, 1, 0.5)), "upper": box((upper, upper, 2), (1, 1, 0.5), (0, 0, 0.5))}
            write_bodies(self.directory / "halves.msh", straight)
            ends = [f"{{surface: {name}, displacement: [{linear(H)}]}}" for name in ("lower_bottom", "upper_top")]
            sides = [f"{{surface: {body}_{b}, periodic_with: {body}_{a}, difference: {H[:, axis].tolist()}}}"
                     for body in ("lower", "upper") for axis, (a, b) in enumerate((("left", "right"), ("front", "back")))]
            self.write_input(["{surface: upper_bottom, tied_to: lower_top}", *sides, *ends], "", element)
            for ranks in swept((1, 3), (1,)):
                self.assert_linear(*self.fields(ranks=ranks), H, 1e-11)

    def test_a_prescribed_dependent_surface_moves_the_other(self):
        write_bodies(self.directory / "halves.msh", halves(2, 4))
        self.write_input(["{volume: lower, displacement: [0.1, -0.05, 0.02]}", "{surface: lower_top, tied_to: upper_bottom}"])
        _, u = self.fields()
        self.assertLess(np.abs(u - [0.1, -0.05, 0.02]).max(), 1e-10)

    def test_momentum_of_a_free_body(self):
        # It rotates and vibrates, while the tie bridges a gap, or gaps and overlaps of curved surfaces.
        curved = {name: (x + 0.2 * x[:, :1] * (1 - x[:, :1]) * [0, 0.5, 1], *mesh)
                  for name, (x, *mesh) in halves(2, 3, order=2).items()}
        gap = halves(2, 3, gap=0.02)
        for name, bodies, element in (("gap", gap, "P1"), ("curved", curved, "P2"), *([("gap", gap, "P2")] if LONG else [])):
            write_bodies(self.directory / "halves.msh", bodies)
            self.write_input(["{surface: upper_bottom, tied_to: lower_top, tolerance: 0.05}"],
                             'initial: {velocity: ["-2*y", "2*x + z", "0.5*y"]}\n'
                             "time: {method: implicit-midpoint, step: 0.02, end: 0.4}\n", element)
            for ranks in swept((1, 2), (1,)):
                with self.subTest(name, element=element, ranks=ranks):
                    h = self.run_input("in.yaml", ranks=ranks)
                    size = max(np.abs(h[f"L{axis}"]).max() for axis in "xyz")
                    for axis in "xyz":
                        self.assertLess(np.ptp(h[f"L{axis}"]), 1e-11 * size)
                        self.assertLess(np.ptp(h[f"p{axis}"]), 1e-11 * size)
                    self.assertGreater(h["elastic_energy"].max(), 1.0)
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-9 * h["kinetic_energy"][0])

    def test_a_clamp_that_bears_through_ties_has_the_whole_moment(self):
        write_bodies(self.directory / "halves.msh", halves())
        force = np.array([2e-3, -3e-3, 1e-2])
        self.write_input(["{name: root, surface: lower_left, displacement: [0, 0, 0]}",
                          "{surface: upper_bottom, tied_to: lower_top, tolerance: 0.02}"],
                         f"loads: [{{surface: upper_top, traction: [{', '.join(map(str, force))}]}}]\n")
        for ranks in (1, 3):
            self.run_input("in.yaml", ranks=ranks)
            h = read_history(self.directory / "out")
            np.testing.assert_allclose([h[f"root_f{x}"][-1] for x in "xyz"], -force, rtol=1e-9)
            moment = -np.cross([0.5, 0, 0.75], force)
            np.testing.assert_allclose([h[f"root_t{x}"][-1] for x in "xyz"], moment, atol=1e-3 * np.abs(moment).max())

    def test_any_number_of_ranks_and_resumed(self):
        write_bodies(self.directory / "halves.msh", halves(3, 4, gap=0.01))
        self.write_input(["{surface: lower_bottom, displacement: [0, 0, 0]}",
                          "{surface: upper_bottom, tied_to: lower_top, tolerance: 0.02}"],
                         'loads: [{surface: upper_top, traction: ["30*t", 0, 20]}]\n'
                         "time: {method: dirk22, step: 0.05, end: 0.3}\ncheckpoint: {every: 3}\n")
        one = self.run_input("in.yaml")
        self.assertGreater(np.abs(one["upper_bottom_fx"]).max(), 0.1)
        for ranks in swept((2, 3), (3,)):
            self.assert_same_history(self.run_input("in.yaml", ranks=ranks), one, 1e-8)
        self.run_input("in.yaml", "time.end=0.15", output="half")
        checkpoint = next((self.directory / "half").glob("checkpoint*"))
        done = self.call("resume", checkpoint, "--quiet", "--set", "time.end=0.3", ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        rest = read_history(self.directory / "half")
        self.assertAlmostEqual(rest["kinetic_energy"][-1] / one["kinetic_energy"][-1], 1, delta=1e-8)

    def test_tied_surfaces_do_not_touch(self):
        write_bodies(self.directory / "halves.msh", halves(2, 3))
        ties = ["{surface: lower_bottom, displacement: [0, 0, 0]}", "{surface: upper_bottom, tied_to: lower_top}"]
        load = "loads: [{surface: upper_top, traction: [20, 0, -10]}]\n"
        self.write_input(ties, load)
        alone = self.fields()
        self.write_input(ties, load + "contact: {law: barrier, pairs: all}\n")
        self.assertLess(np.abs(self.fields()[1] - alone[1]).max(), 1e-9)

    def test_prescribed_forces_and_notes(self):
        # Pulled: the force of the tie on the upper body is the one of the support below.
        write_bodies(self.directory / "halves.msh", halves(2, 3, gap=0.01, shift=0.6))
        self.write_input(["{surface: lower_bottom, displacement: [0, 0, 0]}", "{surface: upper_bottom, tied_to: lower_top, "
                          "tolerance: 0.02}", "{surface: upper_top, displacement: [0, 0, 0.1]}"])
        h = self.run_input("in.yaml")
        self.assertGreater(abs(h["lower_bottom_fz"][-1]), 1)
        for axis in "xyz":
            self.assertAlmostEqual(h[f"upper_bottom_f{axis}"][-1], h[f"lower_bottom_f{axis}"][-1], delta=1e-8)
        done = self.call("check", "in.yaml")
        self.assertRegex(done.stdout + done.stderr, r"8 nodes of surface 'upper_bottom' are tied to surface 'lower_top', over "
                                                    r"gaps of up to 0.01 m; 8 nodes farther away than the tolerance of 0.02 m "
                                                    r"stay free, the nearest by")

    def test_messages(self):
        write_bodies(self.directory / "halves.msh", halves(2, 3, gap=0.3))
        held = "{surface: lower_bottom, displacement: [0, 0, 0]}"
        for tie, message in (
                ("{surface: lower_top, tied_to: lower_top}", "surface 'lower_top' cannot be tied to itself; name another surface"),
                ("{surface: upper_bottom, tied_to: lower_top}", "no node of surface 'upper_bottom' lies within 0.0[0-9]* m of "
                 r"surface 'lower_top'; the nearest one, at \(.*, 0.8\), is 0.3 m away; .* give a larger `tolerance`"),
                ("{box: [[0, 0, 1.29], [1, 1, 1.31]], tied_to: upper_top}",
                 "the box has all its nodes in common with surface 'upper_top': the mesh joins them already"),
                ("{volume: upper, tied_to: lower_top}", "volume 'upper' has no facets that could be tied"),
                ("{surface: upper_bottom, tied_to: nowhere}", "no surface 'nowhere' in the mesh")):
            with self.subTest(message):
                self.write_input([held, tie])
                done = self.call("check", "in.yaml", ranks=2 if "within" in message else 1)
                self.assertEqual(done.returncode, 2, done.stdout)
                self.assertRegex(done.stderr, message)
        points, triangles, cells = box((2, 2, 2))
        faces = np.unique(np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]].reshape(-1, 3), axis=1), axis=0)
        inside = faces[(np.abs(points[faces][:, :, 0] - 0.5) < 1e-9).all(axis=1)]
        write_bodies(self.directory / "cut.msh", {"lower": (points, [inside, *triangles[1:]], cells)})
        self.write_input([held, "{surface: lower_top, tied_to: lower_left}"], mesh="cut.msh", bodies=["lower"])
        done = self.call("check", "in.yaml")
        self.assertEqual(done.returncode, 2, done.stdout)
        self.assertIn("surface 'lower_left' lies inside the mesh, where the mesh joins what it separates", done.stderr)

    def test_coinciding_nodes_need_a_tie(self):
        write_bodies(self.directory / "halves.msh", halves(2, 2))
        self.write_input(["{surface: lower_bottom, displacement: [0, 0, 0]}", "{surface: upper_top, displacement: [0, 0, 0.1]}"])
        done = self.call("check", "in.yaml")
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"nodes that coincide with another node.*tie their surfaces in the input \(`tied_to`\)")
        self.write_input(["{surface: lower_bottom, displacement: [0, 0, 0]}", "{surface: lower_top, tied_to: upper_bottom}"])
        self.assertEqual(self.call("check", "in.yaml").returncode, 0)


if __name__ == "__main__":
    unittest.main()
