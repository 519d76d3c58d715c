#!/usr/bin/python3
"""`pliant report`: what the page carries is what the result holds, and a browser shows and plays it."""
import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import h5py
import numpy as np

from browser import CHROMIUM, Browser
from program import ProgramTest, finish, read_history, start, write_box
from report_file import ReportFile

INPUT = """
title: "a bar </script> & <b>more</b>"
mesh: {file: bar.msh}
bodies:
  - {volume: body, density: 1200 kg/m^3, elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
contact:
  obstacles:
    - {name: ball, shape: sphere, point: [0.9, 0.1, -0.25], radius: 0.1, motion: {translate: [0, 0, "-0.2*t"]}}
time: {method: bdf2, step: 10 ms, end: 0.1}
output: {fields: [displacement, velocity, cauchy_stress]}
probes: [{name: tip, point: [1, 0.1, 0.1]}]
"""

BLOCKS = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 1};
Box(2) = {-1, -1, 1.005, 2, 2, 2};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = {5};
Mesh.MeshSizeMax = 0.7;
"""
TOUCHING = """
mesh: {file: blocks.geo, scale: 0.01}
bodies:
  - {volume: base, density: 1000, elasticity: &soft {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}}
  - {volume: block, density: 1000, elasticity: *soft}
constraints: [{surface: floor, displacement: [0, 0, 0]}]
initial: {velocity: [0, 0, "z > 0.01001 ? -0.5 : 0"]}
contact:
  law: barrier
  pairs: all
  obstacles:
    - {name: ground, shape: plane, point: [0, 0, -0.001], normal: [0, 0, 1]}
    - {name: "post", shape: cylinder, point: [0.03, 0, 0.01], axis: [0, 0, 1], radius: 5 mm, length: 30 mm}
