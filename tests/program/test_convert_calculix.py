#!/usr/bin/python3
"""`pliant convert`: converted models have the results of CalculiX, version 2.20, whose numbers are stored here with the model they are of.

The models are written by the test, of quadratic tetrahedra and small displacements, so that both programs solve the same equations: a cube of
six elements. A number is the total force of `*NODE PRINT, NSET=left, TOTALS=ONLY`, `RF`, which has seven digits.
"""
import itertools
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
        for card, words in (("*TEMPERATURE\nleft, 120.\n", "*TEMPERATURE: the nodes of cube have different temperatures"), ("*TEMPERATURE, FILE=x\n", "*TEMPERATURE of a file or a subroutine")):
            _, said = self.convert("cube.inp", deck(before, card, "*ELASTIC\n1000., 0.3\n*EXPANSION\n1e-3\n"))
            self.assertIn(words, said)
            self.assertIn("not complete", said)
        config, said = self.convert("cube.inp", deck(before, "*TEMPERATURE\nall, 120.\n"))
        self.assertNotIn("not complete", said)
        self.assertNotIn("expansion", config["bodies"][0])


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
                            (f"*EQUATION\n2\nleft, 1, 1., somewhere, 1, 1.\n", "'somewhere' is not the name of a set of nodes"), ("*TRANSFORM, NSET=left\n1, 0, 0, 2, 0, 0\n", "\\*TRANSFORM: its two points"),
                            (f"*NSET, NSET=two\n{a}, {b}\n*EQUATION\n2\nleft, 1, 1., two, 1, 1.\n", "the sets of an equation have 9 and 2 nodes")):
            if words is not None:
                self.fails(deck(held + card, "*CLOAD\ntop, 1, 1.\n"), f"cube.inp:\\d+: {words}", "cube.inp")
            else:
                config, _ = self.convert("cube.inp", deck(card, "*CLOAD\ntop, 1, 1.\n"))
                self.assertEqual(sum("equation" in constraint for constraint in config["constraints"]), 9)

    def test_a_node_between_others(self):
        """A displacement of a node in the middle of an edge alone, which no group of the mesh has."""
        config, said = self.convert("cube.inp", deck(f"*BOUNDARY\nleft, 1, 3\n{NODES[2, 1, 0]}, 3, 3, 0.1\n", ""))
        self.assertNotIn("not complete", said)
        low, high = np.array(config["constraints"][-1]["box"], dtype=float)
        np.testing.assert_allclose((low + high) / 2, [1, 0.5, 0], atol=1e-12)


if __name__ == "__main__":
    unittest.main()
