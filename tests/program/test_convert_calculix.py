#!/usr/bin/python3
"""`pliant convert`: converted models have the results of CalculiX, version 2.20, whose numbers are stored here with the model they are of.

The models are written by the test, of quadratic tetrahedra and small displacements, so that both programs solve the same equations: a cube of
six elements. A number is the total force of `*NODE PRINT, NSET=left, TOTALS=ONLY`, `RF`, which has seven digits.
"""
import itertools
import math
import time
import unittest

import numpy as np

from test_convert import ConvertTest

PAIRS = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def cube_of_tetrahedra():
    """Numbers of the nodes by position, in halves of the edge, and the nodes of the elements (C3D10)."""
    nodes, cells = {}, []
    for order in itertools.permutations(range(3)):
        corners = [np.zeros(3, int)]
        for axis in order:
            corners.append(corners[-1] + 2 * np.eye(3, dtype=int)[axis])
        if np.linalg.det(np.array(corners[1:]) - corners[0]) < 0:
            corners[2], corners[3] = corners[3], corners[2]
        middles = [(corners[a] + corners[b]) // 2 for a, b in PAIRS]
        cells.append([nodes.setdefault(tuple(map(int, x)), len(nodes) + 1) for x in corners + middles])
    return nodes, cells


NODES, CELLS = cube_of_tetrahedra()


def deck(before, step, material="*ELASTIC\n1000., 0.3\n"):
    """A linear analysis of the cube; sets left, right, front, back, bottom, top."""
    text = "*NODE, NSET=all\n" + "".join(f"{n}, {x / 2}, {y / 2}, {z / 2}\n" for (x, y, z), n in NODES.items())
    text += "*ELEMENT, TYPE=C3D10, ELSET=cube\n" + "".join(f"{k}, {', '.join(map(str, cell))}\n" for k, cell in enumerate(CELLS, 1))
    for name, axis, side in (("left", 0, 0), ("right", 0, 2), ("front", 1, 0), ("back", 1, 2), ("bottom", 2, 0), ("top", 2, 2)):
        text += f"*NSET, NSET={name}\n" + ", ".join(str(n) for x, n in NODES.items() if x[axis] == side) + "\n"
    return f"{text}*MATERIAL, NAME=m\n{material}*SOLID SECTION, ELSET=cube, MATERIAL=m\n{before}*STEP\n*STATIC\n1., 1.\n{step}*END STEP\n"


class Calculix(ConvertTest):
    def check_force(self, text, force):
        config, said = self.convert("cube.inp", text)
        self.assertNotIn("not complete", said)
        history = self.history("cube.yaml")
        np.testing.assert_allclose([history[f"left_f{axis}"][-1] for axis in "xyz"], force, rtol=2e-7, atol=1e-6)
        return config, said

    def test_equations(self):
        """Of nodes at corners and between them; nodes of no element have a displacement, or are free and take a force."""
        a, b, c, d, e = (NODES[x] for x in ((2, 2, 2), (2, 0, 2), (2, 0, 0), (2, 2, 0), (2, 1, 0)))
        before = (f"*NODE\n900, 5., 5., 5.\n901, 6., 6., 6.\n*EQUATION\n3\n{a}, 1, 1., {b}, 2, -2., 900, 1, 1.\n*EQUATION\n3\n{c}, 2, 1., {d}, 3, 3., 901, 2, -2.\n"
                  f"2\n{d}, 2, 1., 901, 2, 0.5\n2\n{e}, 1, 1., {a}, 3, 0.25\n*BOUNDARY\nleft, 1, 3\n900, 2, 3\n901, 1, 1\n901, 3, 3\n")
        self.check_force(deck(before, f"*BOUNDARY\n900, 1, 1, -0.02\n*CLOAD\n901, 2, 3.\n{b}, 3, 5.\n"), [3.695871, 2.015073, -7.165939])

    def test_local_axes(self):
        """Displacements, forces and equations along axes that are the same for all nodes, or cylindrical."""
        a, b, c, d = (NODES[x] for x in ((2, 2, 2), (2, 0, 2), (1, 0, 2), (2, 2, 0)))
        before = ("*TRANSFORM, NSET=right, TYPE=R\n0.8, 0.6, 0., -0.6, 0.8, 0.\n*TRANSFORM, NSET=front, TYPE=C\n0.5, -1., 0., 0.5, -1., 1.\n"
                  f"*EQUATION\n2\n{a}, 2, 1., {d}, 2, -0.5\n*BOUNDARY\nleft, 1, 3\n")
        step = f"*BOUNDARY\nright, 1, 1, 0.02\n{c}, 1, 1, 0.01\n{c}, 2, 3, 0.02\n*CLOAD\n{a}, 3, 2.\n{d}, 2, 3.\n{b}, 2, 1.\n"
        self.check_force(deck(before, step), [-0.8614608, -7.954635, -7.094832])

    def test_temperature(self):
        """With one coefficient of expansion, and with one that depends on the temperature and counts from another one than that at the start."""
        before = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nall, 20.\n*BOUNDARY\nleft, 1, 3\nright, 1, 1\nfront, 2, 2\n"
        for table, force in (("2e-3", [261.1592, -82.66098, 0]), ("1e-3, 0.\n3e-3, 200.", [306.8620, -97.12665, 0])):
            material = f"*ELASTIC\n1000., 0.3\n*EXPANSION, ZERO=5.\n{table}\n"
            self.check_force(deck(before, "*TEMPERATURE\nall, 120.\n", material), force)
        steps = "*TEMPERATURE\nall, 120.\n*END STEP\n*STEP\n*STATIC\n1., 1.\n*TEMPERATURE, OP=NEW\n"
        config, _ = self.convert("cube.inp", deck(before, steps, "*ELASTIC\n1000., 0.3\n*EXPANSION\n1e-3\n"))
        self.assertEqual(config["bodies"][0]["expansion"], {"stretch": "t < 1 ? 1 + 0.1*t : 1.1 - 0.1*(t - 1)"})
        for card, words in (("*TEMPERATURE\nleft, 120.\n", "*TEMPERATURE: the nodes of cube have different temperatures, 20 at the start and from 20 to 120 at the end, and its "
                             "expansion is left out: give the body `expansion: {stretch: \"1 + 0.001*(T - 20)\"}`"), ("*TEMPERATURE, FILE=x\n", "*TEMPERATURE of a file or a subroutine")):
            _, said = self.convert("cube.inp", deck(before, card, "*ELASTIC\n1000., 0.3\n*EXPANSION\n1e-3\n"))
            self.assertIn(words, said)
            self.assertIn("not complete", said)
        config, said = self.convert("cube.inp", deck(before, "*TEMPERATURE\nall, 120.\n"))
        self.assertNotIn("not complete", said)
        self.assertNotIn("expansion", config["bodies"][0])


def block(size, count, base, first):
    """Text of the nodes and elements (C3D10) of a block on z = base, with edges of `size`, in count^3 cubes: the set block1 for numbers from 1; the nodes by position,
    and (number, nodes) of the elements."""
    nodes, cells = {}, []
    for cube in itertools.product(range(count), repeat=3):
        places = {n: x for x, n in NODES.items()}
        for cell in CELLS:
            cells.append([nodes.setdefault(tuple(2 * c + k for c, k in zip(cube, places[n])), first + len(nodes)) for n in cell])
    step = [edge / (2 * count) for edge in size]
    text = "*NODE\n" + "".join(f"{n}, {x * step[0]:.9g}, {y * step[1]:.9g}, {base + z * step[2]:.9g}\n" for (x, y, z), n in nodes.items())
    text += f"*ELEMENT, TYPE=C3D10, ELSET=block{first}\n" + "".join(f"{first + k}, {', '.join(map(str, cell))}\n" for k, cell in enumerate(cells))
    return text, nodes, [(first + k, cell) for k, cell in enumerate(cells)]


FACES = ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3))


