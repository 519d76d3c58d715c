"""The schema of the documents is the program's, and editors find it by the inputs."""
import json
import os
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = ROOT / "docs/input.schema.json"
FIT_SCHEMA = ROOT / "docs/fit.schema.json"
PROGRAM = pathlib.Path(os.environ.get("PLIANT", ROOT / "build/bin/pliant"))


@unittest.skipUnless(PROGRAM.exists(), f"{PROGRAM} is not built")
class Inputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.schema, cls.fit_schema = (cls.printed("schema", *options) for options in ((), ("--fit",)))

    @staticmethod
    def printed(*arguments):
        return subprocess.run([PROGRAM, *arguments], stdin=subprocess.DEVNULL, capture_output=True, check=True, text=True).stdout

    def test_the_schema_of_the_documents_is_the_program_s(self):
        # `pliant schema > docs/input.schema.json` writes it, `pliant schema --fit > docs/fit.schema.json` the other.
        self.assertEqual(SCHEMA.read_text(encoding="utf-8"), self.schema)
        self.assertEqual(FIT_SCHEMA.read_text(encoding="utf-8"), self.fit_schema)

    def test_the_reference_of_fits_is_the_program_s(self):
        # `pliant schema --fit --markdown > docs/fit-file.md` writes it.
        page = (ROOT / "docs/fit-file.md").read_text(encoding="utf-8")
        self.assertEqual(page, self.printed("schema", "--fit", "--markdown"))

    def test_inputs_name_the_schema(self):
        for file in sorted((ROOT / "input").rglob("*.yaml")):
            schema = FIT_SCHEMA if file.parent.name == "fit" else SCHEMA
            line = f"# yaml-language-server: $schema={os.path.relpath(schema, file.parent)}"
            self.assertEqual(file.read_text(encoding="utf-8").splitlines()[0], line, f"line 1 of {file.relative_to(ROOT)}")

    def test_every_key_has_a_text_for_editors(self):
        def without_text(name, schema):
            for key, value in schema.get("properties", {}).items():
                if "description" not in value:
                    yield f"{name}.{key}"
                for part in (value, value.get("items", {}), *value.get("anyOf", []), *value.get("oneOf", [])):
                    if isinstance(part, dict):
                        yield from without_text(f"{name}.{key}", part)

        for schema in (self.schema, self.fit_schema):
            self.assertEqual(list(without_text("", json.loads(schema))), [])


if __name__ == "__main__":
    unittest.main()
