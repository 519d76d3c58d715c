#!/usr/bin/python3
"""How far apart bodies and obstacles start, as `check` lists it, and what is said and drawn where they overlap."""
import re
import unittest
import xml.etree.ElementTree

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from program import ProgramTest, start, finish, read_history, UNSIGNALLED
from test_body_contact import GEOMETRY, two_blocks

THREE = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 1};
Box(2) = {-1, -1, 1.2, 2, 2, 2};
Box(3) = {-1, -1, 30, 2, 2, 2};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Volume("moon") = {3};
Physical Surface("floor") = {5};
Physical Surface("top") = {6};
Physical Surface("under") = {11};
Mesh.MeshSizeMin = 1;
Mesh.MeshSizeMax = 1;
"""
SOFT = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e5, poissons_ratio: 0.3}"


def tables(text):
    """Rows of the tables of `check` by their titles, each as values by heading."""
    found, title, headings = {}, None, None
    for line in text.splitlines():
        if line in ("contact pairs", "obstacles"):
            title, headings = line, None
            found[title] = []
        elif title and not line.startswith("  "):
            title = None
        elif title and re.match(r"  \d+ (more )?pairs? of bodies", line):
            found["rest"] = line.strip()
        elif title and headings is None:
            headings = [(m.start(), m[0]) for m in re.finditer(r"\S+(?: \S+)*", line)]
        elif title:
            ends = [at for at, _ in headings[1:]] + [None]
            found[title].append({name: line[at:end].strip() for (at, name), end in zip(headings, ends)})
    return found


class ContactTable(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write("three.geo", THREE)

    def three(self, contact, initial="[0, 0, 0]", time="method: backward-euler, step: 2 ms, end: 0.02"):
        return self.write("three.yaml", f"""
