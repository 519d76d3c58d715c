"""tools/check_layers.py finds upward includes, cycles, unknown layers and badly named headers, and nothing else."""
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CheckLayers(unittest.TestCase):
    def complaints(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in files.items():
                file = pathlib.Path(folder) / name
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
            command = [ROOT / "tools/check_layers.py", folder]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            lines = done.stdout.replace(folder + "/", "").splitlines()
            self.assertEqual(done.returncode, 1 if "pp:" in done.stdout else 0, done.stderr)
            return lines if done.returncode else []

    def test_downward_includes_are_fine(self):
        files = {"base/a.hpp": "#include <vector>\n", "mesh/b.hpp": '#include "base/a.hpp"\n#include <gmsh.h>\n'}
        self.assertEqual(self.complaints(files), [])

    def test_upward_include_is_found_with_its_line(self):
        files = {"base/a.hpp": '#pragma once\n  #  include "mesh/b.hpp"\n', "mesh/b.hpp": ""}
        (line,) = self.complaints(files)
        self.assertTrue(line.startswith("base/a.hpp:2: layer 'base' may not include layer 'mesh'"), line)

    def test_the_table_is_not_transitive(self):
        files = {"solver/a.hpp": '#include "fem/b.hpp"\n', "fem/b.hpp": ""}
        self.assertEqual(len(self.complaints(files)), 1)

    def test_rooms_of_a_layer_have_an_order(self):
        fine = {"energy/term.hpp": "", "energy/volume/a.hpp": '#include "energy/term.hpp"\n',
                "energy/equation/b.hpp": '#include "energy/volume/a.hpp"\n'}
        self.assertEqual(self.complaints(fine), [])
        for name, target in (("energy/volume/c.hpp", "energy/equation/b.hpp"), ("energy/c.hpp", "energy/volume/a.hpp")):
            (line,) = self.complaints({**fine, name: f'#include "{target}"\n'})
            self.assertEqual(line, f"{name}:1: '{name[:-6]}' may not include '{target[:-6]}'")

    def test_source_without_header_is_found(self):
        files = {"base/a.hpp": "", "base/a.cpp": "", "base/b.cpp": "", "command/main.cpp": ""}
        (line,) = self.complaints(files)
        self.assertTrue(line.startswith("base/b.cpp:1: there is no b.hpp"), line)

    def test_cycle_of_files_is_found(self):
        files = {"base/a.hpp": '#include "base/b.hpp"\n', "base/b.hpp": '\n#include "base/a.hpp"\n'}
        (line,) = self.complaints(files)
        self.assertEqual(line, "base/b.hpp:2: include cycle: base/a.hpp -> base/b.hpp -> base/a.hpp")

    def test_unknown_layer_is_found(self):
        self.assertEqual(len(self.complaints({"util/a.hpp": ""})), 1)

    def test_header_is_named_with_its_layer(self):
        files = {"base/a.hpp": '#include "b.hpp"\n#include <base/b.hpp>\n', "base/b.hpp": ""}
        self.assertEqual(len(self.complaints(files)), 2)


if __name__ == "__main__":
    unittest.main()
