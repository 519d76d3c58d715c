#!/usr/bin/python3
"""Checks that sources are read in portions: files of src/ have at most 450 lines, functions at most 80.

Prints `file:line: what is too long` and returns 1 when something is. With an argument: that folder instead of src/.
A function is what stands in braces after parameters, at the level of namespaces and classes; what is defined in it counts as its own.
"""
import pathlib
import re
import sys

MOST_LINES = {"file": 450, "function": 80}
TEXTS = re.compile(r'R"(\w*)\(.*?\)\1"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE)
SCOPE = re.compile(r'\b(?:namespace|class|struct|union|extern "")')
FUNCTION = re.compile(r"\)\s*(?:\b(?:const|noexcept|override|final|mutable|try)\b\s*|&+\s*|->[^;]*|:\s.*)*$", re.DOTALL)
TEMPLATE = re.compile(r"^\s*template\s*<[^;]*?>\s*(?=class|struct|union)", re.DOTALL)


def blanked(match):
    """The same lines without what is written on them; a text in quotes stays one."""
    return ('""' if '"' in match[0][:2] else "") + "\n" * match[0].count("\n")


def kind_of(head):
    """What a brace after `head` opens: "scope", "function" or "value"."""
    if re.match(r"\s*(?:enum\b|using\b)", head):
        return "value"
    named = TEMPLATE.sub("", head)
    if SCOPE.match(named.lstrip()) and "(" not in re.sub(r"__attribute__\(\(.*?\)\)|alignas\(.*?\)", "", named):
        return "scope"
    after_parameters = FUNCTION.search(head)
    if after_parameters is None:
        return "value"
    # In a list of what a constructor initialises, a name before the brace opens a value.
    initialises = re.search(r"\)\s*(?:noexcept\s*)?:\s", head)
    return "value" if initialises and not re.search(r"[)}]\s*$", head) else "function"


def functions(text):
    """Yields (first line, lines) of each function."""
    text = TEXTS.sub(blanked, text)
    stack, start = [], 0  # what is open, and where the statement began
    for match in re.finditer(r"[{};]|\b(?:public|private|protected)\s*:", text):
        mark, place = match[0], match.start()
        if "function" in stack or "value" in stack:
            if mark == "{":
                stack.append("inner")
            elif mark == "}":
                if stack.pop() == "function":
                    first = start + len(text[start:]) - len(text[start:].lstrip())
                    yield text.count("\n", 0, first) + 1, text.count("\n", first, place) + 1
                    start = place + 1
        elif mark == "{":
            stack.append(kind_of(text[start:place]))
            if stack[-1] == "scope":
                start = place + 1
        else:
            if mark == "}":
                stack.pop()
            start = match.end()


def check(source):
    """All that is too long as lines of text."""
    errors = []
    for file in sorted(source.rglob("*.?pp")):
        text = file.read_text(encoding="utf-8")
        name = file.relative_to(source)
        n = len(text.splitlines())
        if n > MOST_LINES["file"]:
            errors.append(f"{name}: {n} lines, of {MOST_LINES['file']} at most: part it")
        for line, n in functions(text):
            if n > MOST_LINES["function"]:
                errors.append(f"{name}:{line}: a function of {n} lines, of {MOST_LINES['function']} at most: part it")
    return errors


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    source = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "src"
    errors = check(source)
    print("\n".join(errors) if errors else f"{source}: files and functions are short")
    sys.exit(1 if errors else 0)


if __name__ == "__main__":
    main()
