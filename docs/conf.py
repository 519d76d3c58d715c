"""The site of the documents: `tools/docs.sh` builds it. The pages are plain Markdown, which code hosts show as well."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parent.parent

project = "Pliant"
author = "the Pliant authors"
copyright = "2026, the Pliant authors"  # noqa: A001
version = release = re.search(r"project\(pliant VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)

extensions = ["myst_parser", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 5  # page.md#a-heading, as code hosts have it
exclude_patterns = ["examples"]
html_theme = "furo"
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_title = f"Pliant {version}"
html_copy_source = False
html_show_sourcelink = False
html_show_search_summary = False  # it fetches pages, which browsers do not do from files
pygments_style = "friendly"
pygments_dark_style = "native"

OUTSIDE = re.compile(r"\[([^\]]*)\]\((?:(?:\.\./)+[^)#]*/|(?:\.\./)*(?:CHANGELOG|CONTRIBUTING|README)\.md[^)]*)\)")
LINK = re.compile(r"^- \[[^\]]*\]\(([^)#]+)\.md\)", re.MULTILINE)


def with_contents(text):
    """The map with Sphinx's tables of contents: one for each of its parts, of the pages that it links."""
    parts = re.split(r"^\*\*(.+)\*\*$", text, flags=re.MULTILINE)[1:]
    for caption, entries in zip(parts[::2], parts[1::2]):
        pages = "\n".join(LINK.findall(entries))
        text += f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{pages}\n```\n"
    return text + '\n<p>The <a href="cpp/index.html">C++ reference</a> is made from the headers.</p>\n'


def read(_, page, source):
    """What stands on the site only; of what lies outside of docs/, files come along, folders and pages do not."""
    if page == "citing":
        source[0] += re.sub(r"^#", "\n##", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    source[0] = OUTSIDE.sub(r"\1", source[0])
    if page == "index":
        source[0] = with_contents(source[0])


# Debian's Furo is not bundled: its script imports another one as a module although pages load it as a plain script, and its styles are
# imported from a web server's root.
IMPORTED_SCRIPT = re.compile(r"^import Gumshoe from .*$", re.MULTILINE)
IMPORTED_STYLE = re.compile(r"^@import url\(/javascript/(normalize\.css/normalize\.css)\);$", re.MULTILINE)


def bundle(app, failure):
    """Makes one script and one style sheet of Furo's where they are not."""
    static = pathlib.Path(app.outdir) / "_static"
    script, style = static / "scripts/furo.js", static / "styles/furo.css"
    if failure or not script.is_file():
        return
    text = script.read_text(encoding="utf-8")
    if IMPORTED_SCRIPT.search(text):
        imported = (static / "scripts/gumshoe-patched.js").read_text(encoding="utf-8")  # which makes window.Gumshoe
        script.write_text(imported + "\n" + IMPORTED_SCRIPT.sub("", text), encoding="utf-8")
    text = style.read_text(encoding="utf-8")
    found = IMPORTED_STYLE.search(text)
    if found:
        imported = pathlib.Path("/usr/share/javascript") / found[1]
        style.write_text(IMPORTED_STYLE.sub(lambda _: imported.read_text(encoding="utf-8") if imported.is_file() else "", text), encoding="utf-8")


def setup(app):
    app.connect("build-finished", bundle)
    app.connect("source-read", read)
