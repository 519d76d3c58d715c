#!/usr/bin/python3
"""What users see of tendons, springs and joints: in results, from Python, in ParaView's files, on the page and in pictures."""
import shutil
import subprocess
import types
import unittest
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np
from PIL import Image

from browser import CHROMIUM, Browser
from program import ENVIRONMENT, ROOT, ProgramTest, read_history, swept, write_box
from package import Result, Surface
from pliant.pictures.shown import Shown
from report_file import ReportFile

# A soft finger on a palm that a motor turns; a tendon with friction bends the finger, a bob hangs from the palm.
INPUT = """title: finger on a palm
mesh: {file: finger.msh}
bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 0.5 MPa, poissons_ratio: 0.3}}]
rigid_bodies:
  - {name: palm, mass: 0.1, inertia: [5e-5, 5e-5, 5e-5], center: [-0.03, 0.01, 0.01], attached: [left]}
  - {name: bob, mass: 0.02, inertia: [2e-6, 2e-6, 2e-6], center: [-0.03, 0.01, -0.03]}
  - {name: clapper, mass: 0.01, inertia: [1e-6, 1e-6, 1e-6], center: [-0.03, 0.02, -0.04]}
joints:
  - name: knuckle
    type: hinge
    between: [ground, palm]
    point: [-0.05, 0.01, 0.01]
    axis: [0, 2, 0]
    motor: {target: "-0.5*min(t/0.05, 1)", stiffness: 5, damping: 0.05}
  - {name: eye, type: ball, between: [palm, bob], point: [-0.03, 0.01, 0]}
  - {name: pin, type: hinge, between: [bob, clapper], point: [-0.03, 0.01, -0.03], axis: [1, 0, 0]}
tendons:
  - name: flexor
    points:
      - {body: ground, point: [-0.09, 0.01, 0.05]}
      - {body: palm, point: [-0.02, 0.01, 0.024]}
      - [0.01, 0.01, 0.017]
      - [0.05, 0.01, 0.017]
      - [0.09, 0.01, 0.017]
    tension: "2*min(t/0.02, 1)"
    friction: 0.1
springs:
  - {name: coil, points: [{body: ground, point: [-0.09, 0.01, -0.02]}, {body: palm, point: [-0.04, 0.01, 0.01]}], stiffness: 50, damping: 0.1}
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 2.5 ms, end: 0.05}
output: {every: 0.01}
checkpoint: {every: 4}
"""


def rotation(history, body, step):
    """Of a body since the start, as a matrix."""
    w, x, y, z = (history[f"{body}_q{c}"][step] for c in "wxyz")
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


