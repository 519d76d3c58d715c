"""The table of docs/verification.md: rows that the tests compute, and their place in the document."""
import dataclasses
import math
import re

BEGIN = "<!-- tests/program/test_verification.py --write writes this table. -->"
END = "<!-- Its end. -->"
HEAD = "| case | mesh | quantity | expected | Pliant | difference |\n|---|---|---|---|---|---|\n"
NUMBER = re.compile(r"-?\d+(?:\.(\d+))?(?:e(-?\d+))?")
SMALLEST_SHARE = 5e-5  # smaller differences are told by their bound


@dataclasses.dataclass
class Row:
    case: str  # the input's name
    mesh: str
    source: int  # its number in the document's list
    quantity: str
    expected: str  # a number as published, its unit behind it
    value: float  # what the run gives, in that unit
    within: float  # the difference that is allowed, as a part of `size`
    size: float  # what differences are measured by; the expected number, or one of its sign

    def difference(self):
        return (self.value - number_in(self.expected)) / self.size

    def line(self):
        text, _, unit = self.expected.partition(" ")
        mantissa, _, power = text.partition("e")
        digits = min(max(5, len(mantissa.lstrip("-0.").replace(".", ""))), 10)
        scaled = self.value / 10.0 ** int(power or 0)
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(scaled))))
        value = f"{scaled:.{decimals}f}" + (f"e{power}" if power else "")
        d = self.difference()
        difference = f"{100 * d:.2f} %" if abs(d) >= SMALLEST_SHARE else "< " + f"{self.within:.0e}".replace("e-0", "e-")
        link = f"[{self.case}](../input/verification/{self.case}.yaml)"
        cells = [link, self.mesh, self.quantity, f"{self.expected} ({self.source})", f"{value} {unit}".strip(), difference]
        return "| " + " | ".join(cells) + " |"


def number_in(text):
    return float(NUMBER.match(text).group(0))


def lines_of(document):
    """The rows that stand in the document."""
    return document.split(BEGIN)[1].split(END)[0].strip().splitlines()[2:]


def with_lines(document, lines):
    before, rest = document.split(BEGIN)
    return before + BEGIN + "\n" + HEAD + "".join(line + "\n" for line in lines) + END + rest.split(END)[1]


def agree(written, found):
    """Whether two lines say the same, numbers to one unit of the last digit that is written: it may be rounded."""
    if NUMBER.sub("#", written) != NUMBER.sub("#", found):
        return False
    for a, b in zip(NUMBER.finditer(written), NUMBER.finditer(found)):
        unit = 10.0 ** (int(a.group(2) or 0) - len(a.group(1) or "")) if a.group(1) else 0.0
        if abs(float(a.group(0)) - float(b.group(0))) > 1.01 * unit:
            return False
    return True
