"""What is given to the package: values that are not what is expected end with an InputError that says what is."""
import math
import numbers
import os
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from .error import InputError


def path_of(given: Any, what: str) -> str:
    """The name of a file or directory. `what`: what it is called where it is given."""
    if not isinstance(given, (str, os.PathLike)) or not isinstance(os.fspath(given), str):
        raise InputError(f"{what}: the name of a file or a directory is expected, not {short(given)}")
    if not os.fspath(given):
        raise InputError(f"{what}: the name is empty")
    return os.fspath(given)


def input_file_of(given: Any, what: str) -> str:
    """The name of an input file, where a text or a dictionary cannot be given."""
    if not isinstance(given, (str, os.PathLike)) or "\n" in str(given):
        raise InputError(f"{what} takes the name of an input file, not {short(given)}; write other inputs to a file first")
    return path_of(given, what)


def number_of(given: Any, what: str) -> float:
    """A number that is finite."""
    is_number = isinstance(given, numbers.Real) or (isinstance(given, np.ndarray) and given.dtype.kind in "iuf")
    if is_number and not isinstance(given, (bool, np.bool_)) and np.ndim(given) == 0:
        number = float(given)  # type: ignore[arg-type]
        if math.isfinite(number):
            return number
    raise InputError(f"{what}: a finite number is expected, not {short(given)}")


def positive_of(given: Any, what: str) -> float:
    number = number_of(given, what)
    if number <= 0:
        raise InputError(f"{what}: a number above 0 is expected, not {number:g}")
    return number


def names_of(given: Any, what: str, example: str) -> "list[str]":
    """A list of names, which may be empty."""
    is_list = isinstance(given, Iterable) and not isinstance(given, (str, bytes))
    names = list(given) if is_list else []
    if not is_list or not all(isinstance(name, str) and name for name in names):
        raise InputError(f"{what}: a list of names is expected, such as {what}=['{example}'], not {short(given)}")
    return names


def array_of(given: Any, what: str, shape: "Sequence[int | None]") -> np.ndarray:
    """Real numbers in an array of this shape; None: any length."""
    wanted = f"an array of shape ({', '.join('n' if n is None else str(n) for n in shape)}{',' if len(shape) == 1 else ''})"
    try:
        array = np.asarray(given)
        is_real = np.isrealobj(array)
        array = array.astype(float) if is_real else array
    except (TypeError, ValueError):
        is_real = False
    if not is_real:
        raise InputError(f"{what}: {wanted} of real numbers is expected, not {short(given)}")
    if array.ndim != len(shape) or any(n not in (None, length) for n, length in zip(shape, array.shape)):
        raise InputError(f"{what}: {wanted} is needed, not {array.shape}")
    return array


def require_finite(array: np.ndarray, what: str) -> None:
    count = np.count_nonzero(~np.isfinite(array))
    if count > 0:
        raise InputError(f"{what}: {count} of {array.size} numbers are not finite")


def short(given: Any) -> str:
    """What was given, in a few words."""
    shown = repr(given)
    return shown if len(shown) <= 60 and "\n" not in shown else f"{shown[:40]}... ({type(given).__name__})".replace("\n", " ")
