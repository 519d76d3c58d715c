"""The inputs that come with Pliant fit the schema that the program prints, so that editors complete from it rightly."""
import json
import os
import pathlib
import subprocess
import unittest

import jsonschema
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("PLIANT", ROOT / "build/bin/pliant"))


@unittest.skipUnless(PROGRAM.exists(), f"{PROGRAM} is not built")
class Inputs(unittest.TestCase):
    def test_inputs_fit_the_schema(self):
        command = [PROGRAM, "schema"]
        schema = json.loads(subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, check=True).stdout)
        files = sorted((ROOT / "input").rglob("*.yaml"))
        self.assertTrue(files)
        for file in files:
            with self.subTest(file.name):
                jsonschema.validate(yaml.safe_load(file.read_text(encoding="utf-8")), schema)


if __name__ == "__main__":
    unittest.main()