SECTIONS = "*SOLID SECTION, ELSET=block1, MATERIAL=m\n*SOLID SECTION, ELSET=block5001, MATERIAL=m\n"


def two_blocks(contact, steps, size=(1, 1, 1), sections=SECTIONS):
    """A block on a block, whose meshes do not match; sets bottom, lid, and those at x = 0 and y = 0; surfaces lower and upper."""
    text, sides, sets = "", {}, {"bottom": [], "lid": [], "left": [], "front": []}
    for size_here, count, base, first in (((1, 1, 1), 2, 0, 1), (size, 3, 1, 5001)):
        mesh, nodes, cells = block(size_here, count, base, first)
        text += mesh
        for name, axis, side in (("left", 0, 0), ("front", 1, 0), ("bottom", 2, 0) if first == 1 else ("lid", 2, 2 * count)):
            sets[name] += [n for x, n in nodes.items() if x[axis] == side]
        touching = {n for x, n in nodes.items() if x[2] == (2 * count if first == 1 else 0)}
        sides["lower" if first == 1 else "upper"] = [(e, f"S{k}") for e, cell in cells for k, face in enumerate(FACES, 1) if touching >= {cell[c] for c in face}]
    text += "".join(f"*NSET, NSET={name}\n" + ",\n".join(map(str, members)) + "\n" for name, members in sets.items())
    text += "".join(f"*SURFACE, NAME={name}\n" + "".join(f"{e}, {face}\n" for e, face in faces) for name, faces in sides.items())
    return (f"{text}*MATERIAL, NAME=m\n*ELASTIC\n1000., 0.3\n{sections}{contact}{steps}")


