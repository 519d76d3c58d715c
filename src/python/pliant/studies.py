"""Derivatives of runs, and fits: what `pliant sensitivity` and `pliant fit` find, in numpy."""
import csv
import dataclasses
import os
from collections.abc import Mapping, Sequence
from typing import Any, Optional

import numpy as np

from .error import PliantError
from .runs import Path, completed, settings_of

NOT_CONVERGED = 1  # exit code of the program


@dataclasses.dataclass(frozen=True)
class Sensitivity:
    """Columns of a history with their derivatives by numbers of the input, one entry per step; SI units."""

    directory: str
    time: np.ndarray  #: (n,) [s], or the load factor
    numbers: "dict[str, float]"  #: the values at which the derivatives are taken, by key
    values: "dict[str, np.ndarray]" = dataclasses.field(repr=False)  #: (n,) by column
    jacobians: "dict[str, np.ndarray]" = dataclasses.field(repr=False)  #: (n, p) by column, in the order of `numbers`

    def derivative(self, column: str, number: str) -> np.ndarray:
        """(n,): d column / d number."""
        if column not in self.jacobians or number not in self.numbers:
            raise PliantError(f"'{column}' was not differentiated by '{number}'; columns: {', '.join(self.jacobians)}; numbers: "
                              f"{', '.join(self.numbers)}")
        return self.jacobians[column][:, list(self.numbers).index(number)]


@dataclasses.dataclass(frozen=True)
class Fit:
    """What measurements say about numbers; SI units."""

    directory: str
    values: "dict[str, float]"  #: by parameter
    standard_errors: "dict[str, float]"  #: infinite where the measurements do not determine the parameter
    units: "dict[str, str]"
    converged: bool
    log: str = dataclasses.field(repr=False)  #: what the program printed


def sensitivity(source: Path, *, of: Sequence[str], to: Sequence[str], overrides: "Optional[Mapping[str, Any]]" = None,
                output: Path = "out", ranks: int = 1, petsc_options: Sequence[str] = (), timeout: Optional[float] = None) -> Sensitivity:
    """Runs an input file with the derivatives of columns of its history by numbers of the input, named as in `overrides`: a
    function with a Jacobian for scipy.optimize.least_squares, or a backward pass of PyTorch.

        s = pliant.sensitivity("beam.yaml", of=["tip_z"], to=["bodies.0.density"], overrides={"bodies.0.density": 900})
        s.values["tip_z"], s.jacobians["tip_z"]

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    if isinstance(of, str) or isinstance(to, str) or not of or not to:
        raise PliantError("of and to are lists of names, such as of=['tip_z'], to=['bodies.0.density']")
    directory = os.path.abspath(output)
    completed(["sensitivity", os.fspath(source), "--of", ",".join(of), "--to", ",".join(to), *settings_of(overrides, output)], ranks,
              petsc_options, timeout)
    with open(os.path.join(directory, "sensitivity.csv"), encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    table = dict(zip(header, np.array(rows, dtype=float).T))
    jacobians = {c: np.stack([table[f"d({c})/d({k})"] for k in to], axis=1) for c in of}
    with open(os.path.join(directory, "numbers.csv"), encoding="utf-8", newline="") as file:
        numbers = {row["number"]: float(row["value"]) for row in csv.DictReader(file)}
    return Sensitivity(directory, table["time"], numbers, {c: table[c] for c in of}, jacobians)


def fit(file: Path, *, output: Optional[Path] = None, ranks: int = 1, timeout: Optional[float] = None) -> Fit:
    """Runs a fit file (docs/fitting.md). One that does not converge returns too, with `converged` False.

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    done = completed(["fit", os.fspath(file), *settings_of(None, output)], ranks, (), timeout, accepted=(0, NOT_CONVERGED))
    line = next(line for line in reversed(done.stdout.splitlines()) if line.startswith("results: "))
    directory = os.path.abspath(line[len("results: "):].split("/report.html,")[0])
    with open(os.path.join(directory, "fit.csv"), encoding="utf-8", newline="") as table:
        rows = list(csv.DictReader(table))
    return Fit(directory, {row["parameter"]: float(row["value"]) for row in rows},
               {row["parameter"]: float(row["standard_error"]) for row in rows}, {row["parameter"]: row["unit"] for row in rows},
               done.returncode == 0, done.stdout)
