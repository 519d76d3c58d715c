#!/usr/bin/python3
"""How far apart bodies and obstacles start, as `check` lists it, and what is said and drawn where they overlap."""
import re
import unittest
import xml.etree.ElementTree

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

from overlaps import overlaps
from program import ProgramTest, start, finish, read_history, swept, UNSIGNALLED
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

    def check_on_ranks(self, file, usually=(1, 3)):
        """The tables, the same on every rank count."""
        texts = []
        for ranks in swept((1, 3, 2), usually):
            done = self.call("check", file, ranks=ranks)
            self.assertEqual(done.returncode, 0, done.stderr)
            begin = re.search("^(contact pairs|obstacles)$", done.stdout, re.M).start()
            texts.append(done.stdout[begin:done.stdout.index("unknowns\n")])
        self.assertEqual(set(texts), {texts[0]})
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
        found = self.check_on_ranks(self.three("pairs: all, exclude: [[base, moon], [base, block]]"), (1,))
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
                found = self.check_on_ranks(file, (1,) if "static" in time else (1, 3))
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
        [row] = self.check_on_ranks(self.three("pairs: all", initial='[0, 0, "z > 0.011 ? -1e-3 : 0"]'), (1,))["contact pairs"]
        self.assertEqual(row["gap at the start [m]"], "0.001")

    def test_a_start_within_the_thickness_is_named(self):
        for ranks in swept((1, 2), (1,)):
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

    def test_overlaps_that_a_list_of_pairs_misses(self):
        """A block whose foot is below the other's top: the two surfaces of the pair do not meet."""
        sunken = THREE.replace("Box(2) = {-1, -1, 1.2", "Box(2) = {-1, -1, 0.6")
        self.write("sunken.geo", sunken)
        text = (f"mesh: {{file: sunken.geo, scale: 0.01}}\nbodies: [{{volume: base, {SOFT}}}, {{volume: block, {SOFT}}}, {{volume: moon, {SOFT}}}]\n"
                "constraints: [{surface: floor, displacement: [0, 0, 0]}]\ntime: {method: backward-euler, step: 2 ms, end: 0.02}\n")
        for contact, words in (("contact: {law: barrier, pairs: [{surface: under, with: top}]}\n", "the surfaces that 'contact' lists do not meet there, and nothing keeps"),
                               ("", "no contact between them is enabled; .*pairs: all, start: resolve")):
            self.write("sunken.yaml", text + contact)
            self.assertRegex(self.pliant("check", "sunken.yaml").stderr, "sunken.yaml:1:14: parts of the mesh that share no node overlap at the start, .*" + words)
        self.write("sunken.yaml", text + "contact: {pairs: all, start: resolve}\n")
        self.assertIn("'start: resolve' moves", self.pliant("check", "sunken.yaml").stdout)

    def overlap(self, name, geometry, expected, element="P1", usually=(1,), **options):
        """The facets; message and file are the same on 1 and 2 ranks."""
        self.write(name + ".geo", geometry)
        file = self.write(name + ".yaml", two_blocks(file=name + ".geo", element=element, **options))
        messages, pictures = [], []
        for ranks in swept((1, 2), usually):
            out = f"{name}{ranks}"
            done = finish(start(["run", file, "--quiet", "--output", out], self.directory, ranks, UNSIGNALLED), 120)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            message = next(line for line in done.stderr.splitlines() if "at the start" in line)
            self.assertRegex(message, expected)
            self.assertEqual(done.stderr.count("at the start"), 1)
            self.assertIn(f"{out}/overlap.vtu", message)
            messages.append(message.replace(out, ""))
            pictures.append(self.facets(self.directory / out / "overlap.vtu"))
        self.assertEqual(set(messages), {messages[0]})
        sums = [np.sort(np.column_stack([corners.sum(axis=1), *values.values()]).round(12), axis=0) for corners, values in pictures]
        np.testing.assert_allclose(sums[0], sums[-1], atol=1e-11)
        # What `run` refuses, `check` refuses, and it writes nothing.
        done = self.call("check", file)
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, expected)
        return pictures[0]

    def test_a_block_in_its_base(self):
        cases = [(element, f"law: barrier, pairs: {pairs}") for element in ("P1", "P2") for pairs in ("all", "[{surface: block, with: base}]")]
        for element, contact in swept(cases, cases[::3]):
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
        self.overlap("legs", legs, "'base' and 'block' overlap at the start in 2 places .* 0.001 m deep", usually=(1, 2))
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