mesh: {{file: three.geo, scale: 0.01}}
bodies: [{{volume: base, {SOFT}}}, {{volume: block, {SOFT}}}, {{volume: moon, {SOFT}}}]
constraints: [{{surface: floor, displacement: [0, 0, 0]}}]
initial: {{displacement: {initial}}}
contact: {{law: barrier, {contact}}}
time: {{{time}}}
""")

    def check_on_ranks(self, file):
        """The tables, the same on every rank count."""
        texts = []
        for ranks in (1, 2, 3):
            done = self.call("check", file, ranks=ranks)
            self.assertEqual(done.returncode, 0, done.stderr)
            begin = re.search("^(contact pairs|obstacles)$", done.stdout, re.M).start()
            texts.append(done.stdout[begin:done.stdout.index("unknowns\n")])
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])
        return tables(texts[0])

    def test_all_bodies(self):
        found = self.check_on_ranks(self.three("pairs: all, friction: 0.4"))
        [row] = found["contact pairs"]
        self.assertEqual((row["between"], row["law"], row["friction"]), ("base with block", "barrier", "0.4"))
        self.assertEqual((row["gap at the start [m]"], row["thickness [m]"]), ("0.002", "0"))
        facets = [int(number) for number in row["facets"].split(" and ")]
        self.assertGreater(min(facets), 20)
        self.assertGreater(float(row["stiffness [Pa/m]"]), 1e5)
        self.assertAlmostEqual(float(row["width [m]"]), 0.01 / 50, delta=0.5 * 0.01 / 50)
        x, y, z = map(float, row["at [m]"].strip("()").split(","))
        self.assertTrue(max(abs(x), abs(y)) <= 0.02 and z in (0.01, 0.012), row)
        self.assertRegex(found["rest"], r"^2 more pairs of bodies farther apart than 0\.0\d+ m$")

    def test_excluded_bodies_are_not_counted(self):
        found = self.check_on_ranks(self.three("pairs: all, exclude: [[base, moon], [base, block]]"))
        self.assertEqual(found["contact pairs"], [])
        self.assertRegex(found["rest"], r"^1 pair of bodies farther apart than")

    def test_pairs_and_obstacles(self):
        contact = """thickness: 1 mm, friction: 0.2, pairs: [
            {name: grip, surface: under, with: top, friction: 0.5, width: 0.1 mm, stiffness: 3e8, thickness: 0.5 mm},
            {surface: moon, with: block}, {surface: block, thickness: 0}],
            obstacles: [{name: ground, shape: plane, point: [0, 0, -0.003], normal: [0, 0, 1], friction: 0.7},
                        {name: ball, shape: sphere, point: [0.05, 0, 0.31], radius: 10 mm}]"""
        for time in ("method: backward-euler, step: 2 ms, end: 0.02", "method: static"):
            with self.subTest(time):
                file = self.three(contact.replace("thickness: 1 mm, ", "threshold: 1 mm, "), time=time)
                found = self.check_on_ranks(file)
                grip, far, itself = found["contact pairs"]
                self.assertEqual([row["pair"] for row in found["contact pairs"]], ["grip", "1", "2"])
                self.assertEqual((grip["between"], grip["stiffness [Pa/m]"], grip["width [m]"]), ("under with top", "3e+08", "0.0001"))
                self.assertEqual((grip["thickness [m]"], grip["friction"], grip["gap at the start [m]"]), ("0.0005", "0.5", "0.0015"))
                self.assertEqual((far["between"], far["friction"]), ("moon with block", "0.2"))
                # However far: 30 - 3.2 cm, less the threshold.
                self.assertEqual((far["thickness [m]"], far["gap at the start [m]"]), ("0.001", "0.267"))
                self.assertEqual((itself["between"], itself["gap at the start [m]"]), ("block with itself", "none near"))
                self.assertGreater(float(itself["width [m]"]), 1e-5)
                ground, ball = found["obstacles"]
                self.assertEqual((ground["obstacle"], ground["nearest body"], ground["friction"]), ("ground", "base", "0.7"))
                self.assertEqual(ground["threshold [m]"], "0.001")
                self.assertEqual((ball["nearest body"], ball["gap at the start [m]"]), ("moon", "0.029"))

    def test_a_displacement_at_the_start_counts(self):
        [row] = self.check_on_ranks(self.three("pairs: all", initial='[0, 0, "z > 0.011 ? -1e-3 : 0"]'))["contact pairs"]
        self.assertEqual(row["gap at the start [m]"], "0.001")

    def test_a_start_within_the_thickness_is_named(self):
        for ranks in (1, 2):
            done = self.call("run", self.three("pairs: all, threshold: 2.5 mm"), "--quiet", ranks=ranks)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, r"'base' and 'block' start 0.0005 m nearer than their 'thickness' at \(.*\), and the barrier needs a gap")

    def test_no_contact_no_table(self):
        file = self.three("pairs: all")
        file.write_text(re.sub("contact: .*\n", "", file.read_text()))
        self.assertEqual(tables(self.call("check", file).stdout), {})


class Overlap(ProgramTest):
    def facets(self, file):
        """Of the picture, as ParaView reads it: corners of each triangle, and values of cells."""
        xml.etree.ElementTree.parse(file)
        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(str(file))
        reader.Update()
        grid = reader.GetOutput()
        points = vtk_to_numpy(grid.GetPoints().GetData())
        corners = points[vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)]
        data = grid.GetCellData()
        values = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
        self.assertEqual({grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}, {5})
        return corners, values

    def overlap(self, name, geometry, expected, element="P1", **options):
        """The facets; message and file are the same on 1 and 2 ranks."""
        self.write(name + ".geo", geometry)
        file = self.write(name + ".yaml", two_blocks(file=name + ".geo", element=element, **options))
        messages, pictures = [], []
        for ranks in (1, 2):
            out = f"{name}{ranks}"
            done = finish(start(["run", file, "--quiet", "--output", out], self.directory, ranks, UNSIGNALLED), 120)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            message = next(line for line in done.stderr.splitlines() if "at the start" in line)
            self.assertRegex(message, expected)
            self.assertEqual(done.stderr.count("at the start"), 1)
            self.assertIn(f"{out}/overlap.vtu", message)
            messages.append(message.replace(out, ""))
            pictures.append(self.facets(self.directory / out / "overlap.vtu"))
        self.assertEqual(*messages)
        sums = [np.sort(np.column_stack([corners.sum(axis=1), *values.values()]).round(12), axis=0) for corners, values in pictures]
        np.testing.assert_allclose(sums[0], sums[1], atol=1e-11)
        # What `run` refuses, `check` refuses, and it writes nothing.
        done = self.call("check", file)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, expected)
        return pictures[0]

    def test_a_block_in_its_base(self):
        for element in ("P1", "P2"):
            for contact in ("law: barrier, pairs: all", "law: barrier, pairs: [{surface: block, with: base}]"):
                with self.subTest(element=element, contact=contact):
                    corners, values = self.overlap(
                        "within" + element, GEOMETRY % "0.3",
                        r"^\S+:\d+:\d+: 'base' and 'block' overlap at the start in 1 place \(\d+ triangles\), 0\.007 m deep at \(.*, .*, 0\.01\)",
                        element, contact=contact)
                    self.assertEqual(set(values), {"body", "other", "depth"})
                    self.assertEqual(set(values["body"]), {0, 1})
                    np.testing.assert_array_equal(values["other"], 1 - values["body"])
                    self.assertAlmostEqual(values["depth"].max(), 0.007, delta=1e-12)
                    self.assertGreaterEqual(values["depth"].min(), 0)
                    # The bottom of the block is 3 mm above that of the base, and below its top.
                    bottom = (values["body"] == 1) & (corners[..., 2] < 0.00301).all(axis=1)
                    np.testing.assert_allclose(values["depth"][bottom], 0.003, atol=1e-12)
                    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
                    self.assertAlmostEqual(area[bottom].sum(), 4e-4, delta=1e-12)

    def test_coarse_balls_that_are_apart(self):
        # 10 mm, but the triangles that have the mean of the facets are farther outside than that.
        geometry = """SetFactory("OpenCASCADE");
