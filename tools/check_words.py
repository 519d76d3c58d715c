#!/usr/bin/python3
"""Checks the language of comments, messages and documents against the table below.

Prints `file:line: "the words": what to write instead` and returns 1 when it finds any. With an argument: that folder instead of
the repository. The table holds lapses that a pattern can find without false alarms; a human reader finds the others.
"""
import bisect
import pathlib
import re
import sys

# What is written, and what to write instead. Patterns ignore case unless they say (?-i:...). Line breaks and
# indentation are one blank.
LAPSES = [
    (r"(?<!there )\b(?:is|are|was|were) no (?!longer\b|more\b|less\b|later\b|\w+er than\b)",
     "'is not a ...', 'are not ...' ('there is no ...' is fine)"),
    (r"\b(?:tells?|told|telling)\b", "'reports', 'says', 'shows', 'warns' or, for people, 'explain'"),
    (r"\b(?:goes|go|going|went|gone) on\b", "'continues', 'resumes'"),
    (r"\bin parts of\b", "'as a fraction of', 'relative to'"),
    (r"\bwhat it is that\b", "'what ...'"),
    (r"(?:^|(?<=[.:] ))(?-i:Of) (?!course\b)", "the subject first: 'A mesh has ...', 'The number of ...'"),
    (r"\bthe same of\b", "'the same for ...', or the noun again"),
    (r"\bbeside\b", "'next to', 'besides', 'in addition to', 'with'"),
    (r"\bmend(?:s|ed|ing)?\b", "'repair', 'fix'"),
    (r"\bthat of which\b", "'whose'"),
    (r"\bcomplain(?:s|ed|ing|t|ts)?\b", "'diagnostic', 'error', 'warning'; 'reports'"),
    (r"\bmistakes?\b", "'error'"),
    (r"\bknows? (?:of )?no\b", "'does not know', 'does not support', 'is independent of'"),
    (r"\bdo(?:es)? not suffice\b", "'is too small', 'there is too little ...'"),
    (r"\bto the digits of\b", "'accurate relative to'"),
    (r"\bfor want of\b", "'for lack of', 'without'"),
    (r"\blest\b", "'so that ... not', 'or else'"),
    (r"\bsee(?:s|n|ing)? to it that\b", "'ensures that'"),
    (r"\bnear to\b", "'near', 'close to'"),
    (r"\bof no account\b", "'has no influence'"),
    (r"\bparts? of rank one\b", "'rank-one term', 'rank-one update'"),
    # House words for what the field has a word for.
    (r"\bladders?\b", "'fallback sequence'"),
    (r"\bturned (?:factors?|factorizations?|preconditioners?)\b", "'corotated preconditioner'"),
    (r"\bclimb(?:s|ed|ing)?\b", "'escalate', 'escalation'"),
    (r"\bled\b(?! to\b)", "'prescribed'"),
    (r"\blonely\b", "'unmatched'"),
    (r"\bdoubts?\b", "'warning'"),
    (r"\bquarrel(?:s|led|ling)?\b", "'conflict'"),
]
FILES = ["README.md", "CONTRIBUTING.md", "docs/**/*", "src/**/*", "tools/*", "input/**/*", "meshes/*"]
# The vocabulary lists the words themselves.
EXCEPT = ["tools/check_words.py", "docs/developer/vocabulary.md", "docs/input.schema.json", "src/viewer/package-lock.json"]

# Comments and literals of C++, JavaScript and gmsh's scripts. A number comes first for the ' between its digits.
TOKEN = re.compile(r"""\b\d[\w'.]*
                     | (?P<comment> //[^\n]* | /\*.*?\*/)
                     | R"(?P<fence>\w*)\( (?P<raw>.*?) \)(?P=fence)"
                     | "(?P<text> (?:\\.|[^"\\\n])*)"
                     | '(?P<quoted> (?:\\.|[^'\\\n])*)'
                     | `(?P<template> (?:\\.|[^`\\])*)`""", re.DOTALL | re.VERBOSE)
