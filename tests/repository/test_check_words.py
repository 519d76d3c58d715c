"""tools/check_words.py finds the lapses of its table in comments, messages and documents, with their lines, and nothing else."""
import importlib.util
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]

# One sample at least for each row of the table.
LAPSES = [
    "this is no input", "these are no potentials", "it was no mesh", "which tells the others", "MPI is told", "the run goes on",
    "to go on", "an error in parts of the tolerance", "say what it is that fails", "Of each node, its place", "Read it. Of a cell, all",
    "the same of a facet", "in the box beside it", "a mesh that was mended", "a sum that of which is 1", "the program complains",
    "all complaints", "a user's mistake", "it knows no units", "if memory does not suffice", "to the digits of the change",
    "for want of space", "lest it fails", "it sees to it that", "near to a wall", "is of no account", "a part of rank one",
    "the next step of the ladder", "the turned factor", "with turned preconditioners", "it climbs", "nodes that are led",
    "lonely nodes", "print the doubts", "two keys quarrel",
]
FINE = [
    "there is no file of this name", "there are no loads", "the step is no longer valid", "it is no more than 3", "it is no larger than 1",
    "what is ongoing", "divided in parts", "of each node", "Of course it does", "the same as a facet", "besides", "recommended", "amended",
    "that which is", "this led to a failure", "scheduled", "doubtful", "a turned body", "stolen", "a bladder", "it must not be mistaken", "he knows nothing", "nearer to", "the latest", "rank one",
]


def lapses(files):
    """What the tool says of a tree with these files, and its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            file = pathlib.Path(folder) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        done = subprocess.run([ROOT / "tools/check_words.py", folder], capture_output=True, text=True, check=False)
        return done.stdout.splitlines() if done.returncode else [], done.returncode, done.stderr


class CheckWords(unittest.TestCase):
    def found(self, text, name="src/new/a.hpp"):
        lines, code, errors = lapses({name: text})
        self.assertEqual((code, errors), (1 if lines else 0, ""))
        return [int(line.split(":")[1]) for line in lines]

    def test_every_sample_is_found(self):
        lines = self.found("".join(f"/// {sample}\n\n" for sample in LAPSES))
        self.assertEqual(lines, list(range(1, 2 * len(LAPSES), 2)))

    def test_every_row_has_a_sample(self):
        spec = importlib.util.spec_from_file_location("check_words", ROOT / "tools/check_words.py")
        tool = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(tool)
        for pattern, _ in tool.PATTERNS:
            self.assertTrue(any(pattern.search(sample) for sample in LAPSES), pattern.pattern)

    def test_plain_words_are_fine(self):
        self.assertEqual(self.found("".join(f"/// {sample}\n\n" for sample in FINE)), [])

    def test_code_is_not_read(self):
        self.assertEqual(self.found("int led = told(beside);  // `Mending`\nauto n = 1'000'000; // fine\nchar c = '\\'';\nint lonely;\n"), [])

    def test_words_may_stand_on_two_lines(self):
        self.assertEqual(self.found("// a run goes\n// on\n\nint a;\n"), [1])
        self.assertEqual(self.found('throw Error("it is "\n            "no mesh");\n'), [1])
        self.assertEqual(self.found("/* a\n * run that\n * goes on */\n"), [3])
        self.assertEqual(self.found("A run goes\non.\n", "CONTRIBUTING.md"), [1])

    def test_separate_comments_are_not_joined(self):
        self.assertEqual(self.found("int a;  ///< how it goes\nint b;  ///< on a facet\n"), [])
        self.assertEqual(self.found("// it goes\n\n// on a facet\n"), [])

    def test_literals_are_read(self):
        self.assertEqual(self.found('const char* s = R"(\nfine\nit goes on)";\n'), [3])
        self.assertEqual(self.found("const s = 'it goes on';\nconst t = `it\ngoes on`;\n", "src/new/a.js"), [1, 3])

    def test_code_in_documents_is_not_read(self):
        self.assertEqual(self.found("A `told` b.\n\n```\nit goes on\n```\n\nIt goes on.\n", "CONTRIBUTING.md"), [7])

    def test_scripts_are_read(self):
        self.assertEqual(self.found("#!/bin/sh\n# it goes\n# on\necho 'is told'\n", "src/new/a.sh"), [2, 4])


if __name__ == "__main__":
    unittest.main()
