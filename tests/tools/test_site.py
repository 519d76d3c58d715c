#!/usr/bin/python3
"""The built site of the documents in a browser, from files: no script fails, the search finds, the theme changes.

The folder is docs/html in that of the build (tools/docs.sh), where PLIANT_BUILD says it is.
"""
import os
import pathlib
import sys
import unittest
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/program"))

from browser import CHROMIUM, Browser  # noqa: E402

SITE = pathlib.Path(os.environ.get("PLIANT_BUILD", ROOT / "build")) / "docs/html"


@unittest.skipUnless(CHROMIUM, "chromium is not installed")
@unittest.skipUnless((SITE / "search.html").exists(), "the site is not built: tools/docs.sh")
class Site(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser((1280, 900))
        cls.addClassCleanup(cls.browser.__exit__)

    def open(self, page):
        self.browser.errors.clear()
        self.browser.call("Page.navigate", url=f"file://{SITE}/{page}")
        self.browser.wait("document.readyState === 'complete' && document.querySelector('article, .contents') !== null")

    def test_no_script_fails(self):
        for page in ("index.html", "materials.html", "developer/architecture.html", "cpp/index.html"):
            with self.subTest(page):
                self.open(page)
                self.assertEqual(self.browser.errors, [])

    def test_the_theme_changes(self):
        self.open("index.html")
        seen = set()
        for _ in range(3):
            seen.add(self.browser.evaluate("document.body.dataset.theme"))
            self.browser.evaluate("[...document.querySelectorAll('.theme-toggle')].find(button => button.offsetParent).click()")
        self.assertEqual(seen, {"auto", "light", "dark"})
        self.assertEqual(self.browser.errors, [])

    def found(self, words):
        """Pages that the search lists."""
        self.open(f"search.html?q={urllib.parse.quote(words)}")
        self.browser.wait("/found|did not match/.test(document.querySelector('.search-summary')?.textContent ?? '')")
        self.assertEqual(self.browser.errors, [])
        return self.browser.evaluate("[...document.querySelectorAll('#search-results li a')].map(a => a.getAttribute('href').split('?')[0].split('#')[0])")

    def test_the_search_finds_terms_of_the_field(self):
        for words, pages in (("Young's modulus", {"materials.html", "laws.html", "fitting.html", "input.html"}), ("boundary condition", {"constraints.html", "loads.html"}),
                             ("Abaqus", {"from-other-programs.html", "mesh-files.html"})):
            with self.subTest(words):
                self.assertLessEqual(pages, set(self.found(words)))
        self.assertEqual(self.found("qwertyuiopasdf"), [])


if __name__ == "__main__":
    unittest.main()