Mesh.ElementOrder = 2;
Mesh.SecondOrderLinear = 0;
Sphere(1) = {0, 0, 0, 1};
Sphere(2) = {0, 0, %s, 1};
Physical Volume("low") = {1};
Physical Volume("high") = {2};
MeshSize{ PointsOf{ Volume{1}; } } = 0.8;
MeshSize{ PointsOf{ Volume{2}; } } = 0.6;
Mesh.MeshSizeMax = 0.8;
"""
        law = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.3}"
        text = f"""mesh: {{file: balls.geo}}
element: P2
bodies: [{{volume: low, {law}}}, {{volume: high, {law}}}]
initial: {{velocity: [0, 0, "z < 1 ? 0 : -1"]}}
contact: {{law: barrier, pairs: [{{name: balls, surface: low, with: high}}]}}
time: {{method: bdf2, step: 4 ms, end: 0.04}}
"""
        for place, is_told in ((2.01, True), (2.5, False)):
            self.write("balls.geo", geometry % place)
            done = self.call("run", self.write("balls.yaml", text), "--output", "out")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("curved by more than the distance" in done.stderr, is_told)
            h = read_history(self.directory / "out")
            self.assertEqual(h["balls_fz"].any(), is_told)
            self.assertGreater(h["contact_gap_min"].min(), 0)

    def test_a_body_in_another_one(self):
        geometry = GEOMETRY.replace("{-1, -1, %s, 2, 2, 2}", "{-0.5, -0.5, 0.3, 1, 1, 0.4}")
        _, values = self.overlap("inside", geometry, "'base' and 'block' overlap at the start in 1 place .* 0.005 m deep at")
        self.assertEqual(set(values["body"]), {1})  # no facet of the base is in the block

    def test_two_places_and_surfaces_that_only_touch(self):
        legs = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 1};
Box(2) = {-1.5, -0.5, 0.9, 1, 1, 1};
Box(3) = {0.5, -0.5, 0.9, 1, 1, 1};
Physical Volume("base") = {1};
Physical Volume("block") = {2, 3};
Physical Surface("floor") = {5};
Mesh.MeshSizeMax = 0.5;
"""
        self.overlap("legs", legs, "'base' and 'block' overlap at the start in 2 places .* 0.001 m deep")
        corners, values = self.overlap("touching", GEOMETRY % "1", "'base' and 'block' touch at the start in 1 place .*, near .*needs a gap")
        self.assertEqual(values["depth"].max(), 0)
        self.assertTrue((np.abs(corners[..., 2] - 0.01).min(axis=1) < 1e-12).all())

    def test_static_runs_too_and_the_picture_goes_with_the_overlap(self):
        # Nothing but the pair's own check sees this: the block's lower facets alone may touch.
        self.overlap("static", GEOMETRY.replace("Mesh.MeshSizeMin", 'Physical Surface("under") = {11};\nMesh.MeshSizeMin') % "0.95",
                     "'base' and 'block' overlap at the start", time="method: static",
                     contact="law: barrier, pairs: [{surface: under, with: base}]")
        self.write("static.geo", GEOMETRY % "1.2")
        file = self.write("apart.yaml", two_blocks(file="static.geo", time="method: backward-euler, step: 2 ms, end: 2 ms"))
        self.run_input(file, output="static1")
        self.assertFalse((self.directory / "static1/overlap.vtu").exists())


if __name__ == "__main__":
    unittest.main()
