"""What went wrong, as one exception."""
import difflib
from collections.abc import Iterable

FILE = 4  # the code of files that cannot be read or written


class PliantError(Exception):
    """A file that is not what it should be, or a run that failed; the text says which and why.

    `code` is the exit code of the program: 2 the input is wrong, 3 the solve failed, 4 a file could not be read or written,
    70 an unexpected failure, 130 interrupted; None where no program ran.
    """

    def __init__(self, message: str, code: "int | None" = None) -> None:
        super().__init__(message)
        self.code = code


class InputError(PliantError, ValueError):
    """The input, or a value given to a simulation, is wrong; code 2."""

    def __init__(self, message: str) -> None:
        super().__init__(message, 2)


class MissingError(InputError, KeyError, IndexError):
    """There is nothing of this name or number; code 2. Mappings and sequences expect a KeyError or an IndexError, which it also is."""

    __str__ = Exception.__str__  # that of KeyError adds quotation marks


class SolveError(PliantError, RuntimeError):
    """A step could not be solved; code 3."""

    def __init__(self, message: str) -> None:
        super().__init__(message, 3)


def did_you_mean(name: str, known: "Iterable[str]") -> str:
    """`did you mean 'x'? `, where one of the names is like it; else nothing."""
    close = difflib.get_close_matches(name, list(known), 1)
    return f"did you mean '{close[0]}'? " if close else ""
