"""The cards of an input file of Abaqus or CalculiX."""
import dataclasses
import os
import re

from pliant.error import PliantError


@dataclasses.dataclass
class Card:
    """`keyword`: in capitals, without blanks; `parameters`: by their names in capitals; `data`: (line, entries)."""

    keyword: str
    parameters: dict
    line: int
    data: list

    def has(self, name):
        return name in self.parameters

    def value(self, name, default=""):
        return self.parameters.get(name, default)

    def upper(self, name, default=""):
        return self.parameters.get(name, default).upper()

    @property
    def title(self):
        """As it is known: *SOLID SECTION."""
        return "*" + self.name

    name: str = ""


def read_cards(file, diagnostics, line=None, depth=0):
    """All cards, with those of included files. Lines of an included file are counted as the line that includes it."""
    try:
        with open(file, encoding="utf-8", errors="replace") as text:
            lines = text.read().splitlines()
    except OSError as error:
        raise PliantError(f"{file}: {error.strerror}") from None
    cards, head = [], None  # head: a card whose parameters continue on the next line
    for number, content in enumerate(lines, 1):
        at = line or number
        content = content.strip()
        if not content or content.startswith("**"):
            continue
        if content.startswith("*") or head is not None:
            joined = (head or "") + content
            head = joined if joined.endswith(",") else None
            if head is None:
                add_card(cards, joined, at, file, diagnostics, depth)
        elif cards:
            cards[-1].data.append((at, [entry.strip() for entry in content.rstrip(", ").split(",")]))
        else:
            raise diagnostics.wrong(at, "the file begins with data: it is not an input file of Abaqus or CalculiX")
    return cards


def add_card(cards, text, line, file, diagnostics, depth):
    name, *parameters = [part.strip() for part in text[1:].split(",")]
    named = {}
    for parameter in parameters:
        key, equals, value = parameter.partition("=")
        if key:
            named["".join(key.upper().split())] = value.strip().strip('"') if equals else ""
    card = Card("".join(name.upper().split()), named, line, [], " ".join(name.upper().split()))
    if card.keyword == "INCLUDE":
        if depth > 20:
            raise diagnostics.wrong(line, "files include one another without end")
        cards += read_cards(os.path.join(os.path.dirname(file), card.value("INPUT")), diagnostics, line, depth + 1)
    else:
        cards.append(card)


def real(entries, index, line, diagnostics, what, default=None):
    """A number of a data line; `default` where the entry is empty or missing."""
    text = entries[index] if index < len(entries) else ""
    if not text and default is not None:
        return default
    return diagnostics.number(re.sub("[dD]", "e", text), line, what)  # Fortran's exponents


def whole(text, line, diagnostics, what):
    try:
        return int(text)
    except ValueError:
        raise diagnostics.wrong(line, f"{what} is not a whole number: '{text}'") from None
