#!/usr/bin/python3
"""What shells and man know of the program: generated, up to date, and of use."""
import re
import shutil
import subprocess
import unittest

from program import ROOT, ProgramTest

SHELL = ROOT / "src/shell"


class Shell(ProgramTest):
    def commands(self, *above):
        """Every command with its options, as the help says."""
        text = self.call(*above, "--help").stdout
        found = {" ".join(above): re.findall(r"^ +(?:-\w,)?(--[\w-]+)", text, re.M)}
        listed = text.partition("Subcommands:\n")[2].partition("Examples:\n")[0]
        for name in re.findall(r"^  (\w+)", listed, re.M):
            found.update(self.commands(*above, name))
        return found

    def test_generated_files_are_up_to_date(self):
        for command, file in (("completion", "pliant.bash"), ("man", "pliant.1")):
            text = self.call(command).stdout
            self.assertEqual((SHELL / file).read_text(), text, f"after a change: build/bin/pliant {command} > src/shell/{file}")

    def test_every_command_and_option(self):
        page = (SHELL / "pliant.1").read_text().replace("\\-", "-")
        commands = self.commands()
        self.assertGreater(len(commands), 12)
        for path, options in commands.items():
            with self.subTest(path):
                section = page.partition(f'.SS "pliant {path}')[2].partition(".SS")[0] if path else page
                for option in options:
                    if option != "--help":
                        self.assertIn(option, section)
                self.assertEqual(set(self.completed("pliant", *path.split(), "--")), set(options))

    def completed(self, *words):
        """What the script offers for the last word."""
        script = f'source {SHELL / "pliant.bash"}; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _pliant; printf "%s\\n" "${{COMPREPLY[@]}}"'
        done = subprocess.run(["bash", "-c", script, "bash", *words], cwd=self.directory, capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr, "")
        return [word for word in done.stdout.split("\n") if word]

    def test_completion(self):
        for name in ("bar.yaml", "bar.msh", "bar.h5", "baz.yml"):
            self.write(name, "")
        (self.directory / "bags").mkdir()
        self.assertEqual(self.completed("pliant", "re"), ["resume", "report", "render"])
        self.assertEqual(self.completed("pliant", "run", "ba"), ["bags", "bar.yaml", "baz.yml"])
        self.assertEqual(self.completed("pliant", "info", ""), ["bags", "bar.h5"])
        self.assertEqual(self.completed("pliant", "converge", "bar.yaml", "--in", ""), ["time", "space", "tolerance"])
        self.assertEqual(self.completed("pliant", "run", "bar.yaml", "--output", "b"), ["bags", "bar.h5", "bar.msh", "bar.yaml", "baz.yml"])
        self.assertEqual(self.completed("pliant", "plot", "bags", "-o", "b"), ["bags", "bar.h5", "bar.msh", "bar.yaml", "baz.yml"])
        self.assertEqual(self.completed("pliant", "render", "--view", "b"), ["back", "bottom"])
        self.assertEqual(self.completed("pliant", "run", "--set", "b"), [])
        self.assertEqual(self.completed("pliant", "mesh", "convert", "bar.msh", "--s"), ["--size", "--scale"])
        self.assertEqual(self.completed("pliant", "run", "bar.yaml", "--", "-log"), [])

    @unittest.skipUnless(shutil.which("groff"), "needs groff")
    def test_man_page_is_well_formed(self):
        done = subprocess.run(["groff", "-man", "-ww", "-z", SHELL / "pliant.1"], capture_output=True, text=True, check=True)
        self.assertEqual(done.stderr, "")


if __name__ == "__main__":
    unittest.main()