class MechanismViews(ProgramTest):
    def run_finger(self, *settings, ranks=1, output="out"):
        write_box(self.directory / "finger.msh", (10, 2, 2), (0.1, 0.02, 0.02))
        return self.run_input(self.write("finger.yaml", INPUT), *settings, ranks=ranks, output=output)

    def test_results_are_those_of_the_history_on_any_number_of_ranks(self):
        found = []
        for ranks in swept((1, 2, 3), (1, 2)):
            h = self.run_finger(ranks=ranks, output=f"out{ranks}")
            result = Result(self.directory / f"out{ranks}")
            rows = np.searchsorted(h["step"], [frame.step for frame in result])
            flexor, coil, (knuckle, eye, pin) = result.tendons["flexor"], result.springs["coil"], result.joints.values()
            lengths = np.linalg.norm(np.diff(flexor.points, axis=1), axis=2).sum(axis=1)
            np.testing.assert_allclose(lengths, h["flexor_length"][rows], rtol=1e-12)
            np.testing.assert_allclose(flexor.tension[:, 0], h["flexor_tension"][rows], rtol=1e-12)
            np.testing.assert_allclose(np.linalg.norm(coil.points[:, 1] - coil.points[:, 0], axis=1), h["coil_length"][rows], rtol=1e-12)
            np.testing.assert_allclose(coil.tension[:, 0], h["coil_force"][rows], rtol=1e-9, atol=1e-12)
            # Friction: the tension falls from point to point, by the capstan equation where it slips at most.
            n = np.diff(flexor.points, axis=1) / np.linalg.norm(np.diff(flexor.points, axis=1), axis=2)[..., None]
            turns = np.arccos(np.clip((n[:, 1:] * n[:, :-1]).sum(axis=2), -1, 1))
            falls = np.log(flexor.tension[1:, :-1] / flexor.tension[1:, 1:])
            self.assertLess((np.abs(falls) - 0.1 * turns[1:]).max(), 1e-9)
            self.assertGreater(np.abs(falls).max(), 1e-3)
            # Joints move with their bodies.
            self.assertEqual([joint.type for joint in (knuckle, eye, pin)], ["hinge", "ball", "hinge"])
            np.testing.assert_allclose(knuckle.point - [-0.05, 0.01, 0.01], 0, atol=1e-9)
            np.testing.assert_allclose(knuckle.axis - [0, 1, 0], 0, atol=1e-12)
            self.assertFalse(eye.axis.any())
            for k, row in enumerate(rows):
                palm = np.array([h[f"palm_{c}"][row] for c in "xyz"])
                np.testing.assert_allclose(eye.point[k], palm + rotation(h, "palm", row) @ [0, 0, -0.01], atol=1e-9)
                np.testing.assert_allclose(pin.axis[k], rotation(h, "bob", row) @ [1, 0, 0], atol=1e-9)
            self.assertGreater(np.ptp(eye.point, axis=0).max(), 5e-3)
            self.assertGreater(np.ptp(pin.axis, axis=0).max(), 0.05)
            found.append(np.concatenate([flexor.points[-1], coil.points[-1], eye.point[-1:]]))
        for other in found[1:]:
            np.testing.assert_allclose(other, found[0], atol=1e-6)

    def test_resumed_runs_append(self):
        h = self.run_finger("time.end=0.02")
        self.pliant("resume", "out", "--set", "time.end=0.05", "--quiet", ranks=2)
        h = read_history(self.directory / "out")
        result = Result(self.directory / "out")
        self.assertEqual({frame.mesh_group for frame in result}, {"/mesh", "/mesh_1"})
        rows = np.searchsorted(h["step"], [frame.step for frame in result])
        np.testing.assert_allclose(result.tendons["flexor"].tension[:, 0], h["flexor_tension"][rows], rtol=1e-12)
        listed = ElementTree.parse(self.directory / "out/result_mechanisms.xdmf").findall("Domain/Grid/Grid")
        self.assertEqual([float(grid.find("Time").get("Value")) for grid in listed], list(result.times))
        self.assertIn("mechanisms: flexor, coil, knuckle, eye, pin", self.pliant("info", "out").stdout)
        self.pliant("report", "out")
        frames = ReportFile(self.directory / "out/report.html").result["frames"]
        self.assertEqual({frame["mesh"] for frame in frames}, {0, 1})

    def test_check_lists_what_connects_bodies(self):
        write_box(self.directory / "finger.msh", (10, 2, 2), (0.1, 0.02, 0.02))
        text = self.pliant("check", self.write("finger.yaml", INPUT)).stdout
        for line in ("palm: rigid, mass 0.1 kg, center (-0.03, 0.01, 0.01), attached: left\n",
                     "knuckle: hinge, ground - palm, at (-0.05, 0.01, 0.01), axis (0, 1, 0), motor",
                     "eye: ball, palm - bob, at (-0.03, 0.01, 0)\n",
                     "coil: ground - palm, 0.0583095 m long, 50 N/m from 0.0583095 m on, damping 0.1 N s/m",
                     "flexor: 5 points, ",
                     "linear solver: GMRES preconditioned by "):
            self.assertIn(line, text)

    def test_kinds_of_joints(self):
        """Each has its lines."""
        at = {"fixed": "", "ball": "", "hinge": "axis: [0, 0, 1]", "slider": "axis: [0, 0, 1]", "cylindrical": "axis: [0, 0, 1]",
              "universal": "axis: [0, 0, 1], second_axis: [1, 0, 0]", "planar": "axis: [0, 0, 1]", "distance": "second_point: [0, 0, 1]"}
        text = "rigid_bodies:\n"
        for k, kind in enumerate(at):
            text += f"  - {{name: b{k}, mass: 1, inertia: [0.1, 0.1, 0.1], center: [{3 * k}, 0, 1], angular_velocity: [0, 0, {k if k in (2, 4, 6) else 0}], velocity: [0, 0, {int(k in (3, 4))}]}}\n"
        text += "joints:\n"
        for k, (kind, keys) in enumerate(at.items()):
            text += f"  - {{name: j{k}, type: {kind}, between: [ground, b{k}], point: [{3 * k}, 0, 0]{', ' * bool(keys)}{keys.replace('[0, 0, 1]', f'[{3 * k}, 0, 1]') if kind == 'distance' else keys}}}\n"
        self.write("in.yaml", text + "time: {method: dirk23, end: 0.1, adaptive: {relative: 0.01}}\n")
        self.run_input("in.yaml")
        result = Result(self.directory / "out")
        self.assertEqual([joint.type for joint in result.joints.values()], list(at))
        # Bodies without a surface are ellipsoids, here spheres of radius sqrt(5 S/m), S = tr(J) / 2 - J.
        mesh = result[0].mesh
        self.assertEqual(mesh.masses, [f"b{k}" for k in range(8)])
        surface = Surface(mesh)
        points = surface.of_nodes(mesh.coordinates)[surface.triangles]
        centers = np.repeat([[3 * k, 0, 1] for k in range(8)], 512, axis=0)
        np.testing.assert_allclose(np.linalg.norm(points - centers[:, None], axis=2), np.sqrt(5 * 0.05), rtol=2e-3)
        self.pliant("report", "out")
        report = ReportFile(self.directory / "out/report.html")
        self.assertEqual(report.triangles(0).shape, (8 * 512, 3))
        for found in (report.positions(0)[report.triangles(0)], points):  # counterclockwise seen from outside
            a, b, c = np.moveaxis(found - centers[:, None], 1, 0)
            self.assertGreater(np.einsum("ij,ij->i", np.cross(a, b), c).min(), 0)
        drawn = np.bincount(result[-1].mechanisms.part)
        self.assertEqual(list(drawn), [3, 3, 1, 5, 5, 2, 5, 1])
        # Lines of sliders are where their dots are.
        last = result[-1].mechanisms
        for k in (3, 4):
            self.assertAlmostEqual(last.points[last.joints[k], 2], 0.1)
            np.testing.assert_allclose(last.points[last.segments[last.part == k]].mean(axis=(0, 1)), [3 * k, 0, 0.1], atol=1e-9)
        for joint in result.joints.values():
            has_axis = joint.type not in ("fixed", "ball", "distance")
            np.testing.assert_allclose(joint.axis, np.full((len(result), 1), has_axis) * [[0, 0, 1]], atol=1e-12)

    def report(self):
        self.run_finger()
        self.pliant("report", "out")
        return ReportFile(self.directory / "out/report.html")

    def test_the_report_has_them(self):
        report, result = self.report(), Result(self.directory / "out")
        given, = report.result["mechanisms"]
        self.assertEqual(given["names"], ["flexor", "coil", "knuckle", "eye", "pin"])
        self.assertEqual(given["kinds"], ["tendon", "spring", "hinge", "ball", "hinge"])
        last = result[-1].mechanisms
        for name, values in (("segments", last.segments), ("parts", last.part), ("joints", last.joints)):
            np.testing.assert_array_equal(report.array(given[name], "i4"), np.ravel(values))
        none = np.zeros((0, 3), dtype=int)
        x = np.stack([report.rows(given["positions"][k], none, given["vertices"], given["scales"][k])[0]
                      + report.rows(given["moves"][k], none, given["vertices"], given["moveScales"][k]) for k in range(3)], axis=2)
        np.testing.assert_allclose(x, [frame.mechanisms.points for frame in result], atol=2e-6)
        tension = report.rows(given["tensions"], none, len(last.part), given["tensionScale"])
        np.testing.assert_allclose(tension, [frame.mechanisms.tension for frame in result], atol=2e-4)

    def test_results_that_are_damaged(self):
        """One message, with the name of the file."""
        self.run_finger("time.end=0.01")
        whole = (self.directory / "out/result.h5").read_bytes()
        for words, place, values in (("the mechanisms '.*' of '.*' are damaged", "segments", np.full((10, 2), 1 << 40)),
                                     ("the mechanisms '.*' of '.*' are damaged", "joints", np.full(3, 99)),
                                     ("the mechanisms of frame '000001' are damaged", "frames/000004/points", np.zeros((2, 3))),
                                     ("cannot read .*tension", "frames/000004/tension", np.zeros((3, 3)))):
            (self.directory / "out/result.h5").write_bytes(whole)
            with h5py.File(self.directory / "out/result.h5", "r+") as file:
                attributes = dict(file["mechanisms"][place].attrs)
                del file["mechanisms"][place]
                file["mechanisms"][place] = values
                file["mechanisms"][place].attrs.update(attributes)
            with self.subTest(place):
                done = self.call("report", "out")
                self.assertEqual(done.returncode, 4, done.stderr)
                self.assertRegex(done.stderr, words)
                self.assertEqual((done.stderr.count("\n"), done.stderr.count("result.h5")), (1, 1), done.stderr)

    @unittest.skipUnless(CHROMIUM, "needs the package chromium")
    def test_the_page_shows_them(self):
        self.report()

        def red(picture):  # pixels of the tendon
            r, g, b = np.moveaxis(picture, 2, 0)
            return np.mean((r > g + 90) & (r > b + 60))

        with Browser((1200, 900)) as browser:
            browser.open(self.directory / "out/report.html")
            browser.wait("document.documentElement?.dataset.ready === 'yes'")
            self.assertEqual(browser.evaluate("[...document.querySelectorAll('[id^=part-]')].map(c => c.parentElement.textContent.replace(/shown.*/, ''))"),
                             ["flexor, tendon", "coil, spring", "knuckle, hinge", "eye, ball", "pin, hinge"])
            titles = browser.evaluate("[...document.querySelectorAll('#plots figcaption b')].map(b => b.textContent)")
            self.assertIn("Body palm", titles)
            self.assertNotIn("Probe palm", titles)
            captions = browser.evaluate("[...document.querySelectorAll('#plots figcaption')].map(c => c.textContent)")
            for caption in ("Tension of tendons [N]", "Force of springs [mN]", "Length of tendons and springs [mm]", "Angles of joints [rad]", "Torques of motors [mN m]"):
                self.assertIn(caption, captions)
            self.assertEqual(browser.evaluate("[0, 1, 2, 3].map(k => document.querySelector(`#body-${k}`).value)"), ["solid"] + 3 * ["transparent"])
            self.assertEqual(browser.evaluate("['body', 'clear', 'ghosts'].map(k => pliant.view.drawn[0][k].geometry.index.count > 0)"), [True, False, True])
            draw = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
            browser.evaluate("pliant.panel.colour.value = 'none', pliant.panel.paint()")
            browser.evaluate(draw)
            end = browser.picture("#view")
            self.assertGreater(red(end), 5e-4)
            # Where the page draws the lines: as the result has them, magnified if displacements are.
            result = Result(self.directory / "out")
            for scale in (1, 2):
                x = browser.evaluate("[...pliant.view.mechanisms.current(pliant.bodies.at(pliant.player.end), %d, [0, 0, 0]).x]" % scale)
                at_rest, now = result[0].mechanisms.points, result[-1].mechanisms.points
                np.testing.assert_allclose(np.reshape(x, (-1, 3)), at_rest + scale * (now - at_rest), atol=1e-5)
            # Switched off, the tendon is gone; other moments differ.
            switch = "(() => { const c = document.querySelector('#part-0'); c.value = '%s'; c.onchange(); })()"
            browser.evaluate(switch % "hidden")
            browser.evaluate(draw)
            self.assertLess(red(browser.picture("#view")), red(end) / 4, "the x axis of the page is red, too")
            browser.evaluate(switch % "shown")
            browser.evaluate("pliant.player.seek(0)")
            browser.evaluate(draw)
            self.assertGreater(np.mean(np.abs(browser.picture("#view") - end).max(axis=2) > 40), 1e-3)
            # Coloured by tension.
            browser.evaluate("pliant.player.seek(pliant.player.end)")
            browser.evaluate("pliant.panel.colour.value = 'tension', pliant.panel.paint()")
            browser.evaluate(draw)
            self.assertIn("Tension N", browser.evaluate("document.querySelector('#legend').textContent"))
            self.assertLess(red(browser.picture("#view")[:, :-150]), red(end) / 2)
            self.assertEqual(browser.errors, [])

    def test_pictures_show_them(self):
        self.run_finger("time.end=0.01")
        pictures = []
        for more in ([], ["--hide", "flexor"], ["--field", "tension"]):
            file = self.directory / "picture.png"
            self.pliant("render", "out", "--field", "none", "--size", "480x300", "--no-axes", "-o", file, *more)
            pictures.append(np.asarray(Image.open(file).convert("RGB")).astype(int))
        red = [np.mean((p[..., 0] > p[..., 1] + 80) & (p[..., 0] > p[..., 2] + 50) & (p[..., 1] < 110)) for p in pictures]
        self.assertGreater(red[0], 5e-4)
        self.assertEqual(red[1], 0)
        # Ellipsoids of inertia are seen through, and have no colours of a field.
        frame = Result(self.directory / "out")[-1]
        options = types.SimpleNamespace(field="displacement", range=None, colour_map="auto", scale=1, hide=[], transparent=["palm"], outline=False,
                                        cut=None, mirror=[], view=[1, 0, 0])
        shown = Shown(Result(self.directory / "out"), [frame], options)
        drawn = [(shell.names, shell.opacity < 1, colours is None) for shell, colours in zip(shown.shells(frame), shown.colours_of(frame))]
        self.assertEqual(drawn, [(["body"], False, False), (["palm", "bob", "clapper"], True, True)])
        options.hide, options.transparent = ["body"], []
        shown = Shown(Result(self.directory / "out"), [frame], options)
        self.assertEqual([shell.opacity for shell in shown.shells(frame)], [1])

    @unittest.skipUnless(shutil.which("pvpython"), "pvpython is not installed; Debian's package python3-paraview has it")
    def test_paraview_reads_them(self):
        self.run_finger("time.end=0.01")
        script = self.write("read.py", """
import sys
from paraview import servermanager
from paraview.simple import XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT
for reader in (XDMFReader, Xdmf3ReaderS, Xdmf3ReaderT):
    source = reader(FileNames=[sys.argv[1]]) if reader is XDMFReader else reader(FileName=[sys.argv[1]])
    source.UpdatePipelineInformation()
    source.UpdatePipeline(source.TimestepValues[-1])
    grid = servermanager.Fetch(source)
    print(len(source.TimestepValues), grid.GetNumberOfCells(), grid.GetCell(0).GetClassName(), grid.GetCellData().GetArray("tension").GetValue(0))
""")
        done = subprocess.run(["pvpython", "--force-offscreen-rendering", script, self.directory / "out/result_mechanisms.xdmf"],
                              env=ENVIRONMENT, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True, timeout=300)
        result = Result(self.directory / "out")
        last = result[-1].mechanisms
        expected = f"{len(result)} {len(last.part)} vtkPolyLine {last.tension[0]}"
        self.assertEqual(done.stdout.split("\n")[:3], 3 * [expected])


if __name__ == "__main__":
    unittest.main()