PIN = """SetFactory("OpenCASCADE");
Box(1) = {-2, -2, 0, 4, 4, 1};
Cylinder(2) = {0, 0, -0.5, 0, 0, 2, 0.8};
BooleanDifference{ Volume{1}; Delete; }{ Volume{2}; }
Cylinder(3) = {0, 0, -0.5, 0, 0, 2, 0.8};
Physical Volume("base") = {1};
Physical Volume("block") = {3};
Physical Surface("floor") = {Surface In BoundingBox {-2.1, -2.1, -0.1, 2.1, 2.1, 0.1}};
Mesh.MeshSizeMax = 0.8;
MeshSize{ PointsOf{ Volume{3}; } } = 0.5;
"""
WEDGES = """SetFactory("OpenCASCADE");
Point(1) = {-1, -2, 0}; Point(2) = {1, -2, 0}; Point(3) = {0, -2, 1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 1}; Curve Loop(1) = {1, 2, 3}; Plane Surface(1) = {1};
a[] = Extrude {0, 4, 0} { Surface{1}; };
Point(11) = {-2, -1, 1.95}; Point(12) = {-2, 1, 1.95}; Point(13) = {-2, 0, 0.95};
Line(21) = {11, 12}; Line(22) = {12, 13}; Line(23) = {13, 11}; Curve Loop(21) = {21, 22, 23}; Plane Surface(21) = {21};
b[] = Extrude {4, 0, 0} { Surface{21}; };
Physical Volume("base") = {a[1]};
Physical Volume("block") = {b[1]};
Physical Surface("floor") = {a[2]};
Mesh.MeshSizeMax = 0.6;
"""