C_LIKE = (".cpp", ".hpp", ".js", ".geo")
HASHED = (".py", ".sh", ".bash", ".yaml", ".txt", ".cmake")  # comments begin with '#'; code holds none of the lapses
PROSE = (".md", ".html", ".1")


class Passage:
    """Prose without its marks, and where each part of it began."""

    def __init__(self):
        self.text, self.offsets, self.lines = "", [], []

    def add(self, text, line):
        for number, part in enumerate(text.replace("\\n", " ").split("\n")):
            part = re.sub(r"\s+", " ", (" " if number else "") + part)
            self.offsets.append(len(self.text))
            self.lines.append(line + number)
            self.text += part.lstrip() if self.text.endswith(" ") else part

    def line_at(self, offset):
        return self.lines[bisect.bisect_right(self.offsets, offset) - 1]


def uncommented(comment):
    """The words of a comment, without the marks of comments and of Doxygen, and without names in `code`."""
    return re.sub(r"(?m)`[^`\n]*`|^[ \t]*(?://+<?|/\*+<?|\*+/|\*)|\*/$", "", comment)


def passages_of_code(text):
    """Comments that follow one another, and literals that the compiler joins, are one passage each."""
    kind, end, passage = None, 0, Passage()
    for match in TOKEN.finditer(text):
        if match.lastgroup is None:
            continue
        line = text.count("\n", 0, match.start()) + 1
        comment = match["comment"]
        follows = kind == (comment is not None) and not text[end:match.start()].strip()
        if passage.text and not (follows and text[end:match.start()].count("\n") < 2):
            yield passage
            passage = Passage()
        if comment is not None:
            passage.add((" " if passage.text else "") + uncommented(comment).strip(), line)
        else:
            passage.add(next(match[name] for name in ("raw", "text", "quoted", "template") if match[name] is not None), line)
        kind, end = comment is not None, match.end()
    yield passage


def passages_of_prose(text):
    """Paragraphs, without code."""
    blank = lambda match: re.sub(r"[^\n]", " ", match[0])
    text = re.sub(r"(?ms)^ *```.*?^ *```", blank, text)
    text = re.sub(r"``[^`]*``|`[^`\n]*`", lambda match: "`" + blank(match)[2:] + "`", text)
    for match in re.finditer(r"(?:[^\n]*\S[^\n]*(?:\n|$))+", text):
        passage = Passage()
        passage.add(match[0].rstrip("\n"), text.count("\n", 0, match.start()) + 1)
        yield passage


def passages_of(file, text):
    if file.suffix in C_LIKE:
        return passages_of_code(text)
    if file.suffix in HASHED:
        text = re.sub(r"(?m)^([ \t]*)#+!?[ \t]?", r"\1", text)
    return passages_of_prose(text)


def lapses_of(file):
    """Yields (line, words, what to write) for each lapse in a file."""
    for passage in passages_of(file, file.read_text(encoding="utf-8")):
        for pattern, instead in PATTERNS:
            for match in pattern.finditer(passage.text):
                yield passage.line_at(match.start()), match[0].strip(), instead


PATTERNS = [(re.compile(pattern, re.IGNORECASE), instead) for pattern, instead in LAPSES]


def files_of(root):
    """All files to look at, each once."""
    files = {file for pattern in FILES for file in root.glob(pattern) if file.suffix in C_LIKE + HASHED + PROSE}
    names = {file.relative_to(root).as_posix(): file for file in files}
    return [names[name] for name in sorted(names) if name not in EXCEPT]


def main():
    root = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent
    found = [f'{file.relative_to(root)}:{line}: "{words}": write {instead}'
             for file in files_of(root) for line, words, instead in sorted(lapses_of(file))]
    print("\n".join(found) if found else f"{root}: plain words")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
