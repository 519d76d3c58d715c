#!/usr/bin/python3
"""The page of `pliant check --html`: what it lists and shows of a model, by numbers and in a browser."""
import unittest

import numpy as np

from browser import CHROMIUM, Browser
from program import ProgramTest, write_box
from report_file import ReportFile

SIZE = (1.0, 0.2, 0.2)
INPUT = """
title: a bar & what acts on it
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1200 kg/m^3, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints:
  - {name: wall, surface: left, displacement: [0, free, "0.01 + 1e-3*t"]}
  - {surface: front, symmetry: plane}
loads:
  - {gravity: [0, 0, -9.81]}
  - {surface: top, pressure: "1000*min(t/0.05, 1)*(t < 0.08 ? 1 : 0.5)"}
  - {surface: right, traction: [300, 0, -500]}
  - {where: "x > 0.99", force: [0, 2, 0]}
contact:
  obstacles: [{name: floor, shape: plane, point: [0, 0, -0.05], normal: [0, 0, 1]}]
initial: {displacement: [0, 0, 0.01]}
time: {method: bdf2, step: 10 ms, end: 0.1}
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""


class Page:
    def __init__(self, file):
        self.file = ReportFile(file)
        self.model = self.file.json["model"]
        self.items = {}
        for item in self.model["items"]:
            points, vectors = (self.file.array(item[k], "f8").reshape(-1, 3) if k in item else None for k in ("points", "vectors"))
            order = np.lexsort(np.round(points, 9).T)
            self.items[item["kind"], item["name"]] = (item["text"], points[order], None if vectors is None else vectors[order])


class ModelPage(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "bar.msh", (10, 2, 2), SIZE)
        self.write("bar.yaml", INPUT)

    def check(self, *arguments, ranks=1, code=0):
        done = self.call("check", "bar.yaml", *arguments, ranks=ranks)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def test_what_it_lists(self):
        self.check("--html")
        page = Page(self.directory / "bar.html")
        self.assertEqual(sorted(p.name for p in self.directory.iterdir()), ["bar.html", "bar.msh", "bar.yaml"])
        kinds = [kind for kind, _ in page.items]
        self.assertEqual([kinds.count(kind) for kind in ("constraint", "load", "contact", "probe", "cells", "group")], [2, 4, 1, 1, 1, 7])

        text, points, _ = page.items["constraint", "wall (surface 'left')"]
        self.assertEqual((text, len(points)), ("displacement: [0, free, \"0.01 + 1e-3*t\"]", 9))
        np.testing.assert_allclose(points[:, 0], 0, atol=1e-15)
        np.testing.assert_allclose(sorted(set(np.round(points[:, 2], 9))), [0.01, 0.11, 0.21], atol=1e-9)

        _, points, forces = page.items["load", "the whole mesh"]
        np.testing.assert_allclose(forces, [[0, 0, -9.81 * 1200 * 0.04]], rtol=1e-12, atol=1e-12)
        text, _, forces = page.items["load", "surface 'top'"]
        self.assertIn("at 0.05 s, when it is largest", text)
        np.testing.assert_allclose(forces[:, 2].sum(), -1000 * 0.2, rtol=1e-9)
        text, _, forces = page.items["load", "surface 'right'"]
        self.assertEqual(text, "traction: [300, 0, -500]")
        np.testing.assert_allclose(forces.sum(axis=0), [300 * 0.04, 0, -500 * 0.04], rtol=1e-12)
        _, _, forces = next(item for (kind, name), item in page.items.items() if kind == "load" and name.startswith("where"))
        np.testing.assert_allclose(forces.sum(axis=0), [0, 2, 0], rtol=1e-12)

        text, points, _ = page.items["contact", "body with the obstacle floor"]
        self.assertIn("gap 0.06 m", text)
        self.assertAlmostEqual(points[0][2], 0.01, delta=1e-9)
        np.testing.assert_allclose(page.items["probe", "tip"][1], [[1, 0.1, 0.11]], rtol=1e-12)
        self.assertEqual(len(page.items["cells", "the worst 20 elements"][1]), 20)
        text, points, _ = page.items["group", "top"]
        self.assertEqual((text, len(points)), ("surface, 33 nodes", 33))
        self.assertTrue(any("neo-hookean" in line for line in page.model["lines"]))
        self.assertEqual([d["severity"] for d in page.model["diagnostics"]].count("warning"), 0)

    def test_a_force_on_a_rigid_body_is_one_arrow(self):
        rigid = "elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}"
        self.write("bar.yaml", INPUT.replace(rigid, "rigid: true").split("constraints:")[0] + """
