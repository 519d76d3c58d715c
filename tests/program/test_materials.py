#!/usr/bin/python3
"""Materials as users give them: constants of any kind, graded bodies, pictures of laws."""
import json
import unittest
import xml.etree.ElementTree

import numpy as np

from program import ProgramTest, write_box

STRETCHED = """
mesh: {{file: bar.msh}}
bodies: [{{elasticity: {{model: {elasticity}}}}}]
constraints:
  - {{surface: left, displacement: [0, free, free]}}
  - {{where: "y < 1e-9", displacement: [free, 0, free]}}
  - {{where: "z < 1e-9", displacement: [free, free, 0]}}
loads: [{{surface: right, traction: [1, 0, 0]}}]
time: {{method: static}}
probes: [{{name: end, point: [1, 0, 0]}}]
"""


class Materials(ProgramTest):
    def stretched(self, elasticity, ranks=1, n=(8, 1, 1)):
        write_box(self.directory / "bar.msh", n, (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity=elasticity))
        history = self.run_input(self.directory / "bar.yaml", ranks=ranks)
        return history["end_x"][-1] - 1

    def test_any_two_constants_are_the_same_body(self):
        for constants in ("youngs_modulus: 1 kPa, poissons_ratio: 0.25", "shear_modulus: 400, lame_lambda: 400",
                          "bulk_modulus: 2000/3, shear_modulus: 0.4 kPa"):
            with self.subTest(constants):
                self.assertAlmostEqual(self.stretched(f"linear, {constants}") / 1e-3, 1, delta=1e-10)

    def test_graded_bar(self):
        # du/dx = P/E(x): the end moves by ln 2/1000, as the mesh gets finer.
        def error(n, ranks):
            u = self.stretched('linear, youngs_modulus: "1000*(1 + x)", poissons_ratio: 0', ranks, (n, 1, 1))
            return u / (1e-3 * np.log(2)) - 1

        coarse, fine = error(8, 1), error(32, 2)
        self.assertLess(abs(fine), 1e-3)
        self.assertLess(abs(fine), abs(coarse) / 4)

    def test_constants_that_are_not_admissible_somewhere(self):
        write_box(self.directory / "bar.msh", (4, 1, 1), (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity='linear, youngs_modulus: "0.5 - x", poissons_ratio: 0'))
        for ranks in (1, 2):
            done = self.call("run", "bar.yaml", ranks=ranks)
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"bar.yaml:3:\d+: youngs_modulus is -0\.\d+; it must be finite and above 0, at \(0\.")

    def test_check_tells_the_equivalents(self):
        write_box(self.directory / "bar.msh", (1, 1, 1), (1.0, 0.1, 0.1))
        self.write("bar.yaml", STRETCHED.format(elasticity="mooney-rivlin, c10: 3, c01: 1, poissons_ratio: 0.25"))
        done = self.call("check", "bar.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("E = 20 Pa, nu = 0.25, mu = 8 Pa, K = 13.33 Pa, lambda = 8 Pa", done.stdout)

    def laws(self):
        schema = json.loads(self.call("schema").stdout)
        return schema["properties"]["bodies"]["items"]["properties"]["elasticity"]["properties"]["model"]["enum"]

    def test_every_law_is_drawn(self):
        laws = self.laws()
        self.assertGreater(len(laws), 5)
        for law in laws:
            with self.subTest(law):
                done = self.call("materials", "plot", law)
                self.assertEqual(done.returncode, 0, done.stderr)
                root = xml.etree.ElementTree.parse(self.directory / f"{law}.svg").getroot()
                curves = [e.get("points").split() for e in root.iter() if e.tag.endswith("polyline")]
                self.assertEqual(len(curves), 3)
                for points in curves:
                    self.assertGreater(len(points), 40)  # of 161: some laws end before a stretch of 2

    def test_mistakes_in_plots(self):
        for arguments, words in ((("neo-hooken",), "did you mean 'neo-hookean'"), (("yeoh", "--set", "c40=1"), "one of c10, c20, c30"),
                                 (("linear", "--set", "shear_modulus=1 m"), "1 m"), (("linear", "--set", "shear_modulus=-1"), "above 0"),
                                 (("linear", "--stretch", "2", "3"), "at most 1")):
            with self.subTest(arguments):
                done = self.call("materials", "plot", *arguments)
                self.assertEqual(done.returncode, 2)
                self.assertIn(words, done.stderr)


if __name__ == "__main__":
    unittest.main()
