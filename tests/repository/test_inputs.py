"""The schema of the documents is the program's, and editors find it by the inputs."""
import json
import os
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCHEMA = ROOT / "docs/input.schema.json"
PROGRAM = pathlib.Path(os.environ.get("PLIANT", ROOT / "build/bin/pliant"))


@unittest.skipUnless(PROGRAM.exists(), f"{PROGRAM} is not built")
class Inputs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        command = [PROGRAM, "schema"]
        cls.schema = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=True, text=True).stdout

    def test_the_schema_of_the_documents_is_the_program_s(self):
        # `pliant schema > docs/input.schema.json` writes it.
        self.assertEqual(SCHEMA.read_text(encoding="utf-8"), self.schema)

    def test_inputs_name_the_schema(self):
        for file in sorted((ROOT / "input").rglob("*.yaml")):
            line = f"# yaml-language-server: $schema={os.path.relpath(SCHEMA, file.parent)}"
            self.assertEqual(file.read_text(encoding="utf-8").splitlines()[0], line, f"line 1 of {file.relative_to(ROOT)}")

    def test_every_key_has_a_text_for_editors(self):
        def without_text(name, schema):
            for key, value in schema.get("properties", {}).items():
                if "description" not in value:
                    yield f"{name}.{key}"
                for part in (value, value.get("items", {}), *value.get("anyOf", []), *value.get("oneOf", [])):
                    if isinstance(part, dict):
                        yield from without_text(f"{name}.{key}", part)

        self.assertEqual(list(without_text("", json.loads(self.schema))), [])


if __name__ == "__main__":
    unittest.main()
