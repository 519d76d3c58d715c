#!/usr/bin/python3
"""`pliant report RUN RUN`: two runs on one page, with one camera, one time and one range of colours."""
import shutil
import unittest

import numpy as np

from browser import CHROMIUM, Browser
from program import ProgramTest, write_box

INPUT = """
title: a bar
mesh: {{file: {mesh}.msh}}
bodies:
  - {{volume: body, density: 1200 kg/m^3, elasticity: {{model: neo-hookean, youngs_modulus: {young}, poissons_ratio: 0.4}}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [{{gravity: [0, 0, -9.81]}}]
time: {{method: bdf2, step: 10 ms, end: {end}}}
output: {{fields: [{fields}]}}
probes: [{{name: tip, point: [1, 0.1, 0.1]}}]
"""
CAMERA = """(v => [...v.camera.position.toArray().map((x, k) => x + v.origin[k]), ...v.controls.target.toArray().map((x, k) => x + v.origin[k]),
               ...v.camera.quaternion.toArray()])"""


@unittest.skipUnless(CHROMIUM, "chromium is not installed")
class Pair(ProgramTest):
    def setUp(self):
        super().setUp()
        write_box(self.directory / "coarse.msh", (4, 1, 1), (1, 0.2, 0.2))
        write_box(self.directory / "fine.msh", (6, 2, 2), (1.2, 0.2, 0.2))
        for name, mesh, young, end, fields in (("stiff", "coarse", "1 MPa", 0.1, "displacement, velocity, von_mises_stress"),
                                               ("soft", "fine", "0.5 MPa", 0.06, "displacement, von_mises_stress")):
            self.write(f"{name}.yaml", INPUT.format(mesh=mesh, young=young, end=end, fields=fields))
            self.pliant("run", f"{name}.yaml", "--quiet", "--output", f"out/{name}")
        done = self.pliant("report", "out/stiff", "out/soft")
        self.assertRegex(done.stdout, r"out/stiff/comparison.html: \d+\.\d MB, 11 of 11 and 7 of 7 frames; open it in a browser")
        self.page = self.directory / "out/stiff/comparison.html"

    def opened(self, *size):
        browser = Browser(size)
        self.addCleanup(browser.__exit__)
        browser.open(self.page)
        browser.wait('document.documentElement?.dataset.ready === "yes"')
        return browser

    def cameras(self, browser):
        browser.drawn()
        return [np.array(browser.evaluate(f"{CAMERA}({view})")) for view in ("pliant.view", "pliant.second.view")]

    def same_camera(self, browser):
        first, second = self.cameras(browser)
        np.testing.assert_allclose(first, second, atol=1e-6)
        return first

    def drag(self, browser, selector):
        x, y, width, height = browser.evaluate(f"(r => [r.x, r.y, r.width, r.height])(document.querySelector('{selector}').getBoundingClientRect())")
        at = [x + width / 2, y + height / 3]
        for kind, shift in (("mousePressed", 0), ("mouseMoved", 30), ("mouseMoved", 60), ("mouseReleased", 60)):
            browser.call("Input.dispatchMouseEvent", type=kind, x=at[0] + shift, y=at[1] + shift / 3, button="left", buttons=1, clickCount=1)
        browser.evaluate("new Promise(done => setTimeout(done, 600))")  # it glides on

    def test_one_camera_one_time_one_range(self):
        browser = self.opened(1280, 900)
        before = self.same_camera(browser)
        for view in ("#view", "#view-2"):
            self.drag(browser, view)
            after = self.same_camera(browser)
            self.assertGreater(np.abs(after - before).max(), 0.05, view)
            before = after
        browser.click('button[title="towards +y"]')
        self.assertGreater(np.abs(self.same_camera(browser) - before).max(), 0.05)
        self.assertRegex(browser.evaluate("document.getElementById('facts').textContent"), r"^stiff: .*11 frames\nsoft: .*7 frames$")
        # Both bodies are seen whole.
        for name in ("view", "second.view"):
            reach = browser.evaluate(f"""(v => Math.max(...v.cloud().flatMap(p => {{ const q = p.clone().project(v.camera); return [Math.abs(q.x), Math.abs(q.y)]; }})))(pliant.{name})""")
            self.assertLess(reach, 1, name)
        # The slider goes to the end of the longer run; the shorter one stays where it ended.
        self.assertEqual(browser.evaluate("Number(document.getElementById('scrub').max)"), 0.1)
        for time, frame, name in ((0.03, 3, "soft"), (0.06, 6, "soft"), (0.1, 6, "soft · ended at 60 ms")):
            browser.evaluate(f"pliant.player.seek({time})")
            browser.drawn()
            self.assertEqual(browser.evaluate("['name', 'name-2'].map(id => document.getElementById(id).textContent)"), ["stiff", name])
            self.assertEqual(browser.evaluate("[pliant.view.options.time, pliant.second.view.options.time, pliant.second.view.at.frame]"), [time, time, frame])
        low, high = browser.evaluate("[pliant.panel.shown.low, pliant.panel.shown.high]")
        ranges = browser.evaluate("""[pliant.view, pliant.second.view].map(v => [v.bodies.fields[v.options.field].name, v.options.low, v.options.high])""")
        self.assertEqual(ranges, [["von_mises_stress", low, high]] * 2)
        own = browser.evaluate("(b => b.range(b.fields.findIndex(f => f.name === 'von_mises_stress'), 0).high)(pliant.second.bodies)")
        self.assertGreaterEqual(high, own)
        # A field that only one run has leaves the other one plain.
        browser.choose("#colour", "Velocity")
        browser.drawn()
        self.assertEqual(browser.evaluate("[pliant.view, pliant.second.view].map(v => Boolean(v.materials.body.map))"), [True, False])
        browser.choose("#clip", "Cut across x")
        planes = browser.evaluate("[pliant.view, pliant.second.view].map(v => [...v.clip.plane.normal.toArray(), v.clip.plane.constant - v.clip.plane.normal.x*v.origin[0]])")
        np.testing.assert_allclose(planes[0], planes[1], atol=1e-9)
        self.assertEqual(browser.errors, [])

    def test_what_surrounds_them(self):
        browser = self.opened(1280, 900)
        self.assertEqual(browser.evaluate("['name', 'name-2'].map(id => document.getElementById(id).textContent)"), ["stiff", "soft · ended at 60 ms"])
        text = browser.evaluate("document.getElementById('differences').innerText")
        self.assertRegex(text, r"(?s)stiff.*youngs_modulus: 1000000.*soft.*youngs_modulus: 500000")
        self.assertNotIn("directory", text)
        # Each plot has the lines of both runs, over the times of both.
        labels = browser.evaluate("[...document.querySelectorAll('.u-legend .u-label')].map(l => l.textContent).filter(t => t.startsWith('z '))")
        self.assertEqual(labels[:2], ["z · stiff", "z · soft"])
        browser.evaluate("pliant.view.aim([0, -1, 0])")
        browser.drawn()
        place = browser.evaluate("""(v => { const r = v.canvas.getBoundingClientRect(), all = v.cloud().map(p => p.project(v.camera)), mean = k => all.reduce((s, p) => s + p[k], 0) / all.length;
            return [r.x + (mean("x") + 1) / 2 * r.width, r.y + (1 - mean("y")) / 2 * r.height]; })(pliant.second.view)""")
        browser.click(place)
        self.assertEqual(browser.evaluate("[pliant.points.picked.length, pliant.second.points.picked.length]"), [0, 1])
        browser.wait("document.querySelector('#points-2 td') !== null")
        self.assertTrue(browser.evaluate("[...document.querySelectorAll('figcaption b')].some(b => b.textContent.startsWith('soft: '))"))
        # The picture has both.
        size = browser.evaluate("(c => [c.width, c.height, pliant.view.canvas.width])(pliant.picture.compose())")
        self.assertAlmostEqual(size[0], 2 * size[2], delta=2)
        self.assertEqual(browser.errors, [])

    def test_on_a_telephone(self):
        """One above the other, without a horizontal scroll bar; both are drawn."""
        browser = self.opened(390, 844)
        one, two = browser.evaluate("['view', 'view-2'].map(id => (r => [r.left, r.top, r.right, r.bottom])(document.getElementById(id).getBoundingClientRect()))")
        self.assertGreaterEqual(two[1], one[3])
        self.assertEqual((one[0], one[2]), (two[0], two[2]))
        self.assertLessEqual(browser.evaluate("document.documentElement.scrollWidth"), 390)
        # The legend is in the part of the view that the bodies leave to it, whatever its title.
        for field in ("Von Mises stress", "Displacement"):
            browser.choose("#colour", field)
            self.assertLess(browser.evaluate("document.getElementById('legend').getBoundingClientRect().width"), 0.22 * (two[2] - two[0]))
            self.assertLessEqual(browser.evaluate("(l => l.scrollWidth - l.clientWidth)(document.querySelector('#legend .label'))"), 0)
        for name in ("view", "second.view"):
            used = browser.evaluate(f"""(c => {{ const k = Object.assign(document.createElement('canvas'), {{ width: c.width, height: c.height }}).getContext('2d');
                k.drawImage(c, 0, 0); return k.getImageData(0, 0, c.width, c.height).data.filter((a, i) => i % 4 === 3 && a > 0).length / c.width / c.height; }})(pliant.{name}.canvas)""")
            self.assertGreater(used, 0.01, name)
        self.same_camera(browser)
        self.assertEqual(browser.errors, [])

    def test_errors(self):
        done = self.call("report", "out/stiff", "out/missing")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1), done.stderr)
        self.assertIn("missing", done.stderr)
        done = self.call("report", "out/stiff/history.csv")
        self.assertEqual((done.returncode, done.stderr), (4, "'out/stiff/history.csv' is not a result: give the directory of the run\n"))

