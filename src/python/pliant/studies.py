"""Modes, derivatives of runs, and fits: what `pliant modes`, `pliant sensitivity` and `pliant fit` find, in numpy."""
import csv
import dataclasses
import os
import re
from collections.abc import Mapping, Sequence
from typing import Any, Optional

import numpy as np

from .checks import array_of, input_file_of, names_of, number_of, path_of, require_finite, short
from .error import FILE, InputError, MissingError, PliantError
from .result import Result
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
            raise MissingError(f"'{column}' was not differentiated by '{number}'; columns: {', '.join(self.jacobians)}; numbers: "
                              f"{', '.join(self.numbers)}")
        return self.jacobians[column][:, list(self.numbers).index(number)]


@dataclasses.dataclass(frozen=True)
class Gradient:
    """Derivatives of one number by numbers and fields of an input; SI units."""

    directory: str
    numbers: "dict[str, float]"  #: the derivative by each number, by key
    values: "dict[str, float]"  #: the values of the numbers
    fields: "dict[str, np.ndarray]" = dataclasses.field(repr=False)  #: by key: (m,) by the value in each cell, (n, 3) at each node
    field_values: "dict[str, np.ndarray]" = dataclasses.field(repr=False)  #: (m,) by key; NaN in other bodies
    cells: np.ndarray = dataclasses.field(repr=False)  #: (m,) number in the mesh of each cell, ascending; (0,) without fields of cells
    centroids: np.ndarray = dataclasses.field(repr=False)  #: (m, 3) of the cells [m]
    points: np.ndarray = dataclasses.field(repr=False)  #: (n, 3) of the nodes [m]; (0, 3) without fields of nodes


@dataclasses.dataclass(frozen=True)
class Modes:
    """Natural frequencies and mode shapes, the lowest first; SI units."""

    directory: str
    frequency: np.ndarray  #: (n,) [Hz]; 0 of rigid and of unstable modes
    eigenvalue: np.ndarray  #: (n,) the square of the angular frequency [1/s^2]; negative of unstable modes
    growth_rate: np.ndarray  #: (n,) of unstable modes, which grow as exp(growth_rate * t) [1/s]; 0 of the others
    damping_ratio: np.ndarray  #: (n,) of the critical damping; NaN without viscosity
    effective_mass: np.ndarray  #: (n, 3) along x, y, z, fractions of the whole mass
    shapes: np.ndarray = dataclasses.field(repr=False)  #: (n, num_nodes, 3) [1/sqrt(kg)], in the order of the nodes of `result`

    @property
    def result(self) -> Result:
        """The mesh, and a frame for each mode."""
        return Result(self.directory)


@dataclasses.dataclass(frozen=True)
class Fit:
    """What measurements say about numbers; SI units."""

    directory: str
    values: "dict[str, float]"  #: by parameter
    standard_errors: "dict[str, float]"  #: infinite where the measurements do not determine the parameter; nan: it was held, or is at a bound
    units: "dict[str, str]"
    converged: bool
    log: str = dataclasses.field(repr=False)  #: what the program printed


