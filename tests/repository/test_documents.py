"""Documents lead somewhere: every relative link of a Markdown file names a file, and every page hangs on the map."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def links(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in LINK.findall(text):
        if "://" not in target and not target.startswith("mailto:"):
            yield target, (page.parent / target).resolve()


class Documents(unittest.TestCase):
    def test_links_lead_to_files(self):
        broken = [f"{page.relative_to(ROOT)}: {name}" for page in pages() for name, file in links(page) if not file.exists()]
        self.assertEqual(broken, [])

    def test_every_page_is_on_the_map(self):
        index = ROOT / "docs/index.md"
        listed = {file for _, file in links(index)} | {index, ROOT / "README.md"}
        self.assertEqual([str(page.relative_to(ROOT)) for page in pages() if page not in listed], [])

    def test_messages_are_those_of_the_sources(self):
        # As they stand there: literals that follow one another are one.
        sources = "".join(re.sub(r'"\s*\n\s*"', "", file.read_text(encoding="utf-8")) for file in (ROOT / "src").rglob("*.?pp"))
        words = re.findall(r"^\| `([^`]*)` \|", (ROOT / "docs/messages.md").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertGreater(len(words), 30)
        self.assertEqual([w for w in words if w.lower() not in sources.lower()], [])


if __name__ == "__main__":
    unittest.main()
