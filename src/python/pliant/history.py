"""history.csv: a row per completed step."""
import csv
import difflib
import os
from collections.abc import Iterator, Mapping
from typing import Any, Union

import numpy as np

from . import notebook
from .checks import path_of
from .error import FILE, MissingError, PliantError
from .files import refuse_input, results_elsewhere


class History(Mapping[str, np.ndarray]):
    """Columns by name, float64 arrays of one value per step; row 0 is the initial state.

    `docs/output.md` says what the columns are. An active run has the rows that are complete so far.
    """

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """`path`: the output directory of a run, or its history.csv."""
        file = path_of(path, "History")
        refuse_input(file)
        place = file
        file = os.path.join(file, "history.csv") if os.path.isdir(file) else file
        if not os.path.isfile(file):
            raise PliantError(f"no history: {file} does not exist{results_elsewhere(place, 'history.csv')}", FILE)
        try:
            with open(file, newline="", encoding="utf-8") as lines:
                rows = list(csv.reader(line for line in lines if line.endswith("\n")))
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise PliantError(f"{file} is not a history of a run: {error}", FILE) from error
        names = rows[0] if rows else []
        complete = [row for row in rows[1:] if len(row) == len(names)]
        if "time" not in names or not complete:
            raise PliantError(f"{file} is not a history of a run, or holds no step yet", FILE)
        try:
            table = np.array(complete, dtype=float)
        except ValueError as error:
            raise PliantError(f"{file}: {error}", FILE) from error
        self.file = file
        self._columns = {name: table[:, i] for i, name in enumerate(names)}

    def __getitem__(self, name: str) -> np.ndarray:
        if isinstance(name, str) and name in self._columns:
            return self._columns[name]
        near = difflib.get_close_matches(str(name), self._columns, 3) or list(self._columns)
        raise MissingError(f"no column {name!r} in {self.file}; there are {', '.join(near)}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return notebook.history_in_a_line(self)

    def _repr_html_(self) -> str:
        """For notebooks: the energies, and the range of every column."""
        return notebook.history_as_html(self)

    @property
    def time(self) -> np.ndarray:
        """[s]; of a static run the load factor, or the length of its path."""
        return self["time"]

    def vector(self, name: str) -> np.ndarray:
        """Steps x 3: the columns <name>x, y, z, e.g. `tip_` for the position of the probe tip, `clamp_f` for a reaction."""
        if not all(f"{name}{axis}" in self for axis in "xyz"):
            known = [column[:-1] for column in self if column.endswith("x") and all(column[:-1] + axis in self for axis in "yz")]
            raise MissingError(f"no columns {name}x, {name}y and {name}z in {self.file}; there are those of {', '.join(known)}")
        return np.stack([self[name + axis] for axis in "xyz"], axis=1)

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame with a row per step; PliantError where pandas is not installed."""
        try:
            import pandas
        except ImportError:
            raise PliantError("to_dataframe needs pandas: install the package python3-pandas, or `pip install pandas`") from None
        return pandas.DataFrame(self._columns)