def modes(source: Path, *, number: int = 10, near: Optional[float] = None, unloaded: bool = False,
          overrides: "Optional[Mapping[str, Any]]" = None, output: Path = "out/modes", ranks: int = 1, petsc_options: Sequence[str] = (),
          timeout: Optional[float] = None) -> Modes:
    """The natural frequencies and mode shapes of an input file: the lowest, or those nearest to the frequency `near` [Hz]. With
    `time.method: static` they are those about the equilibrium under load, unless `unloaded`.

        m = pliant.modes("beam.yaml", number=4)
        m.frequency, m.shapes[0]

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    directory = os.path.abspath(path_of(output, "output"))
    at = ["--near", repr(number_of(near, "near, a frequency [Hz]"))] if near is not None else []
    arguments = ["--number", str(number), *at, *["--unloaded"] * bool(unloaded)]
    completed(["modes", input_file_of(source, "modes"), *arguments, *settings_of(overrides, output)], ranks, petsc_options, timeout)
    table = _table(directory, "modes.csv", True)
    mass = np.stack([table[f"effective_mass_{axis}"] for axis in "xyz"], axis=1)
    shapes = np.stack([frame["mode_shape"] for frame in Result(directory).frames])
    return Modes(directory, table["frequency"], table["eigenvalue"], table["growth_rate"], table["damping_ratio"], mass, shapes)


def sensitivity(source: Path, *, of: Sequence[str], to: Sequence[str], overrides: "Optional[Mapping[str, Any]]" = None,
                output: Path = "out", ranks: int = 1, petsc_options: Sequence[str] = (), timeout: Optional[float] = None) -> Sensitivity:
    """Runs an input file with the derivatives of columns of its history by numbers of the input, named as in `overrides`: a
    function with a Jacobian for scipy.optimize.least_squares, or a backward pass of PyTorch.

        s = pliant.sensitivity("beam.yaml", of=["tip_z"], to=["bodies.0.density"], overrides={"bodies.0.density": 900})
        s.values["tip_z"], s.jacobians["tip_z"]

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    of, to = names_of(of, "of", "tip_z"), names_of(to, "to", "bodies.0.density")
    if not of or not to:
        raise InputError("of and to are lists of names, such as of=['tip_z'], to=['bodies.0.density']; one of them is empty")
    directory = os.path.abspath(path_of(output, "output"))
    completed(["sensitivity", input_file_of(source, "sensitivity"), "--of", ",".join(of), "--to", ",".join(to), *settings_of(overrides, output)], ranks,
              petsc_options, timeout)
    with open(os.path.join(directory, "sensitivity.csv"), encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    table = dict(zip(header, np.array(rows, dtype=float).T))
    jacobians = {c: np.stack([table[f"d({c})/d({k})"] for k in to], axis=1) for c in of}
    with open(os.path.join(directory, "numbers.csv"), encoding="utf-8", newline="") as file:
        numbers = {row["number"]: float(row["value"]) for row in csv.DictReader(file)}
    return Sensitivity(directory, table["time"], numbers, {c: table[c] for c in of}, jacobians)


def gradient(source: Path, weights: "Mapping[str, Any]", *, to: Sequence[str] = (), fields: Sequence[str] = (),
             overrides: "Optional[Mapping[str, Any]]" = None, output: Path = "out", ranks: int = 1, petsc_options: Sequence[str] = (),
             timeout: Optional[float] = None, kept_steps: Optional[int] = None, _steps: Optional[int] = None) -> Gradient:
    """Runs an input file, and goes back through it: the derivatives of one number J, a function of columns of the history, by as many
    numbers and fields as there are. A vector-Jacobian product, as the backward pass of PyTorch and JAX wants it.

    `weights`: (n,) arrays, "time" [s] of steps, and dJ/d(column) at these times by column: positions and velocities of probes.
    `to`: numbers of the input, named as in `overrides`. `fields`: constants of which each cell has a value
    (bodies.0.elasticity.youngs_modulus, bodies.0.density), and mesh.nodes, initial.velocity and initial.displacement of each node.
    `kept_steps`: how many steps are kept in memory; the others are computed twice.

        g = pliant.gradient("beam.yaml", {"time": h.time, "tip_z": 2 * (h["tip_z"] - measured)}, to=["bodies.0.density"])
        g.numbers["bodies.0.density"]

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    to, fields = names_of(to, "to", "bodies.0.density"), names_of(fields, "fields", "bodies.0.density")
    if not (to or fields):
        raise InputError("to and fields are lists of names, such as to=['bodies.0.density']; one of them is needed")
    name, columns = input_file_of(source, "gradient"), _columns_of(weights)
    directory = os.path.abspath(path_of(output, "output"))
    file = os.path.join(directory, "weights.csv")
    try:
        os.makedirs(directory, exist_ok=True)
        with open(file, "w", encoding="utf-8", newline="") as stream:
            writer = csv.writer(stream, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows([repr(x) for x in row] for row in np.stack(list(columns.values()), axis=1).tolist())
    except OSError as error:
        raise PliantError(f"{error.filename}: {error.strerror}", FILE) from None
    arguments = ["--to", ",".join(to)] * bool(to) + ["--fields", ",".join(fields)] * bool(fields)
    arguments += ["--kept-steps", str(kept_steps)] * (kept_steps is not None)
    done = completed(["sensitivity", name, "--adjoint", file, *arguments, *settings_of(overrides, output)], ranks,
                     petsc_options, timeout)
    steps = int(re.search(r"over (\d+) steps", done.stdout)[1])
    if _steps not in (None, steps):
        raise PliantError(f"{source}: it takes {steps} steps, and the history has {_steps}: a run that was resumed with other steps "
                          "cannot be computed again; make one run of it")
    numbers = []
    if to:
        with open(os.path.join(directory, "gradient.csv"), encoding="utf-8", newline="") as stream:
            numbers = list(csv.DictReader(stream))
    of_nodes = [key for key in fields if key.startswith("initial.") or key == "mesh.nodes"]
    of_cells = [key for key in fields if key not in of_nodes]
    cells = _table(directory, "gradient_cells.csv", bool(of_cells))
    nodes = _table(directory, "gradient_nodes.csv", bool(of_nodes))
    slopes = {key: cells[f"derivative({key})"] for key in of_cells}
    slopes.update({key: np.stack([nodes[f"derivative({key})_{axis}"] for axis in "xyz"], axis=1) for key in of_nodes})
    return Gradient(directory, {row["number"]: float(row["derivative"]) for row in numbers},
                    {row["number"]: float(row["value"]) for row in numbers}, slopes, {key: cells[key] for key in of_cells},
                    cells["cell"].astype(np.int64), _positions(cells), _positions(nodes))


def _columns_of(weights: "Mapping[str, Any]") -> "dict[str, np.ndarray]":
    """Those of the file of weights."""
    if not isinstance(weights, Mapping) or not all(isinstance(name, str) for name in weights):
        raise InputError(f"weights: a dictionary of arrays is expected, with 'time' and columns of the history, not {short(weights)}")
    if "time" not in weights:
        raise InputError(f"weights: 'time' [s] is missing; there are {', '.join(weights) or 'none'}")
    columns = {name: array_of(column, f"weights['{name}']", (None,)) for name, column in weights.items()}
    for name, column in columns.items():
        if len(column) != len(columns["time"]):
            raise InputError(f"weights: '{name}' has {len(column)} values, and 'time' has {len(columns['time'])}: equally many are needed")
        require_finite(column, f"weights['{name}']")
    return columns


def _table(directory: str, name: str, exists: bool) -> "dict[str, np.ndarray]":
    if not exists:
        return {column: np.zeros(0) for column in ("cell", "x", "y", "z")}
    with open(os.path.join(directory, name), encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    return dict(zip(header, np.array(rows, dtype=float).T))


def _positions(table: "dict[str, np.ndarray]") -> np.ndarray:
    return np.stack([table[axis] for axis in "xyz"], axis=1)


def fit(file: Path, *, output: Optional[Path] = None, ranks: int = 1, timeout: Optional[float] = None) -> Fit:
    """Runs a fit file (docs/fitting.md). One that does not converge returns too, with `converged` False.

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    done = completed(["fit", path_of(file, "fit"), *settings_of(None, output)], ranks, (), timeout, accepted=(0, NOT_CONVERGED))
    line = next(line for line in reversed(done.stdout.splitlines()) if line.startswith("results: "))
    directory = os.path.abspath(line[len("results: "):].split("/report.html,")[0])
    with open(os.path.join(directory, "fit.csv"), encoding="utf-8", newline="") as table:
        rows = list(csv.DictReader(table))
    return Fit(directory, {row["parameter"]: float(row["value"]) for row in rows},
               {row["parameter"]: float(row["standard_error"] or "nan") for row in rows}, {row["parameter"]: row["unit"] for row in rows},
               done.returncode == 0, done.stdout)
