#!/usr/bin/python3
"""Models in glTF: a reader of their own finds what the result has, where it is, at every frame."""
import json
import os
import struct
import unittest

import h5py
import numpy as np

import synthetic
from test_tools import WithResult

from pliant import Result, Surface  # noqa: I001

KINDS = {5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Glb:
    """A .glb, read by the specification, which it must follow."""

    def __init__(self, file):
        with open(file, "rb") as stream:
            data = stream.read()
        magic, version, length, text, kind = struct.unpack("<4sIII4s", data[:20])
        assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
        self.json = json.loads(data[20: 20 + text])
        size, kind = struct.unpack("<I4s", data[20 + text: 28 + text])
        self.binary = data[28 + text:]
        assert text % 4 == 0 and (size, kind) == (len(self.binary), b"BIN\0"), "chunks"
        assert self.json["asset"]["version"] == "2.0" and self.json["buffers"] == [{"byteLength": size}]
        self.nodes = {self.json["nodes"][n]["name"]: self.json["nodes"][n] for n in self.json["scenes"][self.json["scene"]]["nodes"]}

    def array(self, index, check_range=False):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(KINDS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == accessor["count"] * width * kind.itemsize
        values = np.frombuffer(self.binary, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        assert np.isfinite(values).all()
        if check_range:
            np.testing.assert_array_equal(np.array(accessor["min"], np.float32), values.min(axis=0))
            np.testing.assert_array_equal(np.array(accessor["max"], np.float32), values.max(axis=0))
        return values

    def primitive(self, name):
        (primitive,) = self.json["meshes"][self.nodes[name]["mesh"]]["primitives"]
        return primitive

    def cells(self, name):
        primitive = self.primitive(name)
        count = len(self.array(primitive["attributes"]["POSITION"]))
        cells = self.array(primitive["indices"]).astype(int)
        assert set(np.unique(cells)) == set(range(count)), "each vertex is used, and there are no others"
        return cells.reshape(-1, {4: 3, 1: 2}[primitive["mode"]])

    def animated(self, name, path="weights"):
        """(times, values) of a node."""
        number = self.json["nodes"].index(self.nodes[name])
        (animation,) = self.json["animations"]
        (channel,) = [c for c in animation["channels"] if c["target"] == {"node": number, "path": path}]
        sampler = animation["samplers"][channel["sampler"]]
        times = self.array(sampler["input"], check_range=True)[:, 0]
        assert times[0] >= 0 and (np.diff(times) > 0).all()
        return times, self.array(sampler["output"]).reshape(len(times), -1)

    def over_time(self, name, attribute="POSITION"):
        """Times, and the attribute at each of them: frames x vertices x 3."""
        primitive = self.primitive(name)
        base = self.array(primitive["attributes"][attribute], check_range=attribute == "POSITION")
        shapes = np.stack([self.array(target[attribute], check_range=attribute == "POSITION") for target in primitive["targets"]])
        assert self.json["meshes"][self.nodes[name]["mesh"]]["weights"] == [0] * len(shapes)
        times, weights = self.animated(name)
        assert weights.min() >= 0 and weights.max() <= 1, "what Blender takes"
        return times, base + np.einsum("fk,kvc->fvc", weights, shapes)


def z_up(points):
    return np.stack([points[..., 0], -points[..., 2], points[..., 1]], axis=-1)


def nearest(points, among):
    """For each point the number of the nearest of others, and how far it is."""
    distance = np.linalg.norm(points[:, None] - among[None], axis=2)
    return distance.argmin(axis=1), distance.min(axis=1)


class Models(WithResult):
    def setUp(self):
        super().setUp()
        synthetic.write_result(self.directory, num_frames=7, cubes=(6, 2, 2))

    def model(self, *arguments):
        file = self.draw("-o", self.path("model.glb"), *arguments)
        self.assertEqual(file, self.path("model.glb"))
        return Glb(file)

    def test_bodies_are_where_the_result_has_them(self):
        glb, result = self.model(), Result(self.directory)
        self.assertEqual(set(glb.nodes), {"root", "tip"})
        self.assertEqual(glb.json["scenes"][0]["name"], "cantilever under gravity")
        size = np.linalg.norm([synthetic.LENGTH, synthetic.WIDTH, synthetic.HEIGHT])
        for number, name in enumerate(("root", "tip")):
            surface = Surface(result[0].mesh, 2, cells=np.nonzero(result[0].mesh.body == number)[0])
            times, positions = glb.over_time(name)
            np.testing.assert_allclose(times, result.times, rtol=1e-6)
            of_result = np.stack([surface.of_nodes(frame.positions()) for frame in result])
            point, distance = nearest(z_up(positions[0]), of_result[0])
            self.assertEqual(set(point), set(range(len(of_result[0]))))
            self.assertLess(distance.max(), 1e-4 * size)
            self.assertGreater(np.abs(of_result[3] - of_result[0]).max(), 0.1 * synthetic.LENGTH if name == "tip" else 0)
            self.assertLess(np.linalg.norm(z_up(positions) - of_result[:, point], axis=2).max(), 1.5e-4 * size)
            # Three frames of the swing are the same as three others; a bar bent in a plane needs few shapes.
            self.assertLessEqual(len(glb.primitive(name)["targets"]), 5)
            # Closed, and counterclockwise seen from outside: the divergence theorem gives the volume with its sign.
            cells = glb.cells(name)
            for x in positions.astype(float):
                a, b, c = (x[cells[:, k]] for k in range(3))
                volume = np.einsum("ij,ij->i", np.cross(a, b), c).sum() / 6
                self.assertAlmostEqual(volume, synthetic.LENGTH * synthetic.WIDTH * synthetic.HEIGHT / 2, delta=2e-2 * volume)

    def test_normals_follow_the_motion_and_keep_edges_sharp(self):
        glb = self.model()
        for name in ("root", "tip"):
            cells = glb.cells(name)
            _, positions = glb.over_time(name)
            _, normals = glb.over_time(name, "NORMAL")
            base = glb.array(glb.primitive(name)["attributes"]["NORMAL"])
            np.testing.assert_allclose(np.linalg.norm(base, axis=1), 1, atol=1e-5)
            for x, n in zip(positions.astype(float), normals):
                n = n / np.linalg.norm(n, axis=1)[:, None]
                a, b, c = (x[cells[:, k]] for k in range(3))
                faces = np.cross(b - a, c - a)
                faces /= np.linalg.norm(faces, axis=1)[:, None]
                # Flat faces with edges of 90 degrees: no vertex averages over an edge. 10 degrees for the bending between neighbours.
                for k in range(3):
                    self.assertGreater(np.einsum("ij,ij->i", faces, n[cells[:, k]]).min(), np.cos(np.radians(10)))

    def test_colours_are_those_of_the_shown_frame(self):
        def colours(glb, name="tip"):
            values = glb.array(glb.primitive(name)["attributes"]["COLOR_0"])
            accessor = glb.json["accessors"][glb.primitive(name)["attributes"]["COLOR_0"]]
            self.assertTrue(accessor["normalized"])
            self.assertEqual(set(values[:, 3]), {65535})
            return values[:, :3] / 65535

        bent = self.model("--movie", "glb", "--frame", 3)
        self.assertEqual(bent.json["scenes"][0]["extras"]["step"], 30)
        _, x = bent.over_time("tip")
        np.testing.assert_allclose(x[3], bent.array(bent.primitive("tip")["attributes"]["POSITION"]), atol=1e-6)
        end = np.linalg.norm(x[3] - x[0], axis=1).argmax()
        # Linear light of viridis at its ends: yellow at the end of the bar, and dark violet where nothing moves.
        np.testing.assert_allclose(colours(bent)[end], ((np.array([253, 231, 36]) / 255 + 0.055) / 1.055) ** 2.4 * [1, 1, 1], atol=0.02)
        self.assertLess(colours(self.model())[:, :2].max(), 0.1)  # at its end it is at rest: violet, with little red and green
        self.assertEqual(len(np.unique(colours(self.model("--field", "body")), axis=0)), 1)
        self.assertEqual(len(np.unique(np.vstack([colours(self.model("--field", "rank"), name) for name in ("root", "tip")]), axis=0)), 2)
        plain = self.model("--field", "none", "--transparent", "tip", "--hide", "root")
        self.assertEqual(set(plain.nodes), {"tip"})
        self.assertNotIn("COLOR_0", plain.primitive("tip")["attributes"])
        material = plain.json["materials"][plain.primitive("tip")["material"]]
        self.assertEqual((material["alphaMode"], material["pbrMetallicRoughness"]["baseColorFactor"][3]), ("BLEND", 0.25))

    def test_times_and_single_frames(self):
        times, _ = self.model("--fps", 5).over_time("tip")
        np.testing.assert_allclose(times, np.arange(7) / 5, rtol=1e-6)
        alone = self.model("--frame", 3)
        self.assertNotIn("animations", alone.json)
        self.assertNotIn("targets", alone.primitive("tip"))
        result = Result(self.directory)
        half, full = (z_up(self.model("--frame", 3, "--scale", scale).array(alone.primitive("tip")["attributes"]["POSITION"])) for scale in (0.5, 1))
        surface = Surface(result[3].mesh, 2, cells=np.nonzero(result[3].mesh.body == 1)[0])
        point, distance = nearest(full, surface.of_nodes(result[3].positions()))
        self.assertLess(distance.max(), 1e-6)
        np.testing.assert_allclose(2 * half - full, surface.of_nodes(result[3].mesh.coordinates)[point], atol=1e-6)

    def test_obstacles_and_mechanisms(self):
        synthetic.add_obstacles(self.directory)
        synthetic.add_mechanisms(self.directory)
        glb, result = self.model("--field", "tension"), Result(self.directory)
        self.assertEqual(set(glb.nodes), {"root", "tip", "floor", "pyramid", "mechanisms"})
        _, pyramid = glb.over_time("pyramid")
        np.testing.assert_allclose(np.ptp(z_up(pyramid)[:, :, 2].max(axis=1)), 1.0, rtol=1e-5)
        self.assertNotIn("targets", glb.primitive("floor"))
        self.assertTrue(glb.json["materials"][glb.primitive("floor")["material"]]["doubleSided"])
        self.assertEqual(glb.primitive("mechanisms")["mode"], 1)
        _, lines = glb.over_time("mechanisms")
        cells = glb.cells("mechanisms")
        for x, frame in zip(lines, result):
            mechanisms = frame.mechanisms
            np.testing.assert_allclose(z_up(x)[cells], mechanisms.points[mechanisms.segments], atol=2e-4)
        self.assertEqual(set(self.model("--hide", "floor", "--hide", "flexor", "--scale", 2).nodes), {"root", "tip"})

    def test_rods_and_fibres_are_lines(self):
        """They are bodies without facets, some without cells."""
        synthetic.write_result(self.directory, num_frames=2, order=1, cubes=(4, 1, 1))
        synthetic.add_rods(self.directory)
        glb = self.model("--field", "rod_force")
        self.assertEqual(list(glb.nodes), ["root", "tip", "mechanisms"])
        self.assertEqual(len(glb.cells("mechanisms")), 3)
        self.assertNotIn("COLOR_0", glb.primitive("tip")["attributes"])
        colours = glb.array(glb.primitive("mechanisms")["attributes"]["COLOR_0"])[glb.cells("mechanisms")][:, 0]
        self.assertEqual(len(np.unique(colours, axis=0)), 3, "the fibre's, and of each segment of the wire")
        self.assertEqual(glb.json["scenes"][0]["extras"]["range"], [0, 3])
        self.assertEqual(list(self.model("--hide", "root", "--hide", "tip").nodes), ["mechanisms"])

    def test_a_resumed_run_has_a_mesh_for_each_part(self):
        with h5py.File(self.path("result.h5"), "r+") as h5:
            h5.copy("mesh", "mesh_1")
            for number in (4, 5, 6):
                h5[f"frames/{number:06}"].attrs["mesh"] = "/mesh_1"
        glb, result = self.model(), Result(self.directory)
        nodes = glb.json["nodes"]
        self.assertEqual([(node["name"], node.get("scale")) for node in nodes], [("root", [0, 0, 0]), ("tip", [0, 0, 0]), ("root", None), ("tip", None)])
        (animation,) = glb.json["animations"]
        for number in range(4):
            scale, weights = ([c for c in animation["channels"] if c["target"] == {"node": number, "path": path}] for path in ("scale", "weights"))
            sampler = animation["samplers"][scale[0]["sampler"]]
            self.assertEqual(sampler["interpolation"], "STEP")
            np.testing.assert_allclose(glb.array(sampler["input"])[:, 0], result.times[[0, 4]], rtol=1e-6)
            self.assertEqual(glb.array(sampler["output"])[:, 0].tolist(), [1, 0] if number < 2 else [0, 1])
            moved = animation["samplers"][weights[0]["sampler"]]
            np.testing.assert_allclose(glb.array(moved["input"])[:, 0], result.times[:4] if number < 2 else result.times[4:], rtol=1e-6)

    def test_linear_elements(self):
        synthetic.write_result(self.directory, num_frames=3, order=1, cubes=(4, 1, 1))
        surface = Surface(Result(self.directory)[0].mesh, 1, cells=np.nonzero(Result(self.directory)[0].mesh.body == 1)[0])
        self.assertEqual(len(self.model().cells("tip")), len(surface.triangles))

    def test_mistakes_are_told_in_one_line(self):
        for option in (["--view", "top"], ["--size", "320x240"], ["--mesh-edges"], ["--outline"], ["--frames"]):
            self.fails(f"{option[0]} has no effect on a .glb", self.directory, "-o", self.path("a.glb"), *option)
        self.fails("a.glb: the name of a model ends in .glb, those of movies", self.directory, "-o", self.path("a.glb"), "--movie", "gif")
        self.fails("a.png: the name of a model ends in .glb", self.directory, "-o", self.path("a.png"), "--movie", "glb")
        self.fails("every body is hidden", self.directory, "-o", self.path("a.glb"), "--hide", "root", "--hide", "tip")
        self.fails("missing/a.glb: No such file", self.directory, "-o", self.path("missing/a.glb"), code=4)
        self.assertFalse(os.path.exists(self.path("a.glb")))


if __name__ == "__main__":
    unittest.main()