LARGE = """
title: a plate that falls
mesh: {file: plate.msh}
bodies: [{volume: body, density: 1200 kg/m^3, rigid: true}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 10 ms, end: 0.3}
output: {fields: [displacement]}
"""


def bulged(x):
    """A plane side would be drawn by few triangles."""
    return x + np.stack([0 * x[..., 0], 0 * x[..., 0], 0.1 * np.sin(np.pi * x[..., 0]) * np.sin(np.pi * x[..., 1])], axis=-1)


@unittest.skipUnless(CHROMIUM, "chromium is not installed")
class LargePair(ProgramTest):
    def test_more_points_than_a_function_takes_arguments(self):
        """The camera looks at samples of all frames of both runs: here more than Chromium passes to a function."""
        write_box(self.directory / "plate.msh", (35, 35, 1), (1, 1, 0.02), shape=bulged)
        self.write("plate.yaml", LARGE)
        self.pliant("run", "plate.yaml", "--quiet", "--output", "out/one")
        shutil.copytree(self.directory / "out/one", self.directory / "out/two")
        self.pliant("report", "out/one", "out/two")
        with Browser((1280, 900)) as browser:
            browser.open(self.directory / "out/one/comparison.html")
            browser.wait('document.documentElement?.dataset.ready === "yes" || !(document.getElementById("trouble")?.hidden ?? true)')
            self.assertEqual(browser.evaluate("document.getElementById('trouble').textContent"), "")
            self.assertEqual(browser.evaluate("(points => { try { return Math.max(...points); } catch (error) { return error.name; } })(pliant.view.cloud().map(() => 1))"),
                             "RangeError")
            # Both are seen whole, in a box around what they fall through.
            self.assertAlmostEqual(browser.evaluate("pliant.view.sceneSize"), np.hypot(np.sqrt(2), 9.81 * 0.3**2 / 2), delta=0.01)
            browser.choose("#clip", "Cut across x")
            self.assertAlmostEqual(browser.evaluate("pliant.view.clip.high - pliant.view.clip.low"), 1, places=3)
            self.assertEqual(browser.errors, [])


if __name__ == "__main__":
    unittest.main()
