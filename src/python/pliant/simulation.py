"""A simulation as an object in this process: steps one by one, with loads that change, on any number of ranks."""
import atexit
import contextlib
import difflib
import importlib
import importlib.machinery
import importlib.util
import logging
import os
import pathlib
import sys
from collections.abc import Iterator, Mapping
from types import ModuleType, TracebackType
from typing import Any, Optional, Union

import numpy as np

from .checks import array_of, number_of, path_of, require_finite, short
from .error import InputError, MissingError, PliantError, SolveError
from .runs import Path, changes_of, content_of, program

log = logging.getLogger("pliant")

#: How long a rank that ends with an exception waits for the others before it ends them [s].
PATIENCE = 5.0

_NOTHING = object()  # where no value is given

_module: Optional[ModuleType] = None
_cores: "list[Any]" = []  # of simulations that are not closed; the same order on every rank


def _load() -> ModuleType:
    """The compiled module: on sys.path, next to this package as installed or built, or of the program's build."""
    with contextlib.suppress(ModuleNotFoundError):
        return importlib.import_module("_pliant")
    places = [folder / "build/lib/python3/dist-packages" for folder in pathlib.Path(__file__).resolve().parents]
    with contextlib.suppress(PliantError):
        places.insert(0, pathlib.Path(program()).resolve().parent.parent / "lib/python3/dist-packages")
    for place in places:
        for suffix in importlib.machinery.EXTENSION_SUFFIXES:
            spec = importlib.util.spec_from_file_location("_pliant", place / f"_pliant{suffix}")
            if spec is not None and spec.loader is not None and (place / f"_pliant{suffix}").is_file():
                module = importlib.util.module_from_spec(spec)
                spec.loader.exec_module(module)
                sys.modules["_pliant"] = module
                return module
    raise PliantError("pliant.Simulation needs the module _pliant, which was not built for this Python "
                      f"({sys.version_info.major}.{sys.version_info.minor}); it needs pybind11-dev and python3-dev when Pliant is built")


def _started() -> ModuleType:
    """The module with MPI and PETSc running; both end with Python, unless somebody else has started them."""
    global _module
    if _module is not None:
        return _module
    module = _load()
    with _failures(module):
        module.start()
    atexit.register(_finish, module)
    if module.num_ranks() > 1:
        _end_together(module)
    kernels = module.better_blas_kernels()
    if kernels:
        log.warning("OpenBLAS computes with kernels for old processors; factorizations are faster if Python is started with "
                    "OPENBLAS_CORETYPE=%s", kernels)
    _module = module
    return module


def _finish(module: ModuleType) -> None:
    global _module
    for core in _cores:
        core.close()
    _cores.clear()
    _module = None
    module.finish()


def _end_together(module: ModuleType) -> None:
    """An exception that ends Python on this rank alone would leave the others waiting for it."""
    before = sys.excepthook

    def hook(kind: "type[BaseException]", error: BaseException, traceback: Optional[TracebackType]) -> None:
        before(kind, error, traceback)
        sys.stdout.flush()
        sys.stderr.flush()
        if not module.all_ranks_arrive(PATIENCE):
            module.abort(1)

    sys.excepthook = hook


@contextlib.contextmanager
def _failures(module: ModuleType) -> "Iterator[None]":
    """Turns failures of the module into the exceptions of this package."""
    try:
        yield
    except module.Failure as failure:
        code, message = failure.args
        if code == 2:
            raise InputError(message) from None
        if code == 3:
            raise SolveError(message) from None
        raise PliantError(message, code) from None


class SavedState:
    """A state of a simulation, from `Simulation.save`."""

    def __init__(self, token: Any, time: float, step: int) -> None:
        self._token = token
        self.time = time  #: [s]; of a static problem the load factor, or the length of its path
        self.step = step

    def __repr__(self) -> str:
        return f"SavedState(step {self.step}, t = {self.time:.6g})"


