"""docs/messages.md has every message of the sources, and tools/messages.py finds them."""
import importlib.util
import pathlib
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def tool():
    spec = importlib.util.spec_from_file_location("messages", ROOT / "tools/messages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Messages(unittest.TestCase):
    def found(self, source):
        messages = tool()
        return [text for code, literals in messages.statements(source) if literals and messages.REPORTS.search(code)
                for text in map(messages.tidy, messages.patterns(code, literals))]

    def test_page_is_complete(self):
        done = subprocess.run([ROOT / "tools/messages.py"], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout, done.stderr), (0, "", ""))

    def test_list_is_not_nearly_empty(self):
        self.assertGreater(sum(map(len, tool().messages().values())), 250)

    def test_parts_of_a_message_are_joined(self):
        self.assertEqual(self.found('throw FileError("cannot write \'" + path.string() + "\': it is "\n  "full");'),
                         ["cannot write '…': it is full"])
        self.assertEqual(self.found('notices.push_back(fmt::format("{} of {:.3g} m is left", n, x));'), ["… of … m is left"])
        self.assertEqual(self.found('throw MeshDefect(name + " must hold numbers");'), ["… must hold numbers"])

    def test_entries_are_whole_messages(self):
        """What the code adds before and behind stands there as '…', and what only continues another message has no entry."""
        for code, expected in (('fail("has no array \'" + name + \'\\\'\');', "… has no array '…'"), ('fail(fmt::format("the section says ", n));', "the section says …"),
                               ('fail(where + ": the file is damaged");', "…: the file is damaged"), ('fail("\': the file is damaged");', "…: the file is damaged")):
            self.assertEqual(self.found(code), [expected])
        messages = tool()
        for part in ("(a power is written '^')…", "…; choose a direction across it", "or reverse 'normal', which must point up", "true or false"):
            self.assertFalse(messages.is_message(part), part)
        for places in messages.messages().values():
            for text in places:
                self.assertRegex(text, r"^[\w'`*$…\[./-]")
                self.assertNotRegex(text, r"(?:\(| in row| not| ')$|^…['>)]")

    def test_several_messages_stay_apart(self):
        self.assertEqual(self.found('if (a) fail("one is wrong"); else fail("two is wrong");'), ["one is wrong", "two is wrong"])
        self.assertEqual(self.found('errors.push_back({where, "one is wrong"});\nwarn("two is odd");'), ["one is wrong", "two is odd"])

    def test_other_texts_are_no_messages(self):
        self.assertEqual(self.found('// throw Error("a comment")\nconst Hdf5Handle group(H5Gopen2(f, "x"), H5Gclose, "open it");'), [])

    def test_rows_explain_messages(self):
        messages = tool()
        page = "| words | meaning | what helps |\n|---|---|---|\n| `Is Full` | no space | |\n| `one` ... `two` | both | |\n"
        rows = list(messages.rows(page))
        self.assertEqual(rows, [[["Is Full"]], [["one", "two"]]])
        self.assertTrue(messages.is_explained("the disk is full", rows))
        self.assertTrue(messages.is_explained("one and two", rows))
        self.assertFalse(messages.is_explained("two and one", rows))


if __name__ == "__main__":
    unittest.main()