loads: [{force: [0, 3, 0], volume: body}]
initial: {displacement: [0, 0, 0.01]}
time: {method: bdf2, step: 10 ms, end: 0.1}
""")
        for ranks in (1, 2):
            self.check("--html", ranks=ranks)
            _, points, forces = Page(self.directory / "bar.html").items["load", "volume 'body'"]
            np.testing.assert_allclose(points, [[0.5, 0.1, 0.11]], rtol=1e-9)
            np.testing.assert_allclose(forces, [[0, 3, 0]], atol=1e-9)

    def test_bodies_without_a_mesh(self):
        """Each body has its weight, where its mass is; surfaces that are attached are listed."""
        masses = "rigid_bodies: [{name: hub, mass: 2, inertia: [1, 1, 1], center: [1.5, 0.1, 0.3], attached: [right]}]\ninitial:"
        self.write("bar.yaml", INPUT.replace("initial:", masses).replace("  - {surface: front, symmetry: plane}\n", ""))
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.check("--html", ranks=ranks)
                items = Page(self.directory / "bar.html").items
                _, points, forces = items["load", "the whole mesh"]
                np.testing.assert_allclose(points, [[0.5, 0.1, 0.11], [1.5, 0.1, 0.31]], atol=1e-9)
                np.testing.assert_allclose(forces, [[0, 0, -9.81 * 1200 * 0.04], [0, 0, -9.81 * 2]], rtol=1e-9, atol=1e-9)
                self.assertEqual(len(items["constraint", "hub (surface 'right')"][1]), 9)

    def test_ranks(self):
        self.check("--html", "one.html")
        self.check("--html", "several.html", ranks=3)
        one, several = Page(self.directory / "one.html"), Page(self.directory / "several.html")
        self.assertEqual(list(one.items), list(several.items))
        for key, (text, points, vectors) in one.items.items():
            other_text, other_points, other_vectors = several.items[key]
            self.assertEqual(text, other_text)
            if key[0] != "cells":  # of equal quality there are more than twenty
                np.testing.assert_allclose(points, other_points, atol=1e-12, err_msg=str(key))
            if vectors is not None:
                np.testing.assert_allclose(vectors, other_vectors, atol=1e-9, err_msg=str(key))

    def test_mistakes(self):
        kept = self.directory / "bar.html.start"
        kept.mkdir()
        (kept / "notes.txt").write_text("of someone else")
        self.assertIn("bar.html.start' is needed", self.check("--html", code=4).stderr)
        self.assertEqual((kept / "notes.txt").read_text(), "of someone else")
        (self.directory / "file").write_text("")
        done = self.check("--html", "file/bar.html", code=4)
        self.assertIn("file/bar.html", done.stderr)

    @unittest.skipUnless(CHROMIUM, "needs the package chromium")
    def test_in_a_browser(self):
        self.check("--html")
        for size in ((1200, 900), (390, 800)):
            with self.subTest(size), Browser(size) as browser:
                browser.open(self.directory / "bar.html")
                browser.wait("document.documentElement?.dataset.ready === 'yes'")
                self.assertEqual(browser.evaluate("document.getElementById('title').textContent"), "a bar & what acts on it")
                self.assertTrue(browser.evaluate("document.querySelector('.transport').hidden"))
                shown = "window.pliant.items.all.filter((item) => item.group.visible).map((item) => item.kind)"
                self.assertEqual(set(browser.evaluate(shown)), {"constraint", "load", "contact", "probe"})
                before = np.asarray(browser.picture("#view"), dtype=int)
                boxes = browser.evaluate("[...document.querySelectorAll('.item input')].map((box) => '#' + box.id)")
                self.assertEqual(len(boxes), 16)
                for box in boxes:
                    if browser.evaluate(f"document.querySelector('{box}').checked"):
                        browser.click(box)
                self.assertEqual(browser.evaluate(shown), [])
                after = np.asarray(browser.picture("#view"), dtype=int)
                self.assertGreater((np.abs(after - before).max(axis=2) > 40).sum(), 200)
                self.assertEqual(browser.errors, [])


if __name__ == "__main__":
    unittest.main()