class NamedSurface:
    """A surface of the mesh (physical group): its n nodes, with arrays (n, 3) in the order of `nodes`, the same on every rank.

    Everything but `name` and `nodes` is collective.
    """

    def __init__(self, simulation: "Simulation", name: str) -> None:
        if not isinstance(name, str):
            raise MissingError(f"the name of a surface is expected, not {short(name)}; there are {', '.join(simulation.surfaces) or 'none'}")
        self._simulation = simulation
        self.name = name
        with simulation._calls() as core:
            self.nodes = np.array(core.nodes_on(name), dtype=np.int64)  #: numbers of its nodes, ascending: rows of Simulation.displacement

    def __repr__(self) -> str:
        return f"NamedSurface({self.name!r}: {len(self.nodes)} nodes)"

    def _of(self, what: str) -> np.ndarray:
        with self._simulation._calls() as core:
            return core.on_surface(self.name, what)

    @property
    def coordinates(self) -> np.ndarray:
        """Reference positions [m]."""
        return self._of("coordinates")

    @property
    def displacement(self) -> np.ndarray:
        """[m]"""
        return self._of("displacement")

    @property
    def velocity(self) -> np.ndarray:
        """[m/s]"""
        return self._of("velocity")

    @property
    def reaction(self) -> np.ndarray:
        """Forces of constraints on the body at the end of the last step [N]; 0 in directions that no constraint holds, and before the
        first step."""
        return self._of("reaction")

    def apply_forces(self, forces: Any) -> None:
        """Forces on the nodes from the next step on, until they are replaced [N]; in addition to the loads of the input and to forces on
        other surfaces. A static problem multiplies them by its load factor."""
        values = self._checked(forces, "forces")
        with self._simulation._calls() as core:
            core.apply_forces(self.name, values)

    def move(self, displacement: Any) -> None:
        """Displacements of the nodes at the end of the next step, reached at constant velocity, and kept until they are replaced [m]. If
        that step is shortened, the motion continues until the time `time + next_dt` of now: `run(until=...)` takes the steps until then. A
        static problem multiplies them by its load factor. A constraint of the input must hold the surface in all directions: `displacement: [0, 0, 0]`."""
        values = self._checked(displacement, "displacement")
        with self._simulation._calls() as core:
            core.move(self.name, values)

    def _checked(self, values: Any, name: str) -> np.ndarray:
        what = f"{name} on surface '{self.name}'"
        array = array_of(values, what, (len(self.nodes), 3))
        require_finite(array, what)
        return array


