"""The Python package of this clone, or the one that is installed."""
import pathlib
import sys

_clone = pathlib.Path(__file__).resolve().parent.parent / "src/python"
if _clone.is_dir():
    sys.path.insert(0, str(_clone))

from pliant import History, PliantError, Result, Surface  # noqa: E402, F401
