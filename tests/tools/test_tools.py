#!/usr/bin/python3
"""The tools on synthetic results: do they draw what is there, and do they say what is wrong in one line?"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import h5py
import numpy as np
from matplotlib import pyplot as plt
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))
TOOLS = os.path.join(HERE, "..", "..", "tools")
sys.path[:0] = [HERE, TOOLS]
sys.dont_write_bytecode = True

import synthetic  # noqa: E402
from package import Result, Surface  # noqa: E402
from pliant import Mesh, von_mises  # noqa: E402
from pliant.pictures import plot  # noqa: E402
from pliant.pictures.camera import fitted_camera  # noqa: E402
from pliant.pictures.colours import Colours  # noqa: E402
from pliant.pictures.cut import CutSurface, Plane, mirror, plane  # noqa: E402
from pliant.pictures.page import INK, Page  # noqa: E402
from pliant.pictures.quantity import Quantity, quantity_of  # noqa: E402
from pliant.pictures.render import parser_of  # noqa: E402
from pliant.pictures.rods import RodShapes, prisms  # noqa: E402
from pliant.pictures.shown import Shown  # noqa: E402
from pliant.result import Obstacles  # noqa: E402
from pliant.surface import _sphere  # noqa: E402

SMALL = ["--size", "320x240", "--no-axes"]  # which tests of colours would take for bodies


def run(tool, *arguments):
    command = ["/usr/bin/python3", os.path.join(TOOLS, tool), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def render_options(*arguments):
    return parser_of("render").parse_args([str(word) for word in arguments])


class WithResult(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.mkdtemp(prefix="pliant-tools-")
        self.addCleanup(shutil.rmtree, self.directory)

    def path(self, name):
        return os.path.join(self.directory, name)

    def draw(self, *arguments, tool="render.py"):
        done = run(tool, self.directory, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.strip()

    def fails(self, text, *arguments, tool="render.py", code=2):
        done = run(tool, *arguments)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(text, done.stderr)
        self.assertEqual(done.stderr.strip().count("\n"), 0, done.stderr)


class Pictures(WithResult):
    def setUp(self):
        super().setUp()
        synthetic.write_result(self.directory, num_frames=3, cubes=(6, 2, 2))

    def body_pixels(self, image):
        """Pixels below the header and left of the colour bar that are not background."""
        width, height = image.size
        scene = np.asarray(image.convert("RGB"))[int(0.12 * height):, : int(0.75 * width)].astype(int)
        return scene[np.abs(scene - scene[-1, 0]).max(axis=2) > 12]

    def test_picture_shows_a_coloured_body(self):
        file = self.draw("--frame", 1, *SMALL)
        self.assertEqual(file, self.path("picture.png"))
        image = Image.open(file)
        self.assertEqual(image.size, (320, 240))
        body = self.body_pixels(image)
        self.assertGreater(len(body), 0.08 * 320 * 240)
        self.assertGreater(len(np.unique(body // 16, axis=0)), 20)

    def test_every_kind_of_field(self):
        for field in ("velocity", "velocity_z", "cauchy_stress_xx", "von_mises_stress", "body", "rank", "none"):
            with self.subTest(field):
                file = self.path(f"{field}.png")
                self.draw("--field", field, "--mesh-edges", "--outline", "--frame", 1, "-o", file, *SMALL)
                self.assertGreater(len(self.body_pixels(Image.open(file))), 1000)

    def test_obstacles_are_drawn_and_hide_bodies_by_half_only(self):
        def pixels(frame, *arguments):
            file = self.draw("--view=front", "--field=none", "--frame", frame, *arguments, *SMALL)
            return np.asarray(Image.open(file).convert("RGB")).astype(int)

        def share_of_blue(image):  # the body is bluish, obstacles are reddish, the background is neither
            image = image[30:]
            return np.mean(image[..., 2] > image[..., 0] + 15), np.mean(image[..., 0] > image[..., 2] + 5)

        bare = share_of_blue(pixels(0))
        synthetic.add_obstacles(self.directory)
        self.assertEqual(share_of_blue(pixels(0, "--scale", 1.001)), bare)
        above = pixels(0)  # the pyramid stands below the floor
        body, obstacle = share_of_blue(above)
        self.assertGreater(obstacle, 0.01)
        self.assertGreater(body, 0.01)
        before = pixels(2)  # ... and now before the bar
        colours, counts = np.unique(before[30:].reshape(-1, 3) // 4, axis=0, return_counts=True)
        self.assertGreater(len(colours[counts > 20]), 3, "background, body, obstacle, and the mean of the two")

    def test_tendons_springs_and_joints_are_drawn_and_seen_through_bodies(self):
        def shares(*arguments):
            """Of pixels of tendon, spring and joint where nothing hides them, and of those where a body does."""
            file = self.draw("--view=0.2,-1,0.3", "--field=none", "--frame", 2, *arguments, *SMALL)
            r, g, b = np.moveaxis(np.asarray(Image.open(file).convert("RGB")).astype(int)[30:], 2, 0)
            is_red, is_green, is_yellow = (r > g + 80) & (r > b + 50), (g > r + 60), (g > b + 60) & (r > g + 30)
            return [np.mean(colour) for colour in (is_red & ~is_yellow, is_green, is_yellow, (r > b) & (r < 205))]

        nothing = shares()
        synthetic.add_mechanisms(self.directory)
        self.assertEqual(shares("--scale", 1.001), nothing)
        drawn = shares()
        for share, none in zip(drawn, nothing):
            self.assertGreater(share, none + 2e-4)
        without = shares("--hide", "flexor", "--hide", "root_hinge")
        self.assertEqual((without[0], without[2]), (nothing[0], nothing[2]))
        self.assertGreaterEqual(without[1], drawn[1], "the camera comes nearer")
        self.fails("--transparent coil: nothing that can be transparent has this name", self.directory, "--transparent", "coil")
        # By tension: the spring pushes, the tendon pulls most at its first segment.
        pictures = [np.asarray(Image.open(self.draw("--field", field, "--frame", 2, "--size", "480x360"))).tobytes() for field in ("tension", "none")]
        self.assertNotEqual(*pictures)

    def test_bodies_are_hidden_and_transparent(self):
        """Named colours: the root is blue, the tip orange; the end of the root inside the bar is seen once the tip is gone."""
        def shares(*arguments):
            file = self.draw("--field=body", "--frame", 0, "--view=1,-1,0.3", *arguments, *SMALL)
            r, g, b = np.moveaxis(np.asarray(Image.open(file).convert("RGB")).astype(int)[30:, :240], 2, 0)
            strong = abs(r - b) > 85  # not of a transparent body
            return np.mean(strong & (b > r)), np.mean(strong & (r > b)), np.mean((r < 245) & (r > b + 5) & ~strong)

        root, tip, _ = shares()
        self.assertGreater(min(root, tip), 0.01)
        alone, nothing, _ = shares("--hide", "tip")
        self.assertEqual(nothing, 0)
        self.assertGreater(alone, root)
        behind, nothing, veil = shares("--transparent", "tip")
        self.assertEqual(nothing, 0)
        self.assertGreater(veil, 0.5 * tip)
        self.assertGreater(behind, 0.5 * root)
        synthetic.add_obstacles(self.directory)
        pictures = [np.asarray(Image.open(self.draw("--view=front", "--frame", 2, *arguments, *SMALL))).tobytes()
                    for arguments in ([], ["--hide", "pyramid"], ["--transparent", "pyramid"], ["--hide", "floor", "--hide", "pyramid"])]
        self.assertEqual(len(set(pictures)), 4)

    def test_vessels_hide_nothing(self):
        """Their walls behind the bodies are drawn, and have no part in the size of the picture."""
        def picture(*arguments):
            return np.asarray(Image.open(self.draw("--field=none", "--frame", 0, *arguments, *SMALL)).convert("RGB")).astype(int)

        bare = picture()
        synthetic.add_vessel(self.directory)
        within = picture()
        bar = bare[..., 2] > bare[..., 0] + 15
        self.assertGreater(bar.mean(), 0.02)
        is_far = ~np.any([np.roll(bar, (i, j), (0, 1)) != bar for i in (-2, 0, 2) for j in (-2, 0, 2)], axis=0)  # from the edges of the bar
        np.testing.assert_allclose(within[bar & is_far], bare[bar & is_far], atol=1)
        self.assertGreater((np.abs(within - bare).max(axis=2) > 10)[40:].mean(), 0.3, "the walls behind")
        clear = picture("--transparent", "vessel")
        self.assertGreater(np.abs(clear - within).max(), 10)

    def rod_picture(self, *arguments):
        """Shares of pixels that are yellow, the end of the scale, and turquoise, a third of it."""
        image = Image.open(self.draw("--frame", 0, "--view=front", *arguments, *SMALL)).convert("RGB")
        r, g, b = np.moveaxis(np.asarray(image).astype(int)[30:, :240], 2, 0)
        return np.mean((g > b + 60) & (r > b + 60)), np.mean(g > r + 40)

    def test_rods_and_fibres(self):
        synthetic.write_result(self.directory, num_frames=2, order=1, cubes=(4, 2, 2))
        synthetic.add_rods(self.directory)
        high, third = self.rod_picture("--field", "rod_force")
        self.assertGreater(min(high, third), 2e-4, "segments with 3 N and 1 N")
        self.assertEqual(self.rod_picture("--field", "none"), (0, 0))
        self.assertEqual(self.rod_picture("--field", "rod_force", "--hide", "wire")[0], 0)
        high, _ = self.rod_picture("--field", "tension", "--hide", "root", "--hide", "tip", "--hide", "wire")
        self.assertGreater(high, 2e-4, "the fibre alone")
        self.draw("--hide", "root", "--hide", "tip", "--cut", "x", "--mesh-edges", "--outline", *SMALL)
        self.fails("nothing that is drawn has this name; names are root, tip, fibre, wire\n", self.directory, "--hide", "arm")
        self.fails("nothing that can be transparent has this name; names are root, tip\n", self.directory, "--transparent", "fibre")
        self.fails("every body is hidden", self.directory, *(word for name in ("root", "tip", "fibre", "wire") for word in ("--hide", name)))
        names = quantity_of(Result(self.directory), "body").names
        self.assertEqual(names, ["root", "tip", "", ""])

    def test_fibres_alone_have_a_tension(self):
        synthetic.write_result(self.directory, num_frames=2, order=1, cubes=(4, 2, 2))
        synthetic.add_rods(self.directory, has_wire=False)
        self.fails("--field rod_force: fibres, which only stretch, have no such field; their axial force is --field tension", self.directory, "--field", "rod_force")
        self.draw("--field", "tension", *SMALL)

    def test_mirrors_have_rods_and_tendons(self):
        """The image at y = -0.5: seen from above, everything is there twice."""
        synthetic.write_result(self.directory, num_frames=2, order=1, cubes=(4, 2, 2))
        synthetic.add_rods(self.directory)
        plane_at = mirror("y=-0.5")
        options = render_options(self.directory, "--field", "rod_force", "--mirror", "y=-0.5")
        result = Result(self.directory)
        shown = Shown(result, result.frames[:1], options).mechanisms(result[0])
        count = len(shown.segments) // 2
        self.assertEqual((count, len(shown.rods)), (3, 4))
        np.testing.assert_allclose(shown.points[shown.segments[count:]], plane_at.reflected(shown.points[shown.segments[:count]]))
        points, triangles, segment = prisms(shown.rods, shown.has_rectangle, 1e-6)
        a, b, c = (points[triangles[:, k]] for k in range(3))
        volumes = np.bincount(segment, np.einsum("ij,ij->i", np.cross(b - a, c - a), a) / 6)
        np.testing.assert_allclose(volumes, volumes[0], err_msg="outward normals in the image, too")
        np.testing.assert_array_equal(shown.rod_colours[2:], shown.rod_colours[:2])
        y = points[triangles[segment >= 2]][..., 1]
        np.testing.assert_allclose([y.min(), y.max()], [-0.62, -0.58], atol=1e-12)

    def test_cuts_mirrors_maps_and_scale(self):
        """Seen from the front the bar fills a rectangle, from which a scale is read; cut by a plane that the viewer looks along half of
        its height is left, and with its image at its end it is twice as long."""
        def picture(*arguments):
            return np.asarray(Image.open(self.draw("--field=none", "--frame", 0, "--view=front", "--size=640x480", *arguments)).convert("RGB")).astype(int)

        def columns(image):
            scene = image[60:400]
            return np.nonzero((np.abs(scene - scene[-1, 0]).max(axis=2) > 12).sum(axis=0) > 10)[0]

        whole = columns(picture("--no-axes"))
        length = whole[-1] - whole[0]
        # The scale bar is a line of one colour, at the bottom.
        bar = picture()[400:, 60:]
        is_ink = np.abs(bar - [45, 49, 57]).max(axis=2) < 30
        bar_length = is_ink.sum(axis=1).max()
        # 0.1 m in the depth of the bar's middle; its front is 0.1 m nearer to the viewer.
        self.assertAlmostEqual(bar_length / length, 0.1 / synthetic.LENGTH, delta=0.1 * 0.1)
        # Cut in the middle of its height, half of that is left.
        def height(image):
            rows = np.nonzero((np.abs(image[60:400] - image[-1, 0]).max(axis=2) > 12).any(axis=1))[0]
            return rows[-1] - rows[0]

        def slenderness(*arguments):
            image = picture("--no-axes", *arguments)
            return height(image) / np.ptp(columns(image))

        self.assertAlmostEqual(slenderness("--cut", "z=0") / slenderness(), 0.5, delta=0.05)
        # The camera fits what is drawn: of the mirrored bar, the height is half.
        self.assertAlmostEqual(height(picture("--no-axes", "--mirror", "x")) / height(picture("--no-axes")), 0.5, delta=0.05)
        # Values keep or change their sign in an image; colours of all maps differ.
        colours = {name: picture("--no-axes", "--field=displacement_x", "--frame=1", "--colour-map", name) for name in
                   ("viridis", "cividis", "inferno", "greys", "diverging")}
        self.assertEqual(len({image.tobytes() for image in colours.values()}), 5)
        r, g, b = np.moveaxis(picture("--no-axes", "--field=displacement_x", "--frame=1", "--mirror=x", "--colour-map=diverging")[60:400, :480], 2, 0)
        for is_one in (r > b + 60, b > r + 60):
            self.assertGreater(is_one.sum(), 500, "red on one side, blue on the other")
        for arguments, words in ((("--cut", "w"), "invalid plane"), (("--cut", "x=3in"), "invalid plane"), (("--mirror", "1,1,0"), "invalid plane"), (("--cut", "x=2", "--view=left"), "nothing of a body is left"),
                                 (("--colour-map", "jet"), "invalid choice"), (("--cut", "y", "-o", "a.glb"), "has no effect on a .glb")):
            self.fails(words, self.directory, *arguments)

    def test_pictures_of_one_result_have_one_range(self):
        """Whichever frame they show."""
        bars = []
        for frame in (0, 1, 2):  # the bar is straight in the first and the last
            image = Image.open(self.draw("--frame", frame, "--field", "velocity_z", "--no-axes", *SMALL)).convert("RGB")
            bars.append(np.asarray(image)[60:, 268:])
        for other in bars[1:]:
            np.testing.assert_array_equal(other, bars[0])
        for text in ("", "x=", "0,0,0", "x=1=2", "nan,0,1", "x=nan"):
            with self.assertRaises(ValueError):
                plane(text)

    def test_lines_inside_of_bodies_have_no_rims(self):
        """Through a dark body a red line is seen in dark red, without the colour of the background."""
        synthetic.add_mechanisms(self.directory)
        file = self.draw("--view=0.3,-1,0.2", "--field", "displacement", "--frame", 0, "--hide", "coil", "--hide", "root_hinge", "--no-axes", "--size", "640x480")
        columns = np.asarray(Image.open(file).convert("RGB")).astype(int)[:, 200:400]
        red = (columns[..., 0] > columns[..., 1] + 60) & (columns[..., 0] > columns[..., 2] + 20)
        rows = np.nonzero(red.any(axis=1))[0]
        self.assertTrue(10 < np.ptp(rows) < 40, rows)
        self.assertLess(columns[rows.min() - 8:rows.max() + 8, :, 1].max(), 65)

    def test_values_that_are_not_finite_have_no_part_in_the_range(self):
        with h5py.File(self.path("result.h5"), "r+") as h5:
            for frame in h5["frames"].values():
                gap = np.full(len(h5["mesh/coordinates"]), np.inf)
                gap[:20] = np.linspace(-1e-4, 2e-3, 20)
                frame["contact_gap"] = gap
                frame["contact_gap"].attrs.update({"unit": "m", "location": "node"})
        pixels = self.body_pixels(Image.open(self.draw("--field", "contact_gap", *SMALL)))
        self.assertGreater(len(pixels), 1000)
        yellow = pixels[:, 2] < 0.5 * pixels[:, 0]  # the end of the scale, where nothing is near, in any light
        self.assertGreater(yellow.mean(), 0.5)
        self.assertEqual((pixels.max(axis=1) < 25).sum(), 0)

    def test_runs_that_were_resumed(self):
        """On more ranks, and with other fields."""
        with h5py.File(self.path("result.h5"), "r+") as h5:
            h5.copy("mesh", "mesh_1")
            h5["mesh_1/rank"][()] = np.arange(len(h5["mesh_1/rank"])) % 5
            h5["frames/000002"].attrs["mesh"] = "/mesh_1"
            h5["frames/000002/acceleration"] = h5["frames/000002/velocity"][()]
        self.assertEqual(quantity_of(Result(self.directory), "rank").names, ["0", "1", "2", "3", "4"])
        self.draw("--field", "rank", *SMALL)
        self.draw("--field", "rank", "-o", self.path("ranks.glb"))
        self.draw("--field", "acceleration_z", *SMALL)
        self.fails("Frame(time=0, step=0) has no field 'acceleration'; it is in 1 of 3 frames", self.directory, "--field", "acceleration", "--frames")

    def test_views_differ(self):
        pictures = []
        for view in ("iso", "front", "top", "-1,0.5,0.3"):
            self.draw("--view", view, "--frame", 1, "-o", self.path("view.png"), *SMALL)
            pictures.append(np.asarray(Image.open(self.path("view.png"))).tobytes())
        self.assertEqual(len(set(pictures)), 4)

    def test_frames_and_movies(self):
        self.draw("--frames", *SMALL)
        frames = sorted(os.listdir(self.path("frames")))
        self.assertEqual(frames, ["frame_0000.png", "frame_0001.png", "frame_0002.png"])
        # The synthetic bar swings back to its start: the camera and the colours are the same, and so is the body.
        first, last = (self.body_pixels(Image.open(self.path(f"frames/{frames[i]}"))) for i in (0, 2))
        np.testing.assert_array_equal(first, last)
        movie = self.draw("--movie", "mp4", *SMALL)
        probe = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames", "-of",
                                "csv=p=0", movie], capture_output=True, text=True, check=True)
        self.assertEqual(probe.stdout.strip(), "3")
        with Image.open(self.draw("--movie", "gif", *SMALL)) as animation:
            self.assertEqual(animation.n_frames, 3)

    def test_linear_elements(self):
        synthetic.write_result(self.directory, num_frames=2, order=1)
        self.assertGreater(len(self.body_pixels(Image.open(self.draw(*SMALL)))), 1000)

    def test_mistakes_are_told_in_one_line(self):
        self.fails("does not exist", self.path("missing"), code=4)
        self.fails("no field 'dispalcement'; did you mean 'displacement'? It has", self.directory, "--field", "dispalcement")
        self.fails("did you mean 'von_mises_stress'?", self.directory, "--field", "vonmises")
        self.fails("finger.yaml is an input, not a result: give the directory of its results, such as out/finger\n", self.path("finger.yaml"))
        self.fails("no component 'q'", self.directory, "--field", "velocity_q")
        self.fails("is a tensor", self.directory, "--field", "cauchy_stress")
        self.fails("--frame 3: the result has the frames 0 to 2", self.directory, "--frame", "3")
        self.fails("--hide arm: nothing that is drawn has this name; names are root, tip", self.directory, "--hide", "arm")
        self.fails("nothing that can be transparent has this name", self.directory, "--transparent", "arm")
        self.fails("every body is hidden", self.directory, "--hide", "root", "--hide", "tip")
        self.fails("--field tension: the result has no tendons", self.directory, "--field", "tension")
        self.fails("--size", self.directory, "--size", "big")
        self.fails("none of iso, front, back, right, left, top, bottom, nor a direction such as", self.directory, "--view", "0,0,0")
        self.fails("'side' is none of iso, front, ", self.directory, "--view", "side")
        self.fails("No such file", self.directory, "-o", self.path("missing/picture.png"), code=4)
        self.fails("picture.xyz", self.directory, "-o", self.path("picture.xyz"))
        with h5py.File(self.path("other.h5"), "w"):
            pass
        self.fails("is not a result", self.path("other.h5"), code=4)
        with open(self.path("text.h5"), "w", encoding="utf-8") as text:
            text.write("no HDF5")
        self.fails("is not an HDF5 file", self.path("text.h5"), code=4)

    def test_fields_that_are_zero_have_one_number_at_their_bar(self):
        colours = Colours(0.0, 0.0)
        self.assertEqual((colours.only, Colours(0.0, 1.0).only, Colours(-2.0, -2.0).only), (0.0, None, -2.0))
        bar = [np.asarray(Page((640, 400), "", Quantity("displacement", -1, "displacement", "m", []), c).compose(np.zeros((10, 10, 3), np.uint8), ""))[:, -68:]
               for c in (colours, Colours(0.0, 1.0))]
        rows = [(np.abs(image.astype(int) - [45, 49, 57]).max(axis=2) < 150).any(axis=1)[120:] for image in bar]  # of the numbers
        count = [np.count_nonzero(np.diff(row.astype(int)) == 1) for row in rows]
        self.assertEqual(count[0], 1)
        self.assertGreater(count[1], 3)


    def test_axes_and_scale_are_seen_before_a_body(self):
        """Of any colour, that of the ink too: what is behind them is faint; where there is nothing, it stays so."""
        camera = fitted_camera((0.62, -1.0, 0.48), [np.random.default_rng(1).random((8, 3))], (640, 400))
        for colour in (INK, (250, 250, 252)):
            page = Page((640, 400), "", None, None)
            image = np.asarray(page.compose(np.full((*page.scene_size[::-1], 3), colour, np.uint8), "", camera)).astype(int)
            corner = image[366:392, 66:100]
            self.assertGreater(np.ptp(corner.mean(axis=2)), 120)
            drawn = (np.abs(corner - corner[0, 0]).max(axis=2) > 20).mean()
            self.assertTrue(0.02 < drawn < 0.3, drawn)
            self.assertEqual(image[200:300].reshape(-1, 3).ptp(axis=0).max(), 0)


class SurfaceOfBlock(WithResult):
    def test_a_mass_is_an_ellipsoid(self):
        """In the box [-1, 1] x [-2, 2] x [-3, 3], and beside it an ordinary tetrahedron."""
        box = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * [1, 2, 3]
        other = np.array([[10.0, 0, 0], [11, 0, 0], [10, 1, 0], [10, 0, 1]])
        x = np.vstack([box, other])
        for order in ([1, 0, 2, 3], [0, 2, 1, 3]):
            mesh = Mesh(x, np.array([order, [4, 5, 6, 7]]), np.array([0, 1]), ["bob", "block"], ["bob"])
            surface = Surface(mesh)
            points = surface.of_nodes(x)
            of_bob = surface.cell_of_face[surface.face_of_triangle] == 0
            self.assertEqual((of_bob.sum(), (~of_bob).sum()), (512, 4))
            np.testing.assert_allclose(np.linalg.norm(points[surface.triangles[of_bob]] / [1, 2, 3], axis=2), 1, atol=1e-14)
            a, b, c = (points[surface.triangles[:, k]] for k in range(3))
            volumes = np.einsum("ij,ij->i", np.cross(a, b), c) / 6
            self.assertAlmostEqual(volumes[of_bob].sum() / (8 * np.pi), 1, delta=0.03)
            self.assertAlmostEqual(volumes[~of_bob].sum(), 1 / 6)
        # Divided into eight cells.
        middles = np.array([x[a] + x[b] for a, b in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]) / 2
        parts = [[0, 8, 10, 11], [8, 1, 9, 12], [10, 9, 2, 13], [11, 12, 13, 3], [8, 10, 11, 12], [8, 10, 9, 12], [10, 11, 12, 13], [10, 9, 12, 13]]
        divided = Surface(Mesh(np.vstack([x, middles]), np.array([*parts, [4, 5, 6, 7]]), np.array([0] * 8 + [1]), ["bob", "block"], ["bob"]))
        self.assertEqual(len(divided.triangles), 516)

    def test_area_and_outward_normals(self):
        for order in (1, 2):
            directory = self.path(f"order{order}")
            synthetic.write_result(directory, num_frames=1, order=order)
            result = Result(directory)
            surface = Surface(result[0].mesh)
            x = surface.of_nodes(result[0].mesh.coordinates)
            a, b, c = (x[surface.triangles[:, i]] for i in range(3))
            area = np.cross(b - a, c - a) / 2
            length, width, height = synthetic.LENGTH, synthetic.WIDTH, synthetic.HEIGHT
            whole = 2 * (length * width + width * height + height * length)
            self.assertAlmostEqual(np.linalg.norm(area, axis=1).sum(), whole, places=12)
            # The divergence theorem gives the volume, with its sign, if all normals point outward.
            self.assertAlmostEqual((area * (a + b + c)).sum() / 9, length * width * height, places=12)
            # Each point is there once: Euler's formula of a closed surface.
            self.assertEqual(len(x) - len(surface.triangles) // 2, 2)

    def test_the_outside_of_one_body_alone(self):
        synthetic.write_result(self.directory, num_frames=1, cubes=(4, 2, 2))
        mesh = Result(self.directory)[0].mesh
        tip = np.nonzero(mesh.body == 1)[0]
        surface = Surface(mesh, cells=tip)
        self.assertEqual(set(mesh.body[surface.cell_of_face]), {1})
        x = surface.of_nodes(mesh.coordinates)
        a, b, c = (x[surface.triangles[:, i]] for i in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        half = synthetic.LENGTH / 2
        self.assertAlmostEqual(area, 4 * half * synthetic.WIDTH + 2 * synthetic.WIDTH**2, delta=1e-12)
        # Values of cells are averaged over its own cells, not over those of its neighbour.
        np.testing.assert_allclose(surface.of_cells(mesh.body[:, None].astype(float)), 1)

    def test_cut_surfaces_are_closed(self):
        """The divergence theorem gives the volume below a plane, of each body and of both, and a linear field is exact everywhere."""
        for order in (1, 2):
            directory = self.path(f"order{order}")
            synthetic.write_result(directory, num_frames=1, order=order, cubes=(6, 2, 2))
            mesh = Result(directory)[0].mesh
            for text, volume in (("x=0.3", 0.3), ("-1,0,0=-0.3", 0.7), ("z", 0.5), ("1,0,1=0.25", 0.25 * np.sqrt(2)), ("x=-1", 0), ("x=2", 1), ("x=300mm", 0.3), ("x = 30 cm", 0.3)):
                cut = plane(text)
                cut = Plane(cut.normal, 0.0 if cut.offset is None else cut.offset)
                cells = np.arange(len(mesh.cells))
                if volume == 0:
                    self.assertEqual(len(CutSurface(Surface(mesh), mesh, cells, cut).triangles), 0)
                    continue
                surface = CutSurface(Surface(mesh), mesh, cells, cut)
                x = surface.of_nodes(mesh.coordinates)
                a, b, c = (x[surface.triangles[:, i]] for i in range(3))
                found = np.einsum("ij,ij->", np.cross(b - a, c - a), a + b + c) / 18
                self.assertAlmostEqual(found, volume * synthetic.LENGTH * synthetic.WIDTH * synthetic.HEIGHT, places=12, msg=text)
                self.assertLess(cut.heights(x).max(), 1e-12)
                linear = lambda x: x @ [[1.0], [2], [3]] + 4  # noqa: E731
                np.testing.assert_allclose(surface.of_nodes(linear(mesh.coordinates)), linear(x), atol=1e-12)
                np.testing.assert_allclose(surface.of_cells(np.full((len(mesh.cells), 1), 7.0)), 7.0)
                at_cut = np.abs(cut.heights(x[surface.triangles])).max(axis=1) < 1e-12
                self.assertTrue(np.isin(mesh.body[surface.cell_of_face[surface.face_of_triangle[at_cut]]], [0, 1]).all())
                # The same of curved elements: the vector of the area of a closed surface is 0.
                for divisions in (None, 2, 3):
                    surface = CutSurface(Surface(mesh, divisions), mesh, cells, cut)
                    x = surface.of_nodes(mesh.coordinates + np.random.default_rng(1).uniform(-0.02, 0.02, mesh.coordinates.shape))
                    a, b, c = (x[surface.triangles[:, i]] for i in range(3))
                    np.testing.assert_allclose(np.cross(b - a, c - a).sum(axis=0), 0, atol=1e-12, err_msg=f"{order} {text} {divisions}")
        self.assertEqual((mirror("y=0.5").offset, mirror("y").offset), (0.5, 0.0))
        # With straight sides, quadratic elements have the outlines of linear ones in a section: pieces of them, as the nodes on edges divide them.
        lengths = []
        for order in (1, 2):
            mesh = Result(self.path(f"order{order}"))[0].mesh
            surface = CutSurface(Surface(mesh), mesh, np.arange(len(mesh.cells)), plane("1,0.3,0.1=0.31"))
            x = surface.of_nodes(mesh.coordinates)
            ends = x[surface.element_edges]
            in_section = np.abs(plane("1,0.3,0.1=0.31").heights(ends)).max(axis=1) < 1e-12
            ends = np.unique(np.sort(surface.element_edges[in_section], axis=1), axis=0)
            lengths.append(np.linalg.norm(x[ends[:, 1]] - x[ends[:, 0]], axis=1).sum())
        self.assertAlmostEqual(lengths[1], lengths[0], places=12)

    def test_rods_are_as_thick_as_they_are(self):
        """A round rod and a rectangular one, whose corners are in any order."""
        x = np.array([[0.0, 0, 0], [0.3, 0, 0], [0.15, 0.02, 0], [0.15, 0, 0.02], [0, 1, 0], [0, 1, 0.2], [0.03, 1, 0.1], [0, 1.01, 0.1]])
        for order in ([0, 1, 2, 3], [2, 0, 3, 1], [3, 2, 1, 0]):
            mesh = Mesh(x, np.array([order, [4 + k for k in order]]), np.array([0, 1]), ["wire", "band"], rods=["wire", "band"], rectangular_rods=["band"])
            shapes = RodShapes(mesh)
            points, triangles, segment = prisms(shapes.at(x), shapes.is_rectangular, 1e-6)
            a, b, c = (points[triangles[:, k]] for k in range(3))
            volumes = np.bincount(segment, np.einsum("ij,ij->i", np.cross(b - a, c - a), a) / 6)
            polygon = 8 * np.sin(np.pi / 8)  # area of the regular polygon of 16 sides in a unit circle
            np.testing.assert_allclose(volumes, [polygon * 0.02**2 * 0.3, 4 * 0.03 * 0.01 * 0.2], rtol=1e-12)
            thin, _, _ = prisms(shapes.at(x), shapes.is_rectangular, 0.1)
            np.testing.assert_allclose(np.linalg.norm(thin[:32, 1:], axis=1), 0.1, rtol=1e-12)  # at least so thick

    def test_quadratic_fields_are_shown_exactly(self):
        synthetic.write_result(self.directory, num_frames=1, order=2)
        result = Result(self.directory)
        mesh = result[0].mesh
        surface = Surface(mesh, divisions=3)
        quadratic = lambda x: (x[:, :1] ** 2 - x[:, 1:2] * x[:, 2:])  # noqa: E731
        points = surface.of_nodes(mesh.coordinates)
        np.testing.assert_allclose(surface.of_nodes(quadratic(mesh.coordinates)), quadratic(points), atol=1e-14)
        np.testing.assert_allclose(surface.of_cells(np.full((len(mesh.cells), 1), 7.0)), 7.0)

    def test_fields_do_not_overshoot(self):
        """Random values at nodes, and a peak at one: points have values between those of the nodes around them; linear fields are exact."""
        synthetic.write_result(self.directory, num_frames=1, order=2, cubes=(3, 2, 2))
        mesh = Result(self.directory)[0].mesh
        surface, cells = Surface(mesh, divisions=4), np.arange(len(mesh.cells))
        peak = np.zeros((len(mesh.coordinates), 1))
        peak[surface._nodes[0, 0]] = 1
        noise = np.random.default_rng(3).uniform(0, 1, (len(mesh.coordinates), 2))
        self.assertLess(surface.of_nodes(peak).min(), -0.1, "positions follow the elements, whose shape functions overshoot")
        linear = mesh.coordinates @ [[1.0], [2], [3]] + 4
        for shown in (surface, CutSurface(surface, mesh, cells, Plane(np.array([0, 1.0, 0]), 0.03))):
            for values in (peak, noise):
                found = shown.field_of_nodes(values)
                self.assertGreaterEqual(found.min(), 0)
                self.assertLessEqual(found.max(), 1)
            np.testing.assert_allclose(shown.field_of_nodes(linear), shown.of_nodes(linear), atol=1e-12)
            of_cells = shown.of_cells(np.eye(1, len(cells), 5).T)
            self.assertGreaterEqual(of_cells.min(), 0)
        # Facet by facet: within the range of its own six nodes.
        low, high = (bound(noise[surface._nodes[surface.triangles.reshape(-1, 16, 3)]], axis=(1, 2, 3)) for bound in (np.min, np.max))
        found = surface.field_of_nodes(noise)[surface.triangles.reshape(-1, 16, 3)]
        self.assertTrue((found >= low[:, None, None]).all() and (found <= high[:, None, None]).all())
        frame = Result(self.directory)[0]
        of_vectors = quantity_of(frame.result, "velocity").at_points(frame, surface)
        self.assertLessEqual(of_vectors.max(), np.linalg.norm(frame["velocity"], axis=1).max())

    def test_which_obstacles_are_vessels(self):
        sphere, of_sphere = _sphere(2)
        angles = 2 * np.pi * np.arange(12) / 12
        rings = [np.column_stack([np.cos(angles), np.sin(angles), np.full(12, z)]) for z in (-10, 10)]
        k, following = np.arange(12), (np.arange(12) + 1) % 12
        tube = np.concatenate([np.stack([k, following, 12 + following], axis=1), np.stack([k, 12 + following, 12 + k], axis=1)])  # from outside
        x, y = (grid.ravel() for grid in np.meshgrid(np.arange(9.0), np.arange(9.0)))
        waves = np.column_stack([x, y, 0.3 * np.sin(x)])
        corner = (np.arange(8)[:, None] + 9 * np.arange(8)).ravel()
        sheet = np.concatenate([np.stack([corner, corner + 1, corner + 10], axis=1), np.stack([corner, corner + 10, corner + 9], axis=1)])
        for points, triangles, expected in ((sphere, of_sphere, False), (sphere, of_sphere[:, ::-1], True), (np.vstack(rings), tube, False),
                                            (np.vstack(rings), tube[:, ::-1], True), (waves, sheet, False), (waves, sheet[:, ::-1], False)):
            obstacles = Obstacles(points, triangles, np.zeros(len(triangles), dtype=int), ["one"])
            self.assertEqual(obstacles.vessels(), [0] if expected else [])

    def test_von_mises(self):
        # Uniaxial tension, pure shear, pressure.
        stress = np.array([[3.0, 0, 0, 0, 0, 0], [0, 0, 0, 1, 0, 0], [2, 2, 2, 0, 0, 0]])
        np.testing.assert_allclose(von_mises(stress), [3, np.sqrt(3), 0])


class Texts(WithResult):
    def test_what_is_printed_is_short(self):
        synthetic.write_result(self.directory, num_frames=3, order=1, cubes=(4, 2, 2))
        synthetic.add_rods(self.directory)
        result = Result(self.directory)
        self.assertEqual(repr(result.rods), "{'fibre': Line(3 frames, 2 points), 'wire': Line(3 frames, 3 points)}")
        mesh = result[0].mesh
        self.assertEqual(repr(mesh), f"Mesh({len(mesh.coordinates)} nodes, {len(mesh.cells)} cells; root, tip, fibre, wire)")
        self.assertEqual(repr(result[0].field("rod_force")), f"Field({len(mesh.cells)} cells x 1, N)")
        self.assertEqual(repr(result[0].mechanisms), "Mechanisms(fibre: rod, wire: rod; 3 segments)")
        self.assertIn("<th>bodies</th><td>root, tip</td>", re.sub(r" (style|class)=\S+?(?=>)|\n", "", result._repr_html_()))
        result.close()
        synthetic.add_vessel(self.directory)
        self.assertEqual(repr(Result(self.directory)[0].obstacles), "Obstacles(vessel; 12 triangles)")


class Plots(WithResult):
    def test_history(self):
        synthetic.write_history(self.directory)
        file = self.draw(tool="plot.py")
        self.assertEqual(file, self.path("history.png"))
        self.assertGreater(len(np.unique(np.asarray(Image.open(file).convert("RGB")).reshape(-1, 3), axis=0)), 100)
        with open(self.path("history.csv"), "a", encoding="utf-8") as history:
            history.write("201,1.00")  # a row that is just being written
        self.assertEqual(self.draw("-o", self.path("plot.pdf"), tool="plot.py"), self.path("plot.pdf"))

    def test_columns_from_fields_are_drawn(self):
        synthetic.write_history(self.directory)
        heights = []
        for entries in ("[]", "[{name: tip_x, of: displacement_x, in: tip, take: mean}, {name: tip_y, of: von_mises_stress, take: max}]"):
            with open(self.path("run.yaml"), "w", encoding="utf-8") as file:
                file.write(f"output: {{history: {entries}}}\n")
            with Image.open(self.draw(tool="plot.py")) as picture:
                heights.append(picture.size[1])
        self.assertGreater(heights[1], heights[0] + 300)  # a row of two more

    def test_axes_have_handy_units_and_words(self):
        """A single plot fills the picture; numbers at its axes are small ones with the unit of the label."""
        history = {"time": np.linspace(0, 0.03, 4), "chamber_pressure": np.linspace(0, 8e4, 4), "chamber_volume": np.linspace(1e-6, 5e-6, 4),
                   "wall_fz": np.linspace(-0.02, 0.05, 4), "tip_ux": np.zeros(4), "hinge_tx": np.linspace(0, 2e3, 4)}

        def axes_of(columns, x=None):
            with plt.rc_context(plot.STYLE):
                figure = plot.draw(history, "title", {}, "", columns, x)
                figure.canvas.draw()
                self.addCleanup(plt.close, figure)
            shown = [[axis.get_label_text(), *(text.get_text() for text in axis.get_ticklabels())] for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
            self.assertEqual({axis.get_offset_text().get_text() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)}, {""})
            return figure, shown

        figure, (x, y) = axes_of(["chamber_pressure"], "chamber_volume")
        self.assertGreater(figure.axes[0].get_position().x1, 0.95)
        self.assertEqual((x[0], y[0]), ("volume of chamber [cm³]", "pressure in chamber [kPa]"))
        self.assertIn("20", y)
        self.assertIn("3", [text.removesuffix(".0") for text in x])
        figure, (x, y) = axes_of(["wall_fz"])
        self.assertEqual((x[0], y[0]), ("time [ms]", "force of wall in z [mN]"))
        self.assertIn("\u221220", y)
        with mock.patch.object(plot, "unit_of_column", lambda *_: "kg/m^3"):
            self.assertEqual(axes_of(["hinge_tx"])[1][1][0], "torque of hinge about x [kg/m³]")
        self.assertEqual(axes_of(["tip_ux"])[1][1][0], "displacement of tip in x [m]")
        for joint, moves, unit in (("slide", "travel", "N"), ("knee", "angle", "N m")):
            history |= {f"{joint}_{moves}": np.zeros(4), f"{joint}_effort": np.linspace(0, 2, 4)}
            self.assertEqual(axes_of([f"{joint}_effort"])[1][1][0], f"effort of {joint} [{unit}]")
        figure, shown = axes_of(["wall_fz", "hinge_tx"])
        self.assertEqual([label for label, *_ in shown], ["time [ms]", "force of wall in z [mN]", "time [ms]", "torque of hinge about x [kN m]"])
        self.assertEqual(len(figure.axes), 2)

    def test_history_of_the_initial_state_alone(self):
        synthetic.write_history(self.directory, num_steps=1)
        with open(self.path("history.csv"), encoding="utf-8") as history:
            start = history.readlines()[:2]
        with open(self.path("history.csv"), "w", encoding="utf-8") as history:
            history.writelines(start)
        self.draw(tool="plot.py")

    def test_mistakes_are_told_in_one_line(self):
        self.fails("does not exist", self.directory, tool="plot.py", code=4)
        with open(self.path("history.csv"), "w", encoding="utf-8") as history:
            history.write("a,b\n1,2\n")
        self.fails("is not a history", self.directory, tool="plot.py", code=4)
        synthetic.write_history(self.directory)
        self.fails("plot.xyz", self.directory, "-o", self.path("plot.xyz"), tool="plot.py")


class WorkPrecision(unittest.TestCase):
    HEAD = ("method,level,step,size,error_displacement,error_velocity,order_displacement,order_velocity,"
            "newton_iterations,seconds\n")

    def setUp(self):
        self.directory = tempfile.mkdtemp(prefix="pliant-tools-")
        self.addCleanup(shutil.rmtree, self.directory)
        self.table = os.path.join(self.directory, "convergence.csv")

    def write(self, text):
        with open(self.table, "w", encoding="ascii") as file:
            file.write(text)

    def test_a_study_is_drawn(self):
        rows = [f"{method},{k},{2**-k},1,{4.0**-k},{4.0**-k},2,2,{100 * 2**k},{2**k}" for method in ("bdf2", "petsc:alpha2")
                for k in range(3)]
        self.write(self.HEAD + "\n".join(rows) + "\ndirk22,0,1,1,nan,nan,nan,nan,10,1\n")
        done = run("work_precision.py", self.directory)
        self.assertEqual(done.returncode, 0, done.stderr)
        with Image.open(done.stdout.strip()) as picture:
            both = picture.size
        done = run("work_precision.py", self.table, "--work", "seconds", "-o", os.path.join(self.directory, "one.png"))
        self.assertEqual(done.returncode, 0, done.stderr)
        with Image.open(done.stdout.strip()) as picture:
            self.assertLess(picture.size[1], both[1])

    def test_mistakes_are_told_in_one_line(self):
        for text, message in ((None, "does not exist"), (self.HEAD, "holds no level"), ("a,b\n1,2\n", "is not a study")):
            if text is not None:
                self.write(text)
            done = run("work_precision.py", self.directory)
            self.assertEqual(done.returncode, 2)
            self.assertIn(message, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1, done.stderr)


if __name__ == "__main__":
    unittest.main()
