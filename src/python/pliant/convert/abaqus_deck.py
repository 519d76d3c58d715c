"""The cards of an input file of Abaqus or CalculiX."""
import codecs
import dataclasses
import os
import re

from pliant.error import PliantError

MOST_INCLUDES = 20  # of files in files
WITH_FILE = {"INCLUDE", "NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "AMPLITUDE", "EQUATION"}
NUMBER = re.compile(r"(^|,)\s*[-+.]?\d[^=,]*(,|$)")  # as an entry of its own: a line of data


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


def read_cards(file, diagnostics):
    """All cards, with those of included files. Lines of an included file are counted as the line that includes it."""
    cards = []
    Reader(os.path.dirname(file), diagnostics, cards).read(file)
    return cards


class Reader:
    """Adds the cards of a file, and of those that it names, to `cards`; `folder`: that of the deck."""

    def __init__(self, folder, diagnostics, cards):
        self.folder, self.diagnostics, self.cards = folder, diagnostics, cards

    def read(self, file, line=None, depth=0):
        if depth > MOST_INCLUDES:
            raise self.diagnostics.wrong(line, "files include one another without end")
        head = ""  # a card whose parameters continue on the next line
        for number, content in enumerate(self.lines_of(file, line), 1):
            at, content = line or number, content.strip()
            if not content or content.startswith("**"):
                continue
            if head and (content.startswith("*") or NUMBER.search(content)):  # a comma at the end of a card, which nothing continues
                self.add_card(head, at, file, depth)
                head = ""
            if head or content.startswith("*"):
                joined = head + content
                head = joined if joined.endswith(",") else ""
                if not head:
                    self.add_card(joined, at, file, depth)
            elif self.cards:
                self.cards[-1].data.append((at, split(content.rstrip(", "))))
            else:
                raise self.diagnostics.wrong(at, "the file begins with data: it is not an input file of Abaqus or CalculiX")
        if head:
            self.add_card(head, at, file, depth)

    def lines_of(self, file, line):
        try:
            with open(file, "rb") as data:
                content = data.read()
        except OSError as error:
            raise PliantError(f"{file}: {error.strerror}") if line is None else self.diagnostics.wrong(line, f"{file}: {error.strerror}") from None
        encoding = "utf-16" if content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE) else "utf-8-sig"
        return re.split("\r\n|\r|\n", content.decode(encoding, errors="replace"))

    def add_card(self, text, line, file, depth):
        name, *parameters = split(text[1:])
        named = {}
        for parameter in parameters:
            key, equals, value = parameter.partition("=")
            if key:
                named["".join(key.upper().split())] = value.strip() if equals else ""
        card = Card("".join(name.upper().split()), named, line, [], " ".join(name.upper().split()))
        if card.keyword != "INCLUDE":
            self.cards.append(card)
        if card.keyword not in WITH_FILE or not card.has("INPUT") and card.keyword != "INCLUDE":
            return
        if card.value("INPUT"):
            self.read(self.place_of(card.value("INPUT"), file), line, depth + 1)
        else:
            raise self.diagnostics.wrong(line, f"{card.title}: the name of the file (INPUT=...) is missing")

    def place_of(self, name, file):
        """Next to the deck, as Abaqus and CalculiX look for it, or to the file that names it."""
        name = name.replace("\\", "/")
        places = [os.path.join(folder, name) for folder in (self.folder, os.path.dirname(file))]
        return next((place for place in places if os.path.exists(place)), places[0])


def split(text):
    """The parts between commas, without blanks around them and without the quotes in which a name may have commas of its own."""
    is_quoted = '"' in text and text.count('"') % 2 == 0
    parts = re.split(r',(?=(?:[^"]*"[^"]*")*[^"]*$)', text) if is_quoted else text.split(",")
    return [part.replace('"', "").strip() for part in parts]


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