class Resolve(ProgramTest):
    """`start: resolve` moves apart what touches or overlaps a little."""

    RESOLVE = "law: barrier, start: resolve, pairs: all"

    def note(self, file, ranks=1):
        done = self.call("check", file, ranks=ranks)
        self.assertEqual(done.returncode, 0, done.stderr)
        return re.search(r"'base' and 'block' (.*)", done.stdout + done.stderr)[0]

    def test_shapes_that_touch_or_overlap(self):
        shapes = {"touching": (GEOMETRY % "1", "touch in the mesh"), "low": (GEOMETRY % "0.95", "overlap by up to 0.0005 m"),
                  "pin": (PIN, "overlap by up to"), "wedges": (WEDGES, "overlap by up to 0.000")}
        cases = (("low", "P1"), ("pin", "P2"), ("touching", "P1"), ("touching", "P2"), ("wedges", "P2"))
        for name, element in swept(cases, cases[:2]):
            geometry, expected = shapes[name]
            self.write(name + ".geo", "Mesh.ElementOrder = 2;\n" + geometry)
            with self.subTest(shape=name, element=element):
                file = self.write(name + element + ".yaml",
                                  two_blocks(self.RESOLVE, file=name + ".geo", element=element,
                                             time="method: backward-euler, step: 1 ms, end: 3 ms"))
                numbers_of_ranks = swept((1, 3), (1, 3) if name == "low" else (1,))
                notes = [self.note(file, ranks) for ranks in numbers_of_ranks]
                self.assertIn(expected, notes[0])
                self.assertRegex(notes[0], "'start: resolve' moves [1-9][0-9]* nodes")
                self.assertEqual(set(notes), {notes[0]})
                h = self.run_input(file, output=name + element)
                self.assertEqual(h["contact_energy"][0], 0)
                self.assertGreater(h["contact_gap_min"].min(), 0)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * np.abs(h["load_potential"]).max())
                self.assertEqual(overlaps(self.directory / (name + element) / "result.h5"), [])
                for ranks in numbers_of_ranks[1:]:
                    self.assert_same_history(h, self.run_input(file, output=name + "3", ranks=ranks), 1e-5)

    def test_flat_surfaces_stay_flat(self):
        # Two blocks of 1 x 0.5 m that do not fit, without transverse strain, shortened by 1 %: the same stress everywhere.
        self.write("patch.geo", """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 0.5};
Box(2) = {0, 0, 0.5, 1, 1, 0.5};
Physical Volume("base") = {1};
Physical Volume("block") = {2};
Physical Surface("floor") = {5};
Physical Surface("top") = {12};
MeshSize{ PointsOf{ Volume{1}; } } = 0.35;
MeshSize{ PointsOf{ Volume{2}; } } = 0.25;
""")
        law = "density: 1000, elasticity: {model: saint-venant-kirchhoff, youngs_modulus: 1e6, poissons_ratio: 0}"
        for element in swept(("P1", "P2"), ("P1",)):
            file = self.write("patch.yaml", f"""
mesh: {{file: patch.geo}}
element: {element}
bodies: [{{volume: base, {law}}}, {{volume: block, {law}}}]
constraints: [{{surface: floor, displacement: [free, free, 0]}}, {{surface: top, displacement: [0, 0, -0.01]}},
              {{where: "x < 1e-9", displacement: [0, free, free]}}, {{where: "y < 1e-9", displacement: [free, 0, free]}}]
contact: {{{self.RESOLVE}, width: 1e-6}}
time: {{method: static, load_steps: 2}}
output: {{fields: [cauchy_stress]}}
""")
            self.run_input(file)
            with h5py.File(self.directory / "out/result.h5") as result:
                frame = result["frames"][max(result["frames"])]
                stress = frame["cauchy_stress"][:]
            vertical = stress[:, 2] if stress.shape[1] == 6 else stress.reshape(-1, 3, 3)[:, 2, 2]
            self.assertAlmostEqual(np.mean(vertical) / -9.9e3, 1, delta=0.01)
            self.assertLess(np.abs(vertical / np.mean(vertical) - 1).max(), 0.03)

    def test_selections_are_by_the_mesh_as_it_is_given(self):
        self.write("blocks.geo", GEOMETRY % "1")
        text = two_blocks(self.RESOLVE).replace("constraints: [", 'constraints: [{where: "abs(z - 0.01) < 1e-9", displacement: [0, 0, free]}, ')
        self.run_input(self.write("two.yaml", text))
        # The same nodes are not at that height any more.
        with h5py.File(self.directory / "out/result.h5") as result:
            height = result["mesh"]["coordinates"][:, 2]
        self.assertGreater(np.count_nonzero((np.abs(height - 0.01) > 1e-7) & (np.abs(height - 0.01) < 1e-5)), 8)

    def test_distances_given(self):
        self.write("blocks.geo", GEOMETRY % "1")
        for keys, least, most in (("width: 0.05 mm", 0.05e-3, 0.11e-3), ("width: 0.05 mm, threshold: 0.4 mm", 0.05e-3, 0.11e-3)):
            file = self.write("two.yaml", two_blocks(f"{self.RESOLVE}, {keys}", time="method: backward-euler, step: 1 ms, end: 1 ms"))
            start = self.run_input(file)["contact_gap_min"][0]
            self.assertTrue(least <= start <= most, start)
        # A block that starts within the threshold alone.
        self.write("blocks.geo", GEOMETRY % "1.03")
        self.assertIn("are nearer than their 'thickness' in the mesh", self.note(file))

    def test_a_displacement_at_the_start_counts(self):
        self.write("blocks.geo", GEOMETRY % "1.2")
        text = two_blocks(self.RESOLVE).replace("initial: {", 'initial: {displacement: [0, 0, "z > 0.011 ? -2.3e-3 : 0"], ')
        h = self.run_input(self.write("two.yaml", text))
        self.assertEqual(h["contact_energy"][0], 0)
        self.assertGreater(h["contact_gap_min"][0], 0)

    def test_goes_on_elsewhere(self):
        self.write("blocks.geo", GEOMETRY % "0.97")
        file = self.write("two.yaml", two_blocks(self.RESOLVE, time="method: backward-euler, step: 1 ms, end: 8 ms")
                          + "checkpoint: {every: 4}\n")
        whole = self.run_input(file, output="whole")
        self.run_input(file, output="part")
        for later in sorted((self.directory / "part").glob("checkpoint-*.h5"))[1:]:
            later.unlink()
        done = self.call("resume", "part", "--quiet", ranks=2)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_history(whole, read_history(self.directory / "part"), 1e-6)

    def test_what_is_too_deep_is_told(self):
        fine = GEOMETRY.replace("Max = 1", "Max = 0.4").replace("Min = 1", "Min = 0.4")
        cases = ((0.7, 1, "flatten an element near"), (0.4, 1, "overlap at the start in 1 place"),
                 (0.7, 2, "flatten an element near"), (0.4, 2, "overlap at the start in 1 place"))
        for height, ranks, expected in swept(cases, cases[:2]):
            self.write("blocks.geo", fine % height)
            done = self.call("run", self.write("two.yaml", two_blocks(self.RESOLVE)), "--quiet", ranks=ranks)
            self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
            self.assertRegex(done.stderr, expected)


if __name__ == "__main__":
    unittest.main()