time: {method: backward-euler, step: 1 ms, end: 4 ms}
output: {fields: [displacement, contact_pressure, contact_gap, contact_slip]}
"""


def replaced(path, values):
    """Other numbers in the place of a dataset, with its attributes."""
    def change(file):
        attributes = dict(file[path].attrs)
        del file[path]
        file[path] = values
        file[path].attrs.update(attributes)
    return change


def without_displacement(file):
    for frame in file["frames"].values():
        frame["displacement"][...] = np.nan


# Name: what is done to the file, what `report` says of it, what `info` says (none: it does not look so far).
DAMAGE = {
    "no mesh": (lambda file: file.__delitem__("mesh"), "cannot open '/mesh'", "cannot read 'mesh/c"),
    "no frames": (lambda file: [file["frames"].__delitem__(name) for name in list(file["frames"])], "holds no frame yet", None),
    "no numbers": (without_displacement, "no frame with a finite displacement", None),
    "another format": (lambda file: file.attrs.__setitem__("format", np.bytes_("mine")), "is not a result of Pliant", "neither a checkpoint nor a result"),
    "of another version": (lambda file: file.attrs.__setitem__("version", 2), *2 * ["has version 2 of the format, but this program reads version 1"]),
    "a format of numbers": (lambda file: file.attrs.__setitem__("format", 7), "'format': it is not a text", "'format': it is not a text"),
    "two times": (lambda file: file["frames/000010"].attrs.__setitem__("time", [1.0, 2.0]), "'time': it has another size", "'time': it has another size"),
    "one number": (replaced("mesh/coordinates", 3.0), "'coordinates': it is not a table", "it is one number, not a table"),
    "two coordinates": (replaced("mesh/coordinates", np.zeros((9, 2))), "it has 2 columns, not 3", None),
    "unknown nodes": (replaced("mesh/cells", np.full((192, 10), 1 << 40)), "the mesh '/mesh' .*is damaged", None),
    "few values": (replaced("frames/000003/displacement", np.zeros((5, 3))), "'displacement' of frame '000003' is damaged", None),
    "few values of cells": (replaced("frames/000010/cauchy_stress", np.zeros((5, 6))), "'cauchy_stress' of frame '000010' is damaged", None),
    "unknown corners": (replaced("obstacles/triangles", np.full((4, 3), 1 << 40)), "the obstacles .*are damaged", None),
    "triangles of nobody": (replaced("obstacles/obstacle", np.full((4, 1), 7, dtype="i4")), "the obstacles .*are damaged", None),
    "few corners": (replaced("obstacles/frames/000003/points", np.zeros((5, 3))), "obstacles of frame '000003' are damaged", None),
}


class Report(ProgramTest):
    finished = None  # a directory with its result

    def setUp(self):
        super().setUp()
        self.out = self.directory / "out"
        if Report.finished is None:  # one run for all tests
            write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2), order=2)
            self.run_input(self.write("bar.yaml", INPUT), "element=P2")
            Report.finished = pathlib.Path(tempfile.mkdtemp(prefix="pliant-report-"))
            self.addClassCleanup(shutil.rmtree, Report.finished)
            shutil.copytree(self.out, Report.finished, dirs_exist_ok=True)
        else:
            shutil.copytree(Report.finished, self.out)

    def report(self, *more):
        done = self.call("report", self.out, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return ReportFile(more[1] if more else self.out / "report.html")

    def test_numbers_of_the_result(self):
        report = self.report()
        self.assertIn("open it in a browser", self.call("report", self.out / "result.xdmf").stdout)
        self.assertEqual(report.json["title"], 'a bar </script> & <b>more</b>')
        self.assertEqual(report.json["input"], (self.out / "run.yaml").read_text())
        self.assertEqual(report.json["summary"], json.loads((self.out / "summary.json").read_text()))
        self.assertEqual(report.json["summary"]["outcome"], "done")
        self.assertEqual(report.json["summary"]["steps"]["accepted"], 10)
        with h5py.File(self.out / "result.h5") as h5:
            nodes, frames = h5["mesh/coordinates"][()], list(h5["frames"].values())
            x = report.positions(0)
            self.assertEqual(report.result["meshes"][0]["perFacet"], 4)
            self.assertEqual(report.triangles(0).shape, (4 * 2 * (4 * 8 * 2 + 2 * 2 * 2), 3))
            # Each vertex lies at a node, to a half of the step of quantisation.
            distances = np.abs(x[:, None, :] - nodes[None]).max(axis=2)
            node = distances.argmin(axis=1)
            self.assertLess(distances.min(axis=1).max(), 0.51 / 65535)
            self.assertEqual(len(np.unique(node)), len(np.unique(nodes[report_surface(nodes)], axis=0)))
            shift = np.array([frame["shift"] for frame in report.result["frames"]])
            u = report.field("displacement") + shift[:, None, :]
            v = report.field("velocity")
            for k, frame in enumerate(frames):
                self.assertEqual(report.result["frames"][k]["time"], frame.attrs["time"])
                given = frame["displacement"][()]
                self.assertLess(np.abs(u[k] - given[node]).max(), 0.51 / 16383 * np.ptp(u[..., 2]) + 1e-7)
                self.assertLess(np.abs(v[k] - frame["velocity"][()][node]).max(), 0.51 / 1023 * np.ptp(v[..., 2]) + 1e-6)
            names = [field["name"] for field in report.result["fields"]]
            self.assertEqual(names, ["displacement", "von_mises_stress", "mean_stress", "velocity"])
            # The ball goes down 0.2 m/s.
            ball = report.result["obstacles"][0]
            self.assertEqual(ball["names"], ["ball"])
            moves = [report.rows(block, report.index_of(ball), ball["vertices"], scale) for block, scale in zip(ball["moves"], ball["moveScales"])]
            times = np.array([frame["time"] for frame in report.result["frames"]])
            np.testing.assert_allclose(moves[2], np.repeat(-0.2 * times[:, None], ball["vertices"], axis=1), atol=1e-6)
        history = read_history(self.out)
        for name, values in report.history().items():
            np.testing.assert_array_equal(values, history[name])

    def test_size(self):
        whole = self.report()
        bytes_of_frames = sum(len(text) for text in whole.blocks_of_fields())
        size = (len(whole.text.encode()) - bytes_of_frames // 2) * 1e-6
        done = self.call("report", self.out, "--size", size)
        report = ReportFile(self.out / "report.html")
        self.assertLess(len(report.text.encode()), size * 1e6)
        frames = len(report.result["frames"])
        self.assertTrue(3 <= frames <= 7, frames)  # of 11, for half of what they take, less what is reserved for their names
        self.assertIn(f"{frames} of 11 frames; open", done.stdout)
        self.assertIn("2 of 11 frames (the data besides the frames need", self.call("report", self.out, "--size", 0.1).stdout)

    def test_pipes_are_written_to(self):  # and not replaced, as root could /dev/null
        pipe = self.directory / "pipe"
        os.mkfifo(pipe)
        with subprocess.Popen(["cp", "--copy-contents", pipe, self.directory / "page"]) as reader:
            done = self.call("report", self.out, "--output", pipe)
            if done.returncode != 0:
                reader.kill()  # it waits for somebody who writes
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(pipe.is_fifo())
        self.assertIn("</html>", (self.directory / "page").read_text(encoding="utf-8"))
        pipe = pipe.rename(self.directory / "mesh.h5")
        write_box(self.directory / "bar.msh", (1, 1, 1))
        done = self.call("mesh", "convert", self.directory / "bar.msh", pipe)
        self.assertRegex(done.stderr, "it is there and is not a regular file")
        self.assertTrue(pipe.is_fifo())

    def test_run_that_goes_on(self):
        (self.out / "summary.json").unlink()
        with open(self.out / "history.csv", "a", encoding="ascii") as history:
            history.write("11,0.11,0.0")  # a row that is just being written
        report = self.report()
        self.assertIsNone(report.json["summary"])
        self.assertEqual(report.json["history"]["rows"], 11)

    def test_watched_run(self):
        """The page is renewed until the run has ended; a browser that shows it follows."""
        write_box(self.directory / "bar.msh", (4, 2, 2), (1, 0.2, 0.2))
        run = start(["run", self.write("in.yaml", INPUT), "--output", "going", "--quiet", "--set", "time.end=1000"], self.directory)
        out, page = self.directory / "going", self.directory / "going/report.html"
        deadline = time.monotonic() + 60
        while not (out / "history.csv").exists() or (out / "history.csv").read_text().count("\n") < 4:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        watch = start(["report", "going", "--watch", "2"], self.directory)
        while not page.exists():
            self.assertIsNone(watch.poll())
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        first = ReportFile(page)
        self.assertEqual(first.json["watch"], 2)
        if CHROMIUM:
            with Browser() as browser:
                browser.open(page)
                browser.wait("document.documentElement?.dataset.ready === 'yes'")
                self.assertEqual(browser.evaluate("document.getElementById('outcome').textContent"), "running")
                end = browser.evaluate("window.pliant.player.end")
                browser.evaluate("window.pliant.view.aim([0, 0, 1])")
                followed = (f"document.documentElement?.dataset.ready === 'yes' && window.pliant.player.end > {end}"
                            " && window.pliant.player.time === window.pliant.player.end && window.pliant.view.aimed?.join() === '0,0,1'")
                for _ in range(600):
                    with contextlib.suppress(AssertionError):  # there is no page while it is loaded
                        if browser.evaluate(followed):
                            break
                    time.sleep(0.1)
                else:
                    self.fail("the page was not renewed, or not as it looked")
                self.assertEqual(browser.errors, [])
        run.send_signal(signal.SIGINT)
        self.assertEqual(finish(run, 60).returncode, 130)
        done = finish(watch, 60)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the run has ended", done.stdout)
        last = ReportFile(page)
        self.assertNotIn("watch", last.json)
        self.assertEqual(last.json["summary"]["outcome"], "interrupted")
        self.assertEqual(last.json["history"]["steps"], len(read_history(out)["step"]) - 1)

    def test_mistakes(self):
        done = self.call("report", self.directory / "missing")
        self.assertEqual(done.returncode, 4)
        self.assertRegex(done.stderr, r"^no result: '.*' does not exist\n$")
        done = self.call("report", self.write("bar.h5", "no HDF5"))
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1), done.stderr)
        done = self.call("report", self.out, "--output", self.directory / "no" / "report.html")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (4, 1), done.stderr)
        self.assertEqual(self.call("report", self.out, "--size", "0").returncode, 2)

    def test_results_that_are_damaged(self):
        """One message, with the name of the file."""
        whole = (self.out / "result.h5").read_bytes()
        for name, (change, told, told_by_info) in DAMAGE.items():
            (self.out / "result.h5").write_bytes(whole)
            with h5py.File(self.out / "result.h5", "r+") as file:
                change(file)
            for command, words in (("report", told), ("info", told_by_info)):
                if words is None:
                    continue
                with self.subTest(name, command=command):
                    done = self.call(command, self.out)
                    self.assertEqual(done.returncode, 4, done.stderr)
                    self.assertRegex(done.stderr, words)
                    self.assertEqual((done.stderr.count("\n"), done.stderr.count("result.h5")), (1, 1), done.stderr)

    @unittest.skipUnless(CHROMIUM, "needs the package chromium")
    def test_in_a_browser(self):
        summary = json.loads((self.out / "summary.json").read_text())
        (self.out / "summary.json").write_text(json.dumps({**summary, "warnings": ["bar.yaml:4:5: a <b>doubt</b>"]}))
        report = self.report("--output", self.directory / "moved.html")
        shutil.rmtree(self.out)  # the page stands alone
        with Browser((1200, 900)) as browser:
            self.assertNotIn("src=", re.sub("<script.*?</script>", "", (self.directory / "moved.html").read_text(), flags=re.S))
            browser.open(self.directory / "moved.html")
            browser.wait("document.documentElement?.dataset.ready === 'yes'")
            self.assertEqual(browser.evaluate("document.querySelector('h1').textContent"), "a bar </script> & <b>more</b>")
            self.assertEqual(browser.evaluate("document.querySelector('#run p.warning').textContent"), "bar.yaml:4:5: a <b>doubt</b>")
            self.assertTrue(browser.evaluate("document.querySelector('#facts').textContent").endswith("1 warning"))
            # At the end of the run the bar is coloured by its stress.
            end = browser.picture("#view")
            self.assertGreater(len(np.unique(end.reshape(-1, 3) // 16, axis=0)), 40)
            saturated = np.ptp(end, axis=2) > 60
            self.assertGreater(saturated.mean(), 0.03)
            self.assertEqual(browser.evaluate("document.querySelectorAll('#plots canvas').length"),
                             browser.evaluate("document.querySelectorAll('#plots figure').length"))
            self.assertGreater(browser.evaluate("document.querySelectorAll('#plots figure').length"), 5)
            # Playing starts over, and the bar sinks.
            browser.evaluate("document.querySelector('#play').click()")
            browser.wait("pliant.player.time > 0.03 && pliant.player.time < 0.099")
            browser.evaluate("document.querySelector('#play').click()")
            time = browser.evaluate("pliant.player.time")
            self.assertFalse(browser.evaluate("pliant.player.playing"))
            browser.evaluate("new Promise(done => setTimeout(done, 100))")
            self.assertEqual(browser.evaluate("pliant.player.time"), time)
            self.assertGreater(np.abs(browser.picture("#view") - end).max(), 60)
            # Between two frames a node is on the straight line between them, displacements magnified.
            middle = browser.evaluate("""(() => {
                const { view, bodies } = pliant, x = new Float32Array(3 * bodies.surfaces[0].size), at = (t) => {
                    bodies.positions(bodies.at(t), 2, [0, 0, 0], x);
                    return [...x]; };
                const [a, b, c] = [at(0.05), at(0.055), at(0.06)];
                return Math.max(...b.map((p, i) => Math.abs(p - (a[i] + c[i]) / 2)));
            })()""")
            self.assertLess(middle, 1e-6)
            # The page unpacks what Python does.
            unpacked = browser.evaluate("""(async () => {
                const { bodies, player } = pliant, x = new Float32Array(3 * bodies.surfaces[0].size), v = new Float32Array(x.length / 3);
                bodies.positions(bodies.at(player.end), 1, [0, 0, 0], x);
                await bodies.need(3);
                bodies.scalars(bodies.at(player.end), 3, 2, v);
                return [[...x], [...v]];
            })()""")
            x = report.positions(0) + report.field("displacement")[-1] + report.result["frames"][-1]["shift"]
            np.testing.assert_allclose(np.reshape(unpacked[0], (-1, 3)), x, atol=1e-6)
            np.testing.assert_allclose(unpacked[1], report.field("velocity")[-1, :, 2], atol=1e-6)
            # Another field, the scrubber, a narrow window in the dark.
            browser.evaluate("document.querySelector('#colour').value = 0; document.querySelector('#colour').onchange()")
            browser.evaluate("(() => { const s = document.querySelector('#scrub'); s.value = 0.1; s.oninput(); })()")
            self.assertIn("Displacement", browser.evaluate("document.querySelector('#legend').textContent"))
            browser.prefer("dark")
            browser.resize(420, 900)
            browser.wait("document.querySelector('#view').clientWidth < 420")
            browser.wait("document.documentElement.scrollWidth <= 420")
            self.assertLess(np.median(browser.picture()), 80)
            self.assertEqual(browser.errors, [])


    @unittest.skipUnless(CHROMIUM, "needs the package chromium")
    def test_surfaces_that_touch(self):
        """What lies between bodies is seen once one of them is hidden or transparent, which the keyboard does too."""
        self.write("blocks.geo", BLOCKS)
        self.run_input(self.write("touching.yaml", TOUCHING), output="touching")
        done = self.call("report", self.directory / "touching")
        self.assertEqual(done.returncode, 0, done.stderr)
        report = ReportFile(self.directory / "touching/report.html")
        pressure = report.field("contact_pressure")[-1, :, 0]
        body = report.array(report.result["meshes"][0]["bodies"], "i4")
        with h5py.File(self.directory / "touching/result.h5") as file:
            highest = file["frames"][max(file["frames"])]["contact_pressure"][:].max()
        for b in (0, 1):  # both sides of the contact have it
            self.assertGreater(pressure[body == b].max(), 0.3 * highest)
        self.assertAlmostEqual(pressure.max(), highest, delta=0.01 * highest)

        def press(browser, selector, *keys):
            browser.evaluate(f"document.querySelector('{selector}').focus()")
            for key in keys:
                code = {"Down": 40, "Up": 38}[key]
                for kind in ("keyDown", "keyUp"):
                    browser.call("Input.dispatchKeyEvent", type=kind, key=f"Arrow{key}", code=f"Arrow{key}", windowsVirtualKeyCode=code)
            browser.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

        def high_pressure(browser):
            """Share of the pixels with the upper colours of the scale, without the bar itself."""
            r, g, b = np.moveaxis(browser.picture("#view")[:, :-120], 2, 0)
            return np.mean((g > b + 40) & (g > 90))

        with Browser((1200, 900)) as browser:
            browser.open(self.directory / "touching/report.html")
            browser.wait("document.documentElement?.dataset.ready === 'yes'")
            names = browser.evaluate("[...document.querySelectorAll('.look')].map(row => row.textContent.replace(/solid.*/, ''))")
            self.assertEqual(names, ["base", "block", "ground", "post"])
            # Each control can be reached by the keyboard and says what it does.
            for control in ("#body-0", "#body-1", "#obstacle-0", "#obstacle-1"):
                self.assertTrue(browser.evaluate(f"""(() => {{ const c = document.querySelector('{control}');
                    return c.tagName === 'SELECT' && c.tabIndex === 0 && c.getAttribute('aria-label').length > 4; }})()"""))
            browser.evaluate("""(async () => { const { panel } = pliant;
                panel.colour.value = [...panel.colour.options].find(o => o.textContent === 'Contact pressure').value;
                await panel.paint();
                panel.setRange(0, %g); })()""" % (0.5 * highest))
            self.assertIn("Contact pressure", browser.evaluate("document.querySelector('#legend').textContent"))
            for control in ("#obstacle-0", "#obstacle-1"):
                press(browser, control, "Down")
            solid, covered = browser.picture("#view"), high_pressure(browser)
            press(browser, "#body-1", "Down")
            transparent = browser.picture("#view")
            self.assertEqual(browser.evaluate("document.querySelector('#body-1').value"), "transparent")
            press(browser, "#body-1", "Down")
            hidden, seen = browser.picture("#view"), high_pressure(browser)
            self.assertEqual(browser.evaluate("document.querySelector('#body-1').value"), "hidden")
            self.assertGreater(seen, covered + 0.005)
            for a, b in ((solid, transparent), (transparent, hidden), (solid, hidden)):
                self.assertGreater(np.mean(np.abs(a - b).max(axis=2) > 20), 0.01)
            press(browser, "#body-1", "Up", "Up")
            self.assertLessEqual(np.abs(browser.picture("#view") - solid).max(), 2)
            press(browser, "#obstacle-1", "Up", "Up")
            self.assertGreater(np.mean(np.abs(browser.picture("#view") - solid).max(axis=2) > 20), 0.003)
            self.assertEqual(browser.evaluate("pliant.player.time"), browser.evaluate("pliant.player.end"), "keys of choices do not play")
            self.assertEqual(browser.errors, [])


def report_surface(nodes):
    """Which nodes of the bar lie on its surface."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    return (np.minimum(np.abs(nodes - low), np.abs(nodes - high)) < 1e-9).any(axis=1)


if __name__ == "__main__":
    unittest.main()
