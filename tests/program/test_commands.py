#!/usr/bin/python3
"""The commands that solve nothing: check, methods, materials, schema, help and version."""
import json
import pathlib
import re
import subprocess
import unittest

import jsonschema
import yaml

from program import ENVIRONMENT, PROGRAM, ROOT, ProgramTest, swept, write_box

INPUT = """
mesh: {file: bar.msh}
element: P2
bodies:
  - {volume: body, density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}
constraints: [{surface: left, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
time: {method: bdf2, step: 0.01, end: 1}
"""


class Commands(ProgramTest):
    def text(self, *arguments, ranks=1):
        done = self.call(*arguments, ranks=ranks)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stderr)
        return done.stdout

    def test_check(self):
        write_box(self.directory / "bar.msh", (8, 2, 2), (1, 0.2, 0.2))
        file = self.write("bar.yaml", INPUT)
        for ranks in swept((1, 2, 3), (1, 3)):
            with self.subTest(ranks=ranks):
                text = self.text("check", file, ranks=ranks)
                # Bodies, surfaces, quality, unknowns, time scales, memory.
                self.assertIn("192 tetrahedra", text)
                self.assertRegex(text, r"volume +0\.04 m\^3")
                self.assertRegex(text, r"body: 192 tetrahedra, .*\n    extent \[0, 1\] x \[0, 0.2\] x \[0, 0.2\] m\n")
                self.assertRegex(text, r"surface +left +\(tag 1\): +8 facets +0\.04 m\^2")
                self.assertRegex(text, r"body: .*neo-hookean.*1000 kg/m\^3")
                self.assertRegex(text, r"mass +40 kg")
                self.assertRegex(text, r"quality +worst 0\.7")
                self.assertRegex(text, r"1275 \(75 prescribed\), P2")
                self.assertRegex(text, r"memory: .*\d+ MB")
                # Transit of waves: c_p = sqrt((lambda + 2 mu) / rho), c_s = sqrt(mu / rho).
                self.assertRegex(text, r"shear wave .* 0\.0529 s")
                self.assertRegex(text, r"suggested step +\S+ s")
                per_rank = re.search(r"(\d+) to (\d+) per rank", text)
                self.assertLessEqual(int(per_rank[1]) * ranks, 1275)
                self.assertGreaterEqual(int(per_rank[2]) * ranks, 1275)
                lines = [line.strip().removeprefix("note: ") for line in text.splitlines() if "note:" in line]
                self.assertEqual(len(lines), len(set(lines)), "a note is given twice")
        self.assertEqual([p.name for p in self.directory.iterdir() if p.is_dir()], [], "check writes nothing")

    def test_check_lists_what_else_a_body_has(self):
        write_box(self.directory / "bar.msh", (2, 1, 1), (1, 0.2, 0.2))
        more = ("viscosity: {model: maxwell, shear_modulus: 1 kPa, relaxation_time: 0.1}", "expansion: {stretch: 1 + 0.1*t}")
        for key in more:
            text = self.text("check", self.write("bar.yaml", INPUT.replace("density: 1000", f"density: 1000, {key}")))
            self.assertIn(f"    {key.split(':')[0]}: ", text)
            self.assertRegex(text, "shear_modulus: 1000, .*relaxation_time: 0.1" if "maxwell" in key else r'stretch: "?1 \+ 0\.1\*t')

    def test_check_without_inertia_has_no_waves(self):
        write_box(self.directory / "bar.msh", (2, 1, 1), (1, 0.2, 0.2))
        for time, has_waves in (("{method: bdf2, step: 0.01, end: 1}", True), ("{method: quasistatic, step: 0.01, end: 1}", False), ("{method: static}", False)):
            text = self.text("check", self.write("bar.yaml", INPUT.replace("{method: bdf2, step: 0.01, end: 1}", time)))
            self.assertEqual(("time scales" in text, "wave" in text, "suggested step" in text), (has_waves,) * 3)

    def test_check_of_the_inputs_of_studies(self):
        for file in sorted((ROOT / "input/convergence").glob("*.yaml")):  # the others are run by their tests
            with self.subTest(file.name):
                self.text("check", file)

    def test_schema(self):
        schema = json.loads(self.text("schema"))
        jsonschema.Draft7Validator.check_schema(schema)
        of_fit = json.loads(self.text("schema", "--fit"))
        jsonschema.Draft7Validator.check_schema(of_fit)
        for file in sorted((ROOT / "input").rglob("*.yaml")):
            with self.subTest(file.name):
                jsonschema.validate(yaml.safe_load(file.read_text(encoding="utf-8")), of_fit if file.parent.name == "fit" else schema)
        jsonschema.validate(yaml.safe_load(INPUT), schema)
        for bad in (INPUT.replace("density", "densty"), INPUT.replace("element: P2", "element: P3"), "mesh: {}"):
            with self.assertRaises(jsonschema.ValidationError):
                jsonschema.validate(yaml.safe_load(bad), schema)

    def test_the_schema_accepts_what_was_understood(self):
        write_box(self.directory / "bar.msh", (2, 1, 1), (1, 0.2, 0.2))
        self.run_input(self.write("bar.yaml", INPUT), "time.end=0.01")
        jsonschema.validate(yaml.safe_load((self.directory / "out/run.yaml").read_text()), json.loads(self.text("schema")))

    def test_version(self):
        for ranks in (1, 2):
            text = self.text("--version", ranks=ranks)
            for name in ("pliant", "PETSc", "SLEPc", "MUMPS", "HDF5", "gmsh", "MPI"):
                self.assertRegex(text, rf"(?m)^ *{name} .*\d+\.\d+")
                self.assertEqual(len(re.findall(rf"(?m)^ *{name} ", text)), 1, "told by one rank")

    def test_openblas_computes_with_kernels_that_fit_the_processor(self):
        def kernels(**environment):
            done = subprocess.run([PROGRAM, "--version"], env=ENVIRONMENT | {"OPENBLAS_VERBOSE": "2"} | environment,
                                  capture_output=True, text=True, check=True)
            return [line.removeprefix("Core: ") for line in done.stderr.splitlines() if line.startswith("Core: ")]

        found = kernels()
        if not found:
            self.skipTest("another BLAS than OpenBLAS")
        is_vectorised = {"avx2", "fma"} <= set(pathlib.Path("/proc/cpuinfo").read_text().split())
        if found[0] == "Prescott" and is_vectorised:  # older than the processor, it takes it for the oldest one
            self.assertIn(found[1:], (["SkylakeX"], ["Haswell"]))
        else:
            self.assertEqual(len(found), 1)
        self.assertEqual(kernels(OPENBLAS_CORETYPE="Prescott"), ["Prescott"], "the user's choice")

    def test_methods(self):
        text = self.text("methods")
        for name in ("backward-euler", "bdf2", "bdf3", "dirk22", "dirk23", "dirk33", "implicit-midpoint",
                     "symplectic-dirk22"):
            self.assertRegex(text, rf"(?m)^{name} .*-stable")

    def test_materials(self):
        text = self.text("materials", ranks=2)
        for name in ("linear", "saint-venant-kirchhoff", "neo-hookean"):
            self.assertEqual(len(re.findall(rf"(?m)^{name}$", text)), 1)
        for word in ("psi = ", "youngs_modulus", "[Pa]", "poissons_ratio", "source"):
            self.assertIn(word, text)

    def test_help(self):
        text = self.text("--help")
        for command in ("run", "check", "methods", "materials", "schema"):
            self.assertRegex(text, rf"(?m)^ +{command} +\w")
            self.assertIn("Usage", self.text(command, "--help"))
            self.assertEqual(self.text("help", command), self.text(command, "--help"))
        self.assertEqual(self.text("help"), text)
        self.assertEqual(self.text("help", "mesh", "convert"), self.text("mesh", "convert", "--help"))
        done = self.call("help", "rnu")
        self.assertEqual(done.returncode, 2)
        self.assertIn("there is no command 'rnu' (did you mean 'run'?)", done.stderr)
        for option in ("--output", "--set", "--quiet"):
            self.assertIn(option, self.text("run", "--help"))

    def test_words_that_a_command_does_not_take(self):
        for words, message in ((("run", "in.yaml", "--quite"), "pliant run: it has no option '--quite' (did you mean '--quiet'?); see pliant run --help"),
                               (("render", "out", "--zzzzzzzzzzzz", "3"), "pliant render: it has no option '--zzzzzzzzzzzz'; see pliant render --help"),
                               (("--set", "a=1"), "pliant: it has no option '--set'; see pliant --help"),
                               (("render", "out", "--hide", "a", "b"), "pliant render: it takes no argument 'b'; several values of --hide are given as --hide a --hide b; see pliant render --help"),
                               (("run", "in.yaml", "--set", "a=1", "b=2"), "pliant run: it takes no argument 'b=2'; several values of --set are given as --set a=1 --set b=2; see pliant run --help"),
                               (("methods", "bdf2", "bdf3"), "pliant methods: it takes no argument 'bdf2'; see pliant methods --help"),
                               (("materials", "yeoh"), "pliant materials: there is no command 'yeoh'; to plot a law or a material: pliant materials plot yeoh; see pliant materials --help"),
                               (("mesh", "convrt"), "pliant mesh: there is no command 'convrt' (did you mean 'convert'?); see pliant mesh --help")):
            done = self.call(*words)
            self.assertEqual((done.returncode, done.stderr), (2, message + "\n"))

    def test_help_has_examples(self):
        def commands(*above):
            head, _, rest = self.text(*above, "--help").partition("\nSubcommands:\n")
            if above:
                yield above, head + rest
            for name in re.findall(r"^  ([a-z]\w*) ", rest.partition("\n\n")[0], re.MULTILINE):
                yield from commands(*above, name)

        helps = {name: text.partition("\nExamples:\n") for name, text in commands()}
        self.assertIn(("mesh", "convert"), helps)
        for name, (_, _, examples) in helps.items():
            with self.subTest(" ".join(name)):
                self.assertTrue(examples.strip())
                for line in examples.strip().splitlines():
                    self.assertRegex(line, rf"\bpliant {' '.join(name)}\b")
                    words = re.findall(r"[a-z]+", line.split("pliant ", 1)[1])
                    called = max((n for n in helps if tuple(words[:len(n)]) == n), key=len)
                    self.assertLessEqual(set(re.findall(r" (--[a-z]+)", line.split(" -- ")[0])),
                                         set(re.findall(r"--[a-z]+", helps[called][0])))

    def test_output_can_be_cut_off(self):
        # As in `pliant materials | head -1`.
        done = subprocess.run(f"'{PROGRAM}' materials | head -1", shell=True, capture_output=True,
                              text=True, check=False, cwd=self.directory)
        self.assertEqual((done.stdout, done.stderr), ("ELASTICITY (bodies[].elasticity)\n", ""))


if __name__ == "__main__":
    unittest.main()
