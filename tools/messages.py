#!/usr/bin/python3
"""Keeps docs/messages.md complete: every error, warning and note of the sources has a row in one of its tables, or stands in the
list at its end, which this program writes.

    tools/messages.py            prints what is missing or outdated, and returns 1 if anything is
    tools/messages.py --write    rewrites the list

A row has a few words of the message, its meaning and what helps. A message whose own text says all that stands in the list; to
explain it, add a row and run this again.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/messages.md"
BEGIN = "<!-- The list below is written by tools/messages.py. -->\n"
# The folders of src/, as readers of the page know them.
PLACES = {
    "command": "The command line", "input": "The input", "material": "Materials", "model": "The input and its mesh",
    "mesh": "Mesh files", "run": "A run", "time": "A run", "solver": "A run", "energy": "The input and its mesh",
    "fem": "The input and its mesh", "study": "Studies", "io": "Files", "petsc": "Files", "base": "Numbers, formulas and files",
}
# And parts that several messages share: what is expected, what there is, what is meant.
PARTS = re.compile(r"an? (?:list with|map of|place \[|empty list)|the (?:lower corner|whole mesh|file says)|true or false|…(?:at least|at most|exactly) one|"
                   r"between |from … to|shortening|before its|within the data|where a name|elements of type|… in an entity|… of the mesh's|… levels|… with|"
                   r"with … Prony|rigid (?:bodies alone|parts that)|smoothed|length of|mesh size|What the data|none with|can move|one is given|time\.path|"
                   r"line …: …<|no run has this|overlap by up to|it contains no …")
# First words of a message whose subject the code puts before it; and of what only continues one.
VERBS = "is|are|has|have|needs?|must|should|does|do|belongs|uses"
CONJUNCTIONS = "and|or|but|which"
FEWEST_WORDS = 3  # of a message: less is a part of one

TOKEN = re.compile(r"""(?P<skip>//[^\n]*|/\*.*?\*/|'(?:\\.|[^'\\\n])'|\b\d[\w'.]*)
                     | R"(?P<fence>\w*)\((?P<raw>.*?)\)(?P=fence)"
                     | "(?P<text>(?:\\.|[^"\\\n])*)"
                     | (?P<code>.)""", re.DOTALL | re.VERBOSE)
# What a statement holds that reports something.
REPORTS = re.compile(r"\bthrow\b|\w*(?:Error|Defect|Failure)\(|\w*(?:fail|warn|reject|because|wrong|refuse)\w*\(|"
                     r"\w*(?:error|notice|warning|diagnostic|reason|note|shortfall|advice)\w*[.,;)\]}]|"
                     r"\breturn\b(?!.*[(]\x02)", re.IGNORECASE)

# And what says that it describes something instead.
DESCRIBES = re.compile(r"\b(?:field|add_\w+|name)\s*\(|\b(?:length|angle|vector|text|pair|list_of)\(")
# Texts that are not messages: reports, documents, names of solvers.
NOT_MESSAGES = re.compile(r"<|…?\.SH|energy \[J\]|title: |pliant … PETSc|checkpoint …|MUMPS factorization|algebraic multigrid|"
                          r"(?:… )?with (?:algebraic|p-)multigrid|with `adaptive`|output '…': … bytes|by the method|load factor")


def statements(source):
    """Yields the statements of C++: code, with \\x02 for each literal, and the literals."""
    code, literals, depth = "", [], 0
    for match in TOKEN.finditer(source):
        if match["skip"] is not None:
            continue
        if match["code"] is None:
            code += "\x02"
            literals.append(match["raw"] if match["raw"] is not None else re.sub(r'\\(["\\])', r"\1", match["text"]))
            continue
        sign = match["code"]
        depth += (sign in "([") - (sign in ")]")
        if sign == ";" or (sign in "{}" and depth <= 0):
            yield code, literals
            code, literals, depth = "", [], 0
        else:
            code += sign


def patterns(code, literals):
    """The texts that a statement puts together: literals, with '…' for what stands between them."""
    texts, before = [], ""
    for gap, literal in zip(code.split("\x02"), literals):
        text = re.sub(r"\{[^{}]*\}", "…", literal.replace("{{", "{").replace("}}", "}"))
        gap = gap.strip()
        if texts and not gap:
            texts[-1] += text
        elif texts and re.fullmatch(r"\+[^,]*(?:\([^()]*\)[^,]*)*\+|\+.*[?:(]|:", gap, re.DOTALL):
            texts[-1] += "…" + text
        else:
            texts.append(("…" if gap.endswith("+") else "") + text)
    return texts


def tidy(text):
    """In one line, and complete: '…' also for what code adds before the first literal and behind the last, as spaces and quotes there show."""
    text = re.sub(r"\s+", " ", text.replace("\\n", " "))
    text = re.sub(r"^ ?(?:…[>'\])]* ?)?[>'\])]*(?=[:;])", "…", text)
    if re.match(rf" |'?(?:{VERBS})\b(?!.*\?$)", text):
        text = "…" + text if text.startswith(" ") else "… " + text
    if text.endswith(" '"):
        text += "…'"
    elif re.search(r"[ (\[]$|[ …]in row$|[ …](?:not|but|needs)$", text):
        text = text.rstrip(" ([") + " …"
    text = text.strip(" ;:,")
    return re.sub(r"(?:… ?){2,}", "… ", text).strip()


def continues_another(text):
    """Is it only the end of a message, whose beginning is in another statement?"""
    return re.match(rf"…? ?(?:[(;,.)](?!\.)|(?:{CONJUNCTIONS})\b)", text) is not None


def is_message(text):
    return not NOT_MESSAGES.match(text) and not PARTS.match(text) and not continues_another(text) and len(re.findall(r"(?<![\w-])[A-Za-z]+(?![\w-])", text)) >= FEWEST_WORDS


def quoted(text):
    """As code in Markdown, whatever it holds."""
    return f"`{text}`" if "`" not in text else f"`` {text} ``"


def messages():
    """All messages by place: {place: sorted texts}."""
    result = {place: set() for place in dict.fromkeys(PLACES.values())}
    for file in sorted((ROOT / "src").rglob("*.?pp")):
        folder = file.relative_to(ROOT / "src").parts[0]
        if folder not in PLACES:
            continue
        for code, literals in statements(file.read_text(encoding="utf-8")):
            if literals and REPORTS.search(code) and not DESCRIBES.search(code):
                result[PLACES[folder]].update(text for text in map(tidy, patterns(code, literals)) if is_message(text))
    return {place: sorted(texts, key=lambda text: text.lstrip("…' ").lower()) for place, texts in result.items() if texts}


def rows(page):
    """For each row the words of its messages: `a` ... `b` stand in one message, in this order; `a`, `b` are of two."""
    for cell in re.findall(r"^\| (`.*?) \|", page, re.MULTILINE):
        yield [re.findall(r"`([^`]*)`", words) for words in re.split(r"(?<=`), (?=`)", cell)]


def is_explained(text, rows_):
    return any(re.search(".*".join(map(re.escape, words)), text, re.IGNORECASE) for row in rows_ for words in row)


def with_list(page):
    """The page with its list as it should be."""
    page = page.split(BEGIN)[0].rstrip("\n")
    explained = list(rows(page))
    text = f"{page}\n\n{BEGIN}## All other messages\n\nThese need no explanation: they contain their remedy, or describe one place in a damaged file. `…` stands for names and numbers of\nyour case.\n"
    for place, texts in messages().items():
        texts = [one for one in texts if not is_explained(one, explained)]
        if texts:
            text += f"\n### {place}: other messages\n\n" + "".join(f"- {quoted(one)}\n" for one in texts)
    return text


def main():
    page = PAGE.read_text(encoding="utf-8")
    wanted = with_list(page)
    if "--write" in sys.argv[1:]:
        PAGE.write_text(wanted, encoding="utf-8")
    elif page != wanted:
        have, want = set(page.splitlines()), set(wanted.splitlines())
        print("\n".join([f"missing: {line}" for line in wanted.splitlines() if line not in have] +
                        [f"outdated: {line}" for line in page.split(BEGIN)[-1].splitlines() if line not in want]))
        print("docs/messages.md is not complete: add rows for messages that need an explanation, then run tools/messages.py --write")
        sys.exit(1)


if __name__ == "__main__":
    main()