class Simulation:
    """A simulation that this process drives, step by step:

        with pliant.Simulation("input/beam_small.yaml", {"time.end": "50 ms"}) as sim:
            while not sim.done:
                sim.advance()
            print(sim.get("tip_z"))

    On several ranks (mpirun python ...) every rank makes the same calls with the same values. All numbers are in SI units.
    """

    def __init__(self, source: "Union[Path, Mapping[str, Any]]", set: "Optional[Mapping[str, Any]]" = None, *, comm: Any = None,
                 output: Optional[Path] = None) -> None:
        """`source`: an input file, its text, or its content as a dictionary, as in `pliant.run`. `set`: values by key, as `--set` of the
        program. `comm`: a communicator of mpi4py; default: all ranks. `output`: a directory for history and frames, as `pliant run`
        writes them; default: no files.

        InputError with the program's message where the input is wrong. Collective."""
        self._core: Any = None
        content = content_of(source)
        name = "input" if content is not None else os.fspath(source)  # type: ignore[arg-type]
        changes = changes_of(set)
        if output is not None:
            changes.append(("output.directory", os.path.abspath(path_of(output, "output"))))
        if comm is not None and not hasattr(comm, "py2f"):
            raise InputError(f"comm: a communicator of mpi4py is expected, such as MPI.COMM_WORLD, not {short(comm)}")
        handle = None if comm is None else comm.py2f()
        self._module = _started()
        with _failures(self._module):
            self._core = self._module.Simulation(content, name, changes, handle, output is not None)
        _cores.append(self._core)
        if self._core.rank == 0:
            for severity, line in self._core.diagnostics:
                log.log(logging.WARNING if severity else logging.INFO, "%s", line)

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, kind: "Optional[type[BaseException]]", *_: Any) -> None:
        # What ends this rank alone must not wait here for the others.
        if kind is None or self._module.num_ranks() == 1:
            self.close()

    def __del__(self) -> None:
        # Not on several ranks, where it happens at different times.
        if getattr(self, "_core", None) is not None and _module is not None and _module.num_ranks() == 1:
            self.close()

    def __repr__(self) -> str:
        if self._core is None:
            return "Simulation(closed)"
        return f"Simulation({self._core.title or 'untitled'!r}, step {self.step}, t = {self.time:.6g})"

    def close(self) -> None:
        """Releases the memory. Python's end does it too; on several ranks nothing else does. Collective."""
        if self._core is not None and self._core in _cores:
            _cores.remove(self._core)
            self._core.close()
        self._core = None

    @contextlib.contextmanager
    def _calls(self) -> "Iterator[Any]":
        if self._core is None:
            raise PliantError("the simulation is closed")
        with _failures(self._module):
            yield self._core

    def _ask(self, name: str) -> Any:
        with self._calls() as core:
            return getattr(core, name)

    @property
    def time(self) -> float:
        """At the end of the last step [s]; of a static problem the load factor, or the length of its path."""
        return self._ask("time")

    @property
    def dt(self) -> float:
        """Length of the last step [s]; before the first, of the one that is tried first."""
        return self._ask("dt") if self.step > 0 else self._ask("next_dt")

    @property
    def next_dt(self) -> float:
        """Length of the step that `advance` tries first [s]; 0 at the end."""
        return self._ask("next_dt")

    @property
    def step(self) -> int:
        """Number of steps completed."""
        return self._ask("step")

    @property
    def done(self) -> bool:
        """Whether the end of the input, `time.end`, is reached."""
        return self._ask("finished")

    def advance(self) -> None:
        """Completes one step; with adaptive steps the one that its error allows.

        SolveError if it cannot be solved: the simulation is then as it was before. Collective."""
        if self.done:
            raise PliantError(f"the simulation has reached its end, {self._ask('end'):g} s; a later one: set={{'time.end': ...}} when it is made")
        with self._calls() as core:
            for warning in core.advance():
                if core.rank == 0:
                    log.warning("%s", warning)

    def run(self, until: Optional[float] = None) -> None:
        """Completes steps up to the first that ends at `until` or later [s], or to the end. Collective."""
        if until is not None and until != np.inf:
            until = number_of(until, "until, a time [s]")
        while not self.done and (until is None or self.time < until * (1 - 1e-9)):
            self.advance()

    def set(self, key: "Union[str, Mapping[str, Any]]", value: Any = _NOTHING) -> None:
        """Replaces a value of the input, or several by key, from the next step on: a number or a formula, as in the input. Keys are those
        of `--set`: "cavities.chamber.pressure", "loads.0.traction.2".

        Loads, the pressure of cavities, their amount of gas and added volume of liquid, prescribed displacements, motions and motors of
        joints, tension and pull of tendons, the motion of obstacles, active stress and shortening, expansion, `time.step` and
        `time.min_step` can change; InputError, a ValueError, for everything else. A number that prescribes a motion is reached at the end
        of the next step as it is planned (`move`), at constant velocity; where it replaces a formula of the position, and a formula, count as they are.
        Collective."""
        if isinstance(key, Mapping) != (value is _NOTHING):
            raise InputError("set takes a key and a value, such as set('loads.0.gravity', [0, 0, -1]), or a dictionary of them")
        if not isinstance(key, (str, Mapping)):
            raise InputError(f"a key of the input is a text, such as 'time.step' or 'loads.0.gravity', not {short(key)}")
        changes = changes_of(key if isinstance(key, Mapping) else {key: value})
        for changed, text in changes:
            if text.strip() in ("", "~", "null"):
                raise InputError(f"set {changed}: a value is expected, not nothing; what is not to act any more is set to 0")
        with self._calls() as core:
            core.set(changes)

    @property
    def columns(self) -> "list[str]":
        """Names of the columns of the history (docs/output.md)."""
        return self._ask("columns")

    @property
    def row(self) -> "dict[str, float]":
        """The history at the present state, by column."""
        return dict(zip(self.columns, self._ask("row").tolist()))

    def get(self, column: str) -> float:
        """One column of it. InputError if there is none of this name."""
        columns = self.columns
        if column not in columns:
            near = difflib.get_close_matches(str(column), columns, 3) or columns
            raise MissingError(f"the history has no column '{column}'; there are {', '.join(near)}")
        return float(self._ask("row")[columns.index(column)])

    def of_nodes(self, what: str, *, own: bool = False) -> np.ndarray:
        """`coordinates` (reference), `displacement` [m] or `velocity` [m/s]: (nodes, 3) in the order of result.h5 of a run on as many
        ranks; of all nodes, on every rank (collective), or of those that this rank owns, `own_nodes`."""
        if what not in ("coordinates", "displacement", "velocity"):
            raise MissingError(f"'{what}' is not a field of nodes here; there are coordinates, displacement, velocity")
        with self._calls() as core:
            return core.of_nodes(what, bool(own))

    @property
    def own_nodes(self) -> range:
        """Numbers of the nodes that this rank owns."""
        return range(*self._ask("own_nodes"))

    @property
    def coordinates(self) -> np.ndarray:
        """Reference positions of all nodes (nodes, 3) [m]. Collective."""
        return self.of_nodes("coordinates")

    @property
    def displacement(self) -> np.ndarray:
        """Of all nodes (nodes, 3) [m]. Collective."""
        return self.of_nodes("displacement")

    @property
    def velocity(self) -> np.ndarray:
        """Of all nodes (nodes, 3) [m/s]. Collective."""
        return self.of_nodes("velocity")

    @property
    def surfaces(self) -> "list[str]":
        """Names of the surfaces of the mesh, or their numbers."""
        return self._ask("surfaces")

    def surface(self, name: str) -> NamedSurface:
        """One of them. InputError if there is none of this name."""
        return NamedSurface(self, name)

    def save(self) -> SavedState:
        """The state, with all that was set. From here on the steps are the same to the last bit as after restoring it. Collective."""
        with self._calls() as core:
            return SavedState(core.save(), self.time, self.step)

    def restore(self, state: SavedState) -> None:
        """Returns to a state of this simulation; files lose what was written after it. Collective."""
        if not isinstance(state, SavedState):
            raise InputError(f"restore takes what save returned, not {state!r}")
        with self._calls() as core:
            core.restore(state._token)

    def write_frame(self) -> None:
        """Adds the present state to the result in `output`, besides the frames of `output.every`. Collective."""
        with self._calls() as core:
            core.write_frame()
