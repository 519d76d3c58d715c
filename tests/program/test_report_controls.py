#!/usr/bin/python3
"""The controls of the page of `pliant report`, clicked and typed into as by its readers, against the numbers of the result."""
import io
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

import numpy as np
from PIL import Image

from browser import CHROMIUM, Browser
from program import ROOT, ProgramTest, box, write_box, write_mesh
from report_file import ReportFile

INPUT = """
title: a bar that sinks
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1200 kg/m^3, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 10 ms, end: 0.1}
output: {fields: [displacement, velocity, cauchy_stress]}
"""
NODE = shutil.which("node")


@unittest.skipUnless(CHROMIUM, "needs the package chromium")
class ReportControls(ProgramTest):
    page = None  # one for all tests

    def setUp(self):
        super().setUp()
        if ReportControls.page is None:
            write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2), order=2)
            self.run_input(self.write("bar.yaml", INPUT), "element=P2", output="sinking_bar")
            done = self.call("report", self.directory / "sinking_bar")
            self.assertEqual(done.returncode, 0, done.stderr)
            folder = pathlib.Path(tempfile.mkdtemp(prefix="pliant-controls-"))
            self.addClassCleanup(shutil.rmtree, folder)
            ReportControls.page = shutil.copy(self.directory / "sinking_bar/report.html", folder)
            ReportControls.data = ReportFile(ReportControls.page)

    def open(self, size=(900, 700), page=None):
        browser = Browser(size)
        self.addCleanup(browser.__exit__)
        browser.open(page or self.page)
        browser.wait("document.documentElement?.dataset.ready === 'yes'")
        self.addCleanup(lambda: self.assertEqual(browser.errors, []))
        return browser

    def positions(self, frame):
        shift = np.array(self.data.result["frames"][frame]["shift"])
        return self.data.positions(0) + self.data.field("displacement")[frame] + shift

    def on_screen(self, browser, vertex):
        """Where a vertex is in the window."""
        return browser.evaluate("""(v => { const { view } = pliant, p = view.camera.position.clone().fromArray(view.positions.array, 3 * v).project(view.camera);
            const { left, top, width, height } = view.canvas.getBoundingClientRect();
            return [left + (p.x + 1) / 2 * width, top + (1 - p.y) / 2 * height]; })(%d)""" % vertex)

    def test_keyboard_after_clicks(self):
        browser = self.open()
        now = lambda: browser.evaluate("pliant.player.time")
        is_playing = lambda: browser.evaluate("pliant.player.playing")
        # A button, a box, the scrubber, the picture: the keys are the player's again.
        for control in ("#play", "#show-edges", ".views button", "#scrub", "#view"):
            with self.subTest(control):
                browser.click(control)
                if is_playing():
                    browser.click("#play")
                browser.press("End")
                self.assertAlmostEqual(now(), 0.1)
                browser.press("ArrowLeft", "ArrowLeft", "ArrowRight")
                self.assertAlmostEqual(now(), 0.09)
                browser.press("Home")
                self.assertEqual(now(), 0)
                browser.press(" ")
                self.assertTrue(is_playing())
                browser.press(" ")
                self.assertFalse(is_playing())
        self.assertTrue(browser.evaluate("document.querySelector('#show-edges').checked"), "the space bar plays, and does not toggle")
        # A list with its menu open, or reached by the keyboard, has its keys.
        browser.press("End")
        browser.choose("#colour", "Velocity")
        self.assertIn("Velocity", browser.evaluate("document.querySelector('#legend').textContent"))
        self.assertAlmostEqual(now(), 0.1)
        browser.evaluate("document.querySelector('#show-outline').focus()")
        browser.press(" ")
        self.assertTrue(browser.evaluate("pliant.view.options.outline"))
        self.assertFalse(is_playing())
        # A field has what is typed, and gives the keys back after Enter.
        browser.click("#scale")
        browser.press("End", "0", "Home", "ArrowRight", "ArrowLeft", "2")
        self.assertEqual(browser.evaluate("document.querySelector('#scale').value"), "210")
        self.assertAlmostEqual(now(), 0.1)
        browser.press("Enter", "Home")
        self.assertEqual((browser.evaluate("pliant.view.options.scale"), now()), (210, 0))

    def test_numbers_that_are_refused(self):
        browser = self.open()
        state = lambda: browser.evaluate("(o => [o.scale, o.low, o.high])(pliant.view.options)")
        browser.enter("#scale", "2.5")
        before = state()
        self.assertEqual(before[0], 2.5)
        typed = [("#scale", text, word) for text, word in (("0", "above 0"), ("-1", "above 0"), ("1e99", "1e6"), ("e", "not a number"))]
        typed += [("#low", "1e9", "below the highest"), ("#high", "-1e9", "above the lowest"), ("#high", "e", "not a number"), ("#high", "1e99", "too large")]
        for field, text, word in typed:
            with self.subTest(field, text=text):
                old = browser.evaluate(f"document.querySelector('{field}').value")
                browser.enter(field, text)
                words = browser.evaluate("[...document.querySelectorAll('.refused')].filter(w => !w.hidden).map(w => w.textContent).join()")
                self.assertIn(word, words)
                self.assertIn(f"{old} is kept", words)
                self.assertEqual(browser.evaluate(f"document.querySelector('{field}').value"), old)
                self.assertEqual(state(), before)
                browser.enter(field, old)  # a good number takes the word away
                self.assertTrue(browser.evaluate("[...document.querySelectorAll('.refused')].every(w => w.hidden)"))
                before = state()

    def test_extremes(self):
        browser = self.open()
        browser.choose("#colour", "Displacement")
        browser.choose("#component", "z")
        browser.evaluate("pliant.player.seek(0.05)")
        browser.click("#show-extremes")
        z = self.data.field("displacement")[5, :, 2] + self.data.result["frames"][5]["shift"][2]
        low, high = browser.evaluate("pliant.points.extremes.map(e => [e.vertex, e.text])")
        for (vertex, text), value, word in ((low, z.min(), "min"), (high, z.max(), "max")):
            self.assertAlmostEqual(z[vertex], value, delta=1e-9)
            said, number, unit = text.replace("\u2212", "-").split()
            self.assertEqual((said, unit), (word, "mm"))
            self.assertAlmostEqual(float(number), 1e3 * value, delta=5e-3 * abs(1e3 * value) + 1e-3)
        # Where they stand on the page.
        for i, (vertex, _) in enumerate((low, high)):
            mark = browser.evaluate("(({ x, y, width }) => [x + width / 2, y + width / 2])(document.querySelectorAll('.extreme i')[%d].getBoundingClientRect())" % i)
            np.testing.assert_allclose(mark, self.on_screen(browser, vertex), atol=1)
        # They move with the time, and go with the switch.
        browser.press("Home")
        self.assertNotEqual(browser.evaluate("pliant.points.extremes.map(e => e.text).join()"), f"{low[1]},{high[1]}")
        browser.click("#show-extremes")
        self.assertEqual(browser.evaluate("document.querySelectorAll('.extreme').length"), 0)

    def test_extremes_of_stress_are_not_on_rigid_bodies(self):
        """They have none, and its zeros there are not the lowest stress; a displacement they have. The rigid end shares its nodes with the bar."""
        points, triangles, cells = box((8, 2, 2), (1, 0.2, 0.2))
        write_mesh(self.directory / "bar.msh", points, triangles, cells, (["body", "end"], (points[cells, 0].mean(axis=1) > 0.75).astype(int)))
        text = INPUT.replace("constraints:", "  - {volume: end, density: 1200, rigid: true}\nconstraints:").replace("end: 0.1", "end: 30 ms")
        for is_nodal in ("false", "true"):
            self.run_input(self.write("bar.yaml", text), f"output.nodal={is_nodal}")
            done = self.call("report", self.directory / "out")
            self.assertEqual(done.returncode, 0, done.stderr)
            report = ReportFile(self.directory / "out/report.html")
            bodies, stress = report.array(report.result["meshes"][0]["bodies"], "i4"), report.field("von_mises_stress")[-1]
            self.assertEqual(report.result["bodies"], ["body", "end"])
            self.assertEqual(np.abs(stress[bodies == 1]).max(), 0)
            self.assertGreater(stress[bodies == 0].max(), 100)
            browser = self.open(page=self.directory / "out/report.html")
            browser.evaluate("pliant.player.seek(0.03)")
            browser.click("#show-extremes")
            body_of = "pliant.points.extremes.map(e => pliant.bodies.names[pliant.bodies.surfaces[0].bodies[e.vertex]])"
            for name in ("Von Mises stress", "Mean stress"):
                browser.choose("#colour", name)
                self.assertEqual(browser.evaluate(body_of), ["body", "body"], name)
            self.assertNotIn("min 0 ", browser.evaluate("pliant.points.extremes.map(e => e.text + ' ').join()"))
            browser.choose("#colour", "Displacement")
            self.assertEqual(browser.evaluate(body_of)[1], "end")

    def test_times_have_the_unit_that_plots_have(self):
        """And room below the end of their axis."""
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2))
        for step, end, unit, last in (("50 us", "6 ms", "ms", "6"), ("10 ms", "0.2", "s", "0.2")):
            self.run_input(self.write("bar.yaml", INPUT.replace("step: 10 ms, end: 0.1", f"step: {step}, end: {end}")))
            self.assertEqual(self.call("report", self.directory / "out").returncode, 0)
            browser = self.open(page=self.directory / "out/report.html")
            labels = browser.evaluate("[...document.querySelectorAll('#plots .u-series:first-child')].map(e => e.textContent)")
            self.assertEqual({label.split("]")[0] for label in labels}, {f"time [{unit}"})
            self.assertTrue(all(label.endswith(last) for label in labels), labels)
            room = browser.evaluate("(() => { const box = document.querySelector('#plots .u-over'); return box.parentElement.clientWidth - box.offsetLeft - box.offsetWidth; })()")
            self.assertGreaterEqual(room, 20)

    def test_points(self):
        browser = self.open()
        plots = browser.evaluate("document.querySelectorAll('#plots figure').length")
        x = self.positions(10)
        corner = int(np.argmax(x @ [1, -1, 1]))  # next to the viewer
        browser.click(self.on_screen(browser, corner))
        browser.wait("pliant.points.picked.length === 1 && !document.querySelector('#points').hidden")
        picked = browser.evaluate("pliant.points.picked[0].vertex")
        self.assertLess(np.abs(x[picked] - x[corner]).max(), 1e-6)
        # Every field of the page, at the time that is shown.
        for frame in (10, 4):
            browser.evaluate("pliant.player.seek(%g)" % self.data.result["frames"][frame]["time"])
            browser.drawn()
            rows = browser.evaluate("[...document.querySelectorAll('#points tr')].slice(1).map(r => [...r.children].map(c => c.textContent.replaceAll('\\u2212', '-')))")
            factors = {"m": 1, "mm": 1e-3, "µm": 1e-6, "m/s": 1, "mm/s": 1e-3, "Pa": 1, "kPa": 1e3, "MPa": 1e6}
            found = {name: float(value) * factors[unit] for name, value, unit in rows}
            expected = {}
            for k, axis in enumerate("xyz"):
                expected[f"Position {axis}"] = self.positions(frame)[picked, k]
                expected[f"Displacement {axis}"] = (self.positions(frame) - self.data.positions(0))[picked, k]
                expected[f"Velocity {axis}"] = self.data.field("velocity")[frame, picked, k]
            expected["Von Mises stress"] = self.data.field("von_mises_stress")[frame, picked, 0]
            expected["Mean stress"] = self.data.field("mean_stress")[frame, picked, 0]
            self.assertEqual(found.keys(), expected.keys())
            for name, value in expected.items():
                self.assertAlmostEqual(found[name], value, delta=1e-3 * abs(value) + 1e-7, msg=name)
        # The history of the colours there.
        self.assertEqual(browser.evaluate("document.querySelectorAll('#plots figure').length"), plots + 1)
        drawn = browser.evaluate("(({ data }) => [[...data[0]], [...data[1]]])(pliant.points.plotted.chart)")
        history = self.data.field("von_mises_stress")[:, picked, 0]
        np.testing.assert_allclose(drawn[0], [frame["time"] for frame in self.data.result["frames"]])
        np.testing.assert_allclose(np.array(drawn[1]) * history.max(), history * max(drawn[1]), atol=1e-6 * history.max() * max(drawn[1]))
        # A drag rotates and picks nothing; a second click drops the point.
        place = self.on_screen(browser, corner)
        browser.call("Input.dispatchMouseEvent", type="mousePressed", x=place[0], y=place[1], button="left", clickCount=1)
        browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=place[0] + 40, y=place[1], button="left", buttons=1)
        browser.call("Input.dispatchMouseEvent", type="mouseReleased", x=place[0] + 40, y=place[1], button="left", clickCount=1)
        time.sleep(1)  # the rotation runs out
        self.assertEqual(browser.evaluate("pliant.points.picked.length"), 1)
        browser.click(self.on_screen(browser, picked))
        self.assertEqual(browser.evaluate("[pliant.points.picked.length, document.querySelectorAll('.picked').length, document.querySelector('#points').hidden]"), [0, 0, True])
        self.assertEqual(browser.evaluate("document.querySelectorAll('#plots figure').length"), plots)

    def test_points_wait_for_the_fields_of_their_rows(self):
        """Large results take a while to unpack, and the page draws meanwhile."""
        browser = self.open()
        corner = int(np.argmax(self.positions(10) @ [1, -1, 1]))
        browser.evaluate("""(bodies => { const need = bodies.need.bind(bodies);
            bodies.need = async (field) => { await new Promise(done => { pliant.unpack = [...(pliant.unpack ?? []), done]; }); return need(field); }; })(pliant.bodies)""")
        browser.click(self.on_screen(browser, corner))
        browser.wait("pliant.unpack?.length === pliant.bodies.fields.length")
        browser.evaluate("(pliant.view.set({}), pliant.view.render())")
        self.assertEqual(browser.evaluate("document.querySelector('#points').hidden"), True)
        browser.evaluate("pliant.unpack.forEach(done => done())")
        browser.wait("pliant.points.picked.length === 1 && !document.querySelector('#points').hidden")

    def test_cut(self):
        browser = self.open()
        browser.choose("#colour", "plain")
        whole = browser.picture("#view")
        grey = lambda picture: np.mean((np.ptp(picture, axis=2) < 24) & (picture.max(axis=2) < 215) & (picture.min(axis=2) > 120))
        x = self.positions(10)
        for axis, name in enumerate("xyz"):
            with self.subTest(name):
                browser.choose("#clip", f"Cut across {name}")
                cut = browser.picture("#view")
                self.assertGreater(grey(cut), grey(whole) + 2e-3, "the bar is solid where it is cut")
                low, high = self.range_of(axis)
                shown = browser.evaluate("[...Array(%d).keys()].map(v => pliant.view.isShown(pliant.view.at.surface, v))" % len(x))
                middle, away = (low + high) / 2, np.abs(x[:, axis] - (low + high) / 2) > 1e-3 * (high - low)
                side = np.array(shown)[away] == (x[away, axis] < middle)
                self.assertIn(side.mean(), (0, 1))
                browser.click("#clip-flip")
                flipped = browser.evaluate("[...Array(%d).keys()].map(v => pliant.view.isShown(pliant.view.at.surface, v))" % len(x))
                self.assertTrue(np.all(np.array(shown)[away] != np.array(flipped)[away]))
        # At the end of its way nothing, or all, is cut away.
        browser.evaluate("document.querySelector('#clip-place').focus()")
        browser.press("End")
        self.assertEqual(browser.evaluate("document.querySelector('#clip-place').value"), "1")
        browser.choose("#clip", "Cut along the screen")
        browser.choose("#clip", "No cut")
        self.assertLess(np.abs(browser.picture("#view") - whole).max(), 3)

    def range_of(self, axis):
        all_frames = [self.positions(k)[:, axis] for k in range(len(self.data.result["frames"]))]
        return min(map(np.min, all_frames)), max(map(np.max, all_frames))

    def test_colour_maps(self):
        browser = self.open()
        bar = lambda: browser.picture("#legend .bar")
        kind = lambda: browser.evaluate("pliant.view.kind")
        browser.choose("#colour", "Mean stress")  # tension above, pressure below
        self.assertEqual(kind(), "diverging")
        low, high = browser.evaluate("(o => [o.low, o.high])(pliant.view.options)")
        self.assertEqual(low, -high)
        middle = bar()[len(bar()) // 2, 6]
        self.assertGreater(middle.min(), 235)
        browser.enter("#low", "0")  # of one sign now
        self.assertEqual(kind(), "viridis")
        browser.choose("#map", "Map: blue")
        self.assertEqual(kind(), "diverging")
        picture = bar()
        self.assertGreater(picture[-4, 6].min(), 225, "white at zero, the lower end")
        self.assertGreater(picture[4, 6, 0], picture[4, 6, 2] + 60, "red above it")
        # The body has them too.
        def green():
            r, g, b = np.moveaxis(browser.picture("#view")[:-120, :-150], 2, 0)
            return np.mean((g > r + 40) & (g > b + 20))

        browser.choose("#map", "Map: viridis")
        with_greens = green()
        browser.choose("#map", "Map: cividis")
        ends = bar()[[-4, 4], 6]
        self.assertGreater(ends[0, 2], ends[0, 0] + 60)
        self.assertGreater(ends[1, 0], ends[1, 2] + 100)
        self.assertLess(green(), 0.02 * with_greens)

    def test_views_and_pace(self):
        browser = self.open()
        views = {"front": [0, -1, 0], "back": [0, 1, 0], "left": [-1, 0, 0], "right": [1, 0, 0], "top": [0, 0, 1], "bottom": [0, 0, -1]}
        names = browser.evaluate("[...document.querySelectorAll('.views button')].map(b => b.textContent)")
        for name, direction in views.items():
            browser.evaluate(f"[...document.querySelectorAll('.views button')][{names.index(name)}].id = 'wanted-{name}'")
            browser.click(f"#wanted-{name}")
            seen = np.array(browser.evaluate("pliant.view.direction()"))
            np.testing.assert_allclose(seen / np.linalg.norm(seen), direction, atol=0.02)
        # 0.1 s in the three seconds that a short run takes.
        pace = lambda: browser.evaluate("document.querySelector('#pace').textContent")
        self.assertEqual(pace(), "1/30 of real time")
        browser.choose("#speed", "0.5")
        self.assertEqual(pace(), "1/60 of real time")

    def test_saved_pictures_and_videos(self):
        browser = self.open()
        browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.directory))

        def saved(name):
            end = time.monotonic() + 30
            while not (self.directory / name).exists() or not (self.directory / name).stat().st_size:
                self.assertLess(time.monotonic(), end, sorted(p.name for p in self.directory.iterdir()))
                time.sleep(0.1)
            return (self.directory / name).read_bytes()

        browser.evaluate("pliant.player.seek(0.05)")
        browser.click("#save-picture")
        picture = np.asarray(Image.open(io.BytesIO(saved("sinking_bar_t50ms.png"))).convert("RGB")).astype(int)
        width, height = browser.evaluate("(c => [c.clientWidth, c.clientHeight])(pliant.view.canvas)")
        self.assertLessEqual(abs(picture.shape[1] - width) + abs(picture.shape[0] - height), 2)
        self.assertLess(picture[10:60, 10:160].min(), 100, "title and time")
        legend = picture[40:230, -36:-24]
        self.assertGreater(np.ptp(legend[..., 0]), 120, "the colour bar")
        self.assertGreater(np.mean(np.ptp(picture[60:, :-150], axis=2) > 60), 0.02, "the bar")
        # The video has each of its pictures: 0.75 s of them, and 0.3 s of the last.
        browser.choose("#speed", "4")
        browser.click("#save-video")
        browser.wait("document.querySelector('#save-video').textContent.startsWith('Stop')")
        browser.wait("document.querySelector('#save-video').textContent === 'Video'", 120)
        video = saved("sinking_bar.webm")
        self.assertEqual(video[:4], b"\x1a\x45\xdf\xa3")
        self.assertAlmostEqual(browser.evaluate("pliant.player.time"), 0.1)
        self.write("video.html", "<video src=sinking_bar.webm muted></video>")
        browser.open(self.directory / "video.html")
        browser.wait("document.querySelector('video')?.readyState >= 2")
        length, *size = browser.evaluate("(v => [v.duration, v.videoWidth, v.videoHeight])(document.querySelector('video'))")
        self.assertAlmostEqual(length, 33 / 30, delta=0.02)
        self.assertEqual(size, [picture.shape[1], picture.shape[0]])
        pictures = []
        for second in (0.02, 1.05):
            browser.evaluate("new Promise(done => { const v = document.querySelector('video'); v.onseeked = done; v.currentTime = %g; })" % second)
            browser.drawn()
            pictures.append(browser.picture("video"))
        self.assertGreater(np.mean(np.abs(pictures[0] - pictures[1]).max(axis=2) > 60), 0.01, "the bar has moved")
        self.assertGreater(np.ptp(pictures[1][..., 0]), 120)

    def test_what_pages_of_shells_open_with(self):
        """A field that shells have, and what they consist of."""
        (self.directory / "flag.msh").write_text("""$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
2 1 "flag"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
$EndNodes
$Elements
2
1 2 2 1 1 1 2 3
2 2 2 1 1 1 3 4
$EndElements
""", encoding="ascii")
        text = """mesh: {file: flag.msh}
shells: [{surface: flag, name: flag, free: true, thickness: 1 mm, density: 1000, bending: true,
          elasticity: {model: saint-venant-kirchhoff, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
constraints: [{where: "x < 1e-9", displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -1]}]
time: {method: bdf2, step: 10 ms, end: 0.02}
output: {fields: [displacement, von_mises_stress, FIELD]}
"""
        for field, opens in (("velocity", "displacement"), ("principal_membrane_force", "principal_membrane_force_1")):
            self.run_input(self.write("flag.yaml", text.replace("FIELD", field).replace("von_mises_stress, ", "")), output="flag")
            self.assertEqual(self.call("report", self.directory / "flag").returncode, 0)
            browser = self.open(page=self.directory / "flag/report.html")
            self.assertEqual(browser.evaluate("pliant.bodies.fields[pliant.panel.colour.value].name"), opens)
            self.assertTrue(browser.evaluate("document.getElementById('facts').textContent").startswith("2 triangles of shells  ·  bdf2  ·  "))

    def test_loads_have_no_seconds(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1, 0.2, 0.2))
        static = INPUT.replace("method: bdf2, step: 10 ms, end: 0.1", "method: static, load_steps: 4").replace("velocity, ", "")
        self.run_input(self.write("bar.yaml", static), output="bent")
        self.assertEqual(self.call("report", self.directory / "bent").returncode, 0)
        browser = self.open(page=self.directory / "bent/report.html")
        browser.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.directory))
        self.assertEqual(browser.evaluate("document.querySelector('.clock').textContent"), "load 1.00")
        self.assertEqual(set(browser.evaluate("[...document.querySelectorAll('#plots .u-series:first-child .u-label')].map(e => e.textContent)")), {"load factor"})
        browser.press("ArrowLeft")
        browser.click("#save-picture")
        end = time.monotonic() + 30
        while not (self.directory / "bent_load0.75.png").exists():
            self.assertLess(time.monotonic(), end)
            time.sleep(0.1)

    def test_forces_that_balance_are_not_plotted(self):
        """A closed chamber pulls at its mount by rounding alone; the force on an obstacle's only body is that of the obstacle."""
        self.write("hollow.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1}; Box(2) = {0.3, 0.3, 0.3, 0.4, 0.4, 0.4};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
e = 1e-6;
Physical Volume("body") = {3};
Physical Surface("mount") = Surface In BoundingBox {-e, -e, 1-e, 1+e, 1+e, 1+e};
Physical Surface("inside") = Surface In BoundingBox {0.3-e, 0.3-e, 0.3-e, 0.7+e, 0.7+e, 0.7+e};
Mesh.MeshSizeMax = 0.4;
""")
        text = """mesh: {file: hollow.geo}
bodies: [{volume: body, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}]
constraints: [{surface: mount, displacement: [0, 0, 0]}]
cavities: [{name: inside, surface: inside, pressure: 20 kPa}]
time: {method: static, load_steps: 2}
"""
        floor = "contact: {obstacles: [{name: floor, shape: plane, point: [0, 0, -0.001], normal: [0, 0, 1]}]}\n"
        for more, expected in (("", set()), (floor, {"Force at mount", "Torque at mount", "Force at floor"})):
            self.run_input(self.write("hollow.yaml", text + more), output="hollow")
            self.assertEqual(self.call("report", self.directory / "hollow").returncode, 0)
            browser = self.open(page=self.directory / "hollow/report.html")
            self.assertEqual(browser.evaluate("document.title"), "hollow")  # without a title, that of the directory
            titles = browser.evaluate("[...document.querySelectorAll('#plots figure')].map(e => e.textContent)")
            found = {title.split(" [")[0].strip() for title in titles if title.strip().startswith(("Force at", "Torque at"))}
            self.assertEqual(found, expected)

    def test_fibres_and_vessels(self):
        """A fibre is not a body; walls of an obstacle that bodies are inside of hide nothing; a field that is 0 has one number."""
        self.write("bar.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 0.05, 0.01, 0.01};
Point(101) = {0, 0.005, 0.005}; Point(102) = {0.05, 0.005, 0.005};
Line(101) = {101, 102};
BooleanFragments{ Volume{1}; Delete; }{ Curve{101}; Delete; }
Physical Volume("bar") = {1};
Physical Curve("line") = {101};
Mesh.MeshSizeMax = 0.008;
""")
        self.run_input(self.write("in.yaml", """mesh: {file: bar.geo}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}]
rods: [{name: fibre, curve: line, radius: 0.05 mm, youngs_modulus: 1 GPa, poissons_ratio: 0.3, density: 7800}]
loads: [{gravity: [0, 0, -9.81]}]
contact: {obstacles: [{name: vessel, shape: box, point: [0.025, 0.005, 0.02], size: [90 mm, 60 mm, 70 mm], side: inside},
                      {name: ball, shape: sphere, point: [0, 0.2, 0], radius: 0.02}]}
time: {method: bdf2, step: 1 ms, end: 2 ms}
output: {fields: [displacement, contact_pressure, rod_force]}
"""), output="run")
        self.assertEqual(self.call("report", "run").returncode, 0)
        browser = self.open(page=self.directory / "run/report.html")
        names = lambda query: browser.evaluate(f"[...document.querySelectorAll('{query}')].map(e => e.textContent)")
        self.assertEqual(names(".bodies .row > span"), ["vessel", "ball", "fibre, rod"])
        self.assertEqual(names("#colour option"), ["plain", "Tension of lines", "Displacement", "Contact pressure"])
        self.assertEqual(browser.evaluate("pliant.view.obstacles.parts[0].shapes.map(shape => shape.kind)"), ["vessel", "closed"])
        draw = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        pictures = []
        for look in ("hidden", "solid", "transparent"):
            browser.evaluate("(() => { const c = document.querySelector('#obstacle-0'); c.value = '%s'; c.onchange(); })()" % look)
            browser.evaluate(draw)
            pictures.append(browser.picture("#view").astype(int))
        bare, solid, clear = pictures
        height, width = bare.shape[:2]
        middle = np.s_[height // 2 - 20:height // 2 + 20, width // 2 - 60:width // 2 + 20]  # of the bar
        for walls in (solid, clear):
            np.testing.assert_allclose(walls[middle], bare[middle], atol=2)
            self.assertGreater(np.mean(np.abs(walls - bare).max(axis=2) > 8), 0.2)
        browser.evaluate("pliant.panel.colour.value = '1', pliant.panel.paint()")
        browser.evaluate(draw)
        self.assertEqual(names("#legend .marks span"), ["0"])
        browser.evaluate("pliant.panel.colour.value = '0', pliant.panel.paint()")
        browser.evaluate(draw)
        self.assertGreater(len(names("#legend .marks span")), 2)

    def test_arrows(self):
        browser = self.open()
        browser.choose("#colour", "plain")
        browser.choose("#arrows", "Arrows: displacement")
        browser.wait("pliant.view.arrows.mesh?.count > 20")
        lengths = """(() => { const { mesh } = pliant.view.arrows, found = [];
            for (let i = 0; i < mesh.count; ++i) { const m = mesh.instanceMatrix.array.subarray(16 * i, 16 * i + 16); found.push([...m.subarray(12, 15), ...m.subarray(4, 7)]); }
            return found; })()"""
        arrows, origin = np.array(browser.evaluate(lengths)), np.array(browser.evaluate("pliant.view.origin"))
        x, u = self.positions(10), self.positions(10) - self.data.positions(0)
        size = np.linalg.norm(self.data.positions(0).max(axis=0) - self.data.positions(0).min(axis=0))
        for arrow in arrows:
            vertex = np.argmin(np.linalg.norm(x - origin - arrow[:3], axis=1))
            self.assertLess(np.linalg.norm(x[vertex] - origin - arrow[:3]), 1e-5)
            along = u[vertex] / np.linalg.norm(u[vertex])
            self.assertGreater(arrow[3:] @ along, 0.999 * np.linalg.norm(arrow[3:]))
        longest = np.linalg.norm(arrows[:, 3:], axis=1).max()
        self.assertAlmostEqual(longest, 0.18 * size, delta=0.02 * size)
        self.assertIn("arrows: displacement up to", browser.evaluate("document.querySelector('#legend').textContent"))
        browser.enter("#arrow-scale", "2")
        self.assertAlmostEqual(np.linalg.norm(np.array(browser.evaluate(lengths))[:, 3:], axis=1).max(), 2 * longest, delta=1e-3 * longest)
        with_arrows = browser.picture("#view")
        browser.choose("#arrows", "No arrows")
        self.assertGreater(np.mean(np.abs(browser.picture("#view") - with_arrows).max(axis=2) > 60), 2e-3)

    @unittest.skipUnless(NODE, "needs the package nodejs")
    def test_numbers(self):
        script = """import { handyUnit, paceText } from "%s";
            console.log(JSON.stringify([[["m^3", 2e-9], ["m^3", 5e-6], ["m^3", 2], ["m^2", 3e-5], ["m", 0.02], ["Pa", 2e5]].map(([u, x]) => handyUnit(u, x)[1]),
                                        [1 / 6, 1, 4, 0.004, 0.55].map(paceText)]));""" % (ROOT / "src/viewer/numbers.js").as_uri()
        done = subprocess.run([NODE, "--input-type=module", "-e", script], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), '[["mm^3","cm^3","m^3","mm^2","mm","kPa"],'
                         '["1/6 of real time","real time","4 × real time","1/250 of real time","1/1.8 of real time"]]')


if __name__ == "__main__":
    unittest.main()