class Contact(ConvertTest):
    """Blocks on each other, with springs of the same stiffness. The programs differ next to free edges, and by the width of Pliant's penalty."""

    SPRING = "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n1e5, 1.\n"
    PAIR = "*CONTACT PAIR, INTERACTION=i, TYPE=SURFACE TO SURFACE\nupper, lower\n"
    PRESSED = "*BOUNDARY\nbottom, 3, 3\nleft, 1, 1\nfront, 2, 2\n*STEP\n*STATIC\n0.25, 1.\n*BOUNDARY\nlid, 3, 3, -0.02\n*END STEP\n"

    def deck(self, properties=SPRING, steps=PRESSED, pair=PAIR, **more):
        return two_blocks(f"*SURFACE INTERACTION, NAME=i\n{properties}{pair}", steps, **more)

    def force(self):
        history = self.history("two.yaml")
        return [history[f"bottom_f{axis}"][-1] for axis in "xyz"]

    def test_pressed(self):
        """The force of CalculiX; of blocks with the same face also the closed form, E 0.02/(2 + E/1e5)."""
        for size, force in (((1, 1, 1), 9.950506), ((0.6, 0.7, 1), 5.084392)):
            config, said = self.convert("two.inp", self.deck(size=size))
            self.assertNotIn("not complete", said)
            (pair,) = config["contact"]["pairs"]
            self.assertEqual(pair["name"], "upper_lower")
            self.assertIn("upper_lower_fx", self.history("two.yaml"))
            self.assertEqual((pair["surface"], pair["with"], pair["stiffness"]), ("upper", "lower", 1e5))
            self.assertEqual(config["time"]["method"], "quasistatic")
            self.assertAlmostEqual(self.force()[2] / force, 1, delta=4e-3)

    def test_friction(self):
        """The upper block is pressed on the lower one and slides along it."""
        steps = ("*BOUNDARY\nbottom, 1, 3\n*STEP, NLGEOM\n*STATIC\n0.25, 1.\n*BOUNDARY\nlid, 1, 2\nlid, 3, 3, -0.02\n*END STEP\n"
                 "*STEP, NLGEOM\n*STATIC\n0.1, 1.\n*BOUNDARY\nlid, 1, 1, 0.05\n*END STEP\n")
        config, said = self.convert("two.inp", self.deck(self.SPRING + "*FRICTION\n0.3, 1e5\n", steps, size=(0.6, 0.7, 1)))
        self.assertNotIn("not complete", said)
        self.assertIn("what sticks creeps by up to stick_velocity, here 0.5 % of a facet in the whole run", said)
        self.assertEqual(config["contact"]["pairs"][0]["friction"], 0.3)
        np.testing.assert_allclose(self.force(), [-1.651280, -0.2874905, 5.667157], rtol=4e-3, atol=6e-3)

    def test_hard_contact(self):
        """Of two blocks that one section has; a node-based surface; contact of all surfaces. Surfaces sink in by a tenth of the compression."""
        one = "*ELSET, ELSET=both\nblock1, block5001\n*SOLID SECTION, ELSET=both, MATERIAL=m\n"
        nodes = "*NSET, NSET=touching\n" + ",\n".join(str(n) for x, n in block((1, 1, 1), 3, 1, 5001)[1].items() if x[2] == 0) + "\n*SURFACE, TYPE=NODE, NAME=dependent\ntouching\n"
        everything = "*CONTACT\n*CONTACT INCLUSIONS, ALL EXTERIOR\n*CONTACT PROPERTY ASSIGNMENT\n, , i\n"
        for behavior in ("", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n"):
            for text in (self.deck(behavior, sections=one), self.deck(behavior, pair=nodes + self.PAIR.replace("upper", "dependent")), self.deck(behavior, pair=everything, sections=one)):
                config, said = self.convert("two.inp", text)
                self.assertNotIn("not complete", said)
                self.assertEqual(len(config["bodies"]), 2)
                self.assertIn("a penalty of Pliant's stiffness", said)
            self.assertAlmostEqual(self.force()[2] / 10, 0.98, delta=0.012)

    def test_a_rigid_block(self):
        """Which a reference node moves."""
        rigid = "*NODE, NSET=reference\n9999, 0.5, 0.5, 2.\n*RIGID BODY, ELSET=block5001, REF NODE=reference\n"
        steps = "*BOUNDARY\nbottom, 3, 3\nbottom, 1, 2\nreference, 1, 2\nreference, 4, 6\n*STEP\n*STATIC\n1., 1.\n*BOUNDARY\nreference, 3, 3, -0.02\n*END STEP\n"
        _, said = self.convert("two.inp", self.deck(self.SPRING, steps, pair=self.PAIR + rigid))
        self.assertNotIn("not complete", said)
        # Between the uniaxial modulus and that of a block that cannot widen.
        self.assertTrue(20 < self.force()[2] < 26, self.force())

    def test_what_differs_is_said(self):
        for text, words, complete in (
                (self.deck(pair=self.PAIR.replace("TYPE", "ADJUST=0.01, TYPE")), "moved apart in the mesh, without strain (start: resolve)", True),
                (self.deck("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=EXPONENTIAL\n0.1, 10.\n"), "PRESSURE-OVERCLOSURE=EXPONENTIAL: the pressure of a `penalty` is linear", False),
                (self.deck("*FRICTION, TAUMAX=3.\n0.3,\n"), "*FRICTION, TAUMAX=3.: it has no counterpart", False),
                (self.deck("*FRICTION\n0.3, 0.\n0.2, 1.\n"), "the first of its 2 coefficients holds", False),
                (self.deck(pair="*CONTACT\n*CONTACT INCLUSIONS\nupper,\n"), "of one surface with all others", False),
                (self.deck(pair="*CONTACT\n*CONTACT INCLUSIONS, ALL EXTERIOR\n*CONTACT EXCLUSIONS\nupper, lower\n"), "law: barrier does both", True)):
            with self.subTest(words):
                config, said = self.convert("two.inp", text)
                self.assertIn(words, said)
                self.assertEqual("not complete" not in said, complete, said)
                self.assertEqual("contact" in config, "one surface" not in words)
        self.assertEqual(config["contact"]["exclude"], [["upper", "lower"]])
        self.assertIn("pairs: all", (self.directory / "two.yaml").read_text())
        config, said = self.convert("two.inp", self.deck("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n1e5\n"))
        self.assertIn({"surface": "upper", "tied_to": "lower"}, config["constraints"])
        self.assertNotIn("contact", config)
        config, _ = self.convert("two.inp", self.deck(pair=self.PAIR.replace("upper, lower", "upper")))
        self.assertEqual(config["contact"]["pairs"], [{"surface": "upper", "law": "barrier"}])
        for text, words in ((self.deck(pair=self.PAIR.replace("=i", "=j")), "the surface interaction 'j' is not defined"), (self.deck(pair=self.PAIR.replace("upper", "up")), "the surface 'up' is not defined"),
                            (self.deck("*FRICTION\n-0.3\n"), "the coefficient of friction must not be below 0"), (self.deck(self.SPRING.replace("1e5", "0")), "the slope of the pressure must be above 0")):
            self.fails(text, f"two.inp:\\d+: {words}", "two.inp")


class Cards(ConvertTest):
    """What has no counterpart is listed, and what is wrong is refused."""

    def test_equations(self):
        held = "*BOUNDARY\nleft, 1, 3\n"
        a, b = NODES[2, 2, 2], NODES[2, 0, 2]
        for card, words in ((f"*EQUATION\n2\n{a}, 4, 1., {b}, 1, 1.\n", "*EQUATION of degrees of freedom that are not displacements"),
                            ("*EQUATION, REMOVE ALL\n", "*EQUATION, REMOVEALL: an equation holds from the start to the end of a run"),
                            (f"*EQUATION\n1\n{a}, 1, 1.\n*TRANSFORM, NSET=left, TYPE=S\n0, 0, 0, 0, 0, 1\n", "*TRANSFORM, TYPE=S: conditions on its nodes are along local axes"),
                            ("*NODE\n900, 2, 0, 0\n*CLOAD\n900, 1, 1.\n", "*CLOAD on node 900, which belongs to no element")):
            _, said = self.convert("cube.inp", deck(held + card.replace("*CLOAD\n900, 1, 1.\n", ""), "*CLOAD\n900, 1, 1.\n" if "CLOAD" in card else "*CLOAD\ntop, 1, 1.\n"))
            self.assertIn(words, said)
            self.assertIn("not complete", said)
        for card, words in ((f"*EQUATION\n2\n{a}, 1, 1.\n", "\\*EQUATION: 1 of 2 terms are there"), ("*EQUATION\n2\nleft, 1, 1., back, 1, 1.,\n", None),
                            (f"*EQUATION\n2\nleft, 1, 1., somewhere, 1, 1.\n", "'somewhere' is neither a number nor the name of a set of nodes"), ("*TRANSFORM, NSET=left\n1, 0, 0, 2, 0, 0\n", "\\*TRANSFORM: its two points"),
                            (f"*NSET, NSET=two\n{a}, {b}\n*EQUATION\n2\nleft, 1, 1., two, 1, 1.\n", "the sets of an equation have 9 and 2 nodes")):
            if words is not None:
                self.fails(deck(held + card, "*CLOAD\ntop, 1, 1.\n"), f"cube.inp:\\d+: {words}", "cube.inp")
            else:
                config, _ = self.convert("cube.inp", deck(card, "*CLOAD\ntop, 1, 1.\n"))
                self.assertEqual(sum("equation" in constraint for constraint in config["constraints"]), 9)

    def test_axes_of_an_instance(self):
        """They move with it, of one instance and of several."""
        mesh, rest = deck("", "").split("*MATERIAL")
        mesh += "*TRANSFORM, NSET=right, TYPE=R\n0.8, 0.6, 0., -0.6, 0.8, 0.\n*TRANSFORM, NSET=left, TYPE=C\n0.5, -1., 0., 0.5, -1., 1.\n"
        section = rest[rest.index("*SOLID"):rest.index("*STEP")]
        for others in ("", "*INSTANCE, NAME=j, PART=p\n*END INSTANCE\n"):
            text = (f"*PART, NAME=p\n{mesh}{section}*END PART\n*ASSEMBLY, NAME=a\n{others}*INSTANCE, NAME=i, PART=p\n1., 2., 3.\n1., 2., 3., 1., 2., 4., 90.\n*END INSTANCE\n*END ASSEMBLY\n"
                    f"*MATERIAL{rest[:rest.index('*SOLID')]}*STEP\n*STATIC\n1., 1.\n*BOUNDARY\ni.right, 1, 1, 0.02\ni.{NODES[0, 2, 0]}, 1, 1, 0.01\n*END STEP\n")
            config, said = self.convert("cube.inp", text)
            self.assertNotIn("not complete", said)
            found = {constraint["displacement_along"]: constraint["direction"] for constraint in config["constraints"] if "displacement_along" in constraint}
            np.testing.assert_allclose(found[0.02], [-0.6, 0.8, 0], atol=1e-12)
            # (-0.5, 2, 0), from the axis, before the rotation.
            np.testing.assert_allclose(found[0.01], np.array([-2, -0.5, 0]) / math.hypot(2, 0.5), atol=1e-12)

    def test_cylindrical_axes_are_said_once(self):
        """Nodes on the axis are one warning; nodes that the tetrahedra add are named where there are any."""
        transform = "*TRANSFORM, NSET=all, TYPE=C\n0, 0, 0, 0, 0, 1\n*BOUNDARY\nbottom, 3, 3\n"
        _, said = self.convert("cube.inp", deck(transform, "*BOUNDARY\nfront, 1, 1, 0.1\nfront, 3, 3, 0.\n"))
        self.assertEqual(said.count("*TRANSFORM, TYPE=C"), 1)
        self.assertIn("the conditions of 3 such nodes stand along x, y, z: node", said)
        _, said = self.convert("cube.inp", deck(transform.replace("0, 0, 0, 0", "-1, 0, 0, -1"), "*BOUNDARY\nright, 1, 1, 0.1\n"))
        self.assertNotIn("*TRANSFORM", said)
        self.assertNotIn("later ones hold for the others", said)  # which have other directions
        _, said = self.convert("bricks.inp", self.plate(4).replace("*BOUNDARY", "*TRANSFORM, NSET=high, TYPE=C\n-1, -1, 0, -1, -1, 1\n*BOUNDARY").replace("*STATIC\n1., 1.\n", "*STATIC\n1., 1.\n*BOUNDARY\nhigh, 1, 1, 0.1\n"))
        self.assertIn("nodes that element: P2 adds between two of them are free", said)

    @staticmethod
    def plate(count):
        """Bricks (C3D8) in count x count; the nodes at its top move as those at its bottom."""
        at = lambda i, j, k: 1 + i + (count + 1) * (j + (count + 1) * k)  # noqa: E731
        places = [(i, j, k) for k in (0, 1) for j in range(count + 1) for i in range(count + 1)]
        text = "*NODE\n" + "".join(f"{at(*x)}, {x[0]}, {x[1]}, {x[2]}\n" for x in places) + "*ELEMENT, TYPE=C3D8, ELSET=plate\n"
        for number, (i, j) in enumerate(itertools.product(range(count), repeat=2), 1):
            text += f"{number}, " + ", ".join(str(at(i + a, j + b, k)) for k in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))) + "\n"
        text += "".join(f"*NSET, NSET={name}, GENERATE\n{at(0, 0, k)}, {at(count, count, k)}, 1\n" for k, name in enumerate(("low", "high")))
        return (f"{text}*MATERIAL, NAME=m\n*ELASTIC\n1000., 0.3\n*SOLID SECTION, ELSET=plate, MATERIAL=m\n*BOUNDARY\nlow, 1, 3\n*EQUATION\n2\nhigh, 2, 1., low, 2, -1.\n"
                "*STEP\n*STATIC\n1., 1.\n*END STEP\n")

    def test_many_equations(self):
        """Each node has a group of its own: more than 10000, in seconds."""
        start = time.monotonic()
        self.convert("plate.inp", self.plate(71))
        self.assertLess(time.monotonic() - start, 30)  # minutes where each name and number was searched for among all others
        self.assertEqual((self.directory / "plate.yaml").read_text().count("equation:"), 72**2)

    def test_parts_without_instances(self):
        self.fails("*PART, NAME=a\n*END PART\n*PART, NAME=b\n*END PART\n", "cube.inp:3: there is a second part, and no instance of it: write", "cube.inp")

    def test_a_node_between_others(self):
        """A displacement of a node in the middle of an edge alone, which no group of the mesh has."""
        config, said = self.convert("cube.inp", deck(f"*BOUNDARY\nleft, 1, 3\n{NODES[2, 1, 0]}, 3, 3, 0.1\n", ""))
        self.assertNotIn("not complete", said)
        low, high = np.array(config["constraints"][-1]["box"], dtype=float)
        np.testing.assert_allclose((low + high) / 2, [1, 0.5, 0], atol=1e-12)

    def test_sets_of_nodes_between_others(self):
        """Those that the mesh cannot have are listed, unless a condition uses them."""
        middle = NODES[2, 1, 0], NODES[2, 1, 2]
        sets = f"*NSET, NSET=middle\n{middle[0]}, {middle[1]}\n*NSET, NSET=mixed\n{NODES[2, 0, 0]}, {middle[0]}\n*NSET, NSET=pulled\n{middle[0]}\n"
        _, said = self.convert("cube.inp", deck(f"{sets}*BOUNDARY\nleft, 1, 3\npulled, 3, 3, 0.1\n", ""))
        self.assertIn("cube.inp: nodes in the middle of edges whose ends are not both in their set, and which no group of the mesh can have: middle (2 of 2), mixed (1 of 2)\n", said)
        many = "".join(f"*NSET, NSET=middle{k}\n{middle[0]}\n" for k in range(7))
        _, said = self.convert("cube.inp", deck(f"{many}*BOUNDARY\nleft, 1, 3\n", ""))
        self.assertIn("can have: middle0 (1 of 1), middle1 (1 of 1), middle2 (1 of 1), middle3 (1 of 1), middle4 (1 of 1), 2 others\n", said)


if __name__ == "__main__":
    unittest.main()
