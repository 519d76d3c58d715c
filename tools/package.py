"""The Python package of this clone, or that of the installation to which this file belongs."""
import pathlib
import sys

_here = pathlib.Path(__file__).resolve()
for _folder in (_here.parent.parent / "src/python", _here.parent.parent.parent.parent / "lib/python3/dist-packages"):
    if (_folder / "pliant").is_dir():
        sys.path.insert(0, str(_folder))
        break

from pliant import History, PliantError, Result, Surface  # noqa: E402, F401
