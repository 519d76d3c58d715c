"""Starts the program and waits for it."""
import dataclasses
import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
import yaml

from . import notebook
from .checkpoint import Checkpoint
from .checks import path_of, positive_of, short
from .error import FILE, InputError, PliantError
from .files import refuse_input, results_elsewhere
from .history import History
from .result import Result

if TYPE_CHECKING:
    from .studies import Gradient

Path = Union[str, "os.PathLike[str]"]


@dataclasses.dataclass(frozen=True)
class Run:
    """A run, and where it lies: what `run` and `resume` return; `Run(directory)` is an earlier one, without its log."""

    directory: str
    log: Optional[str] = dataclasses.field(default=None, repr=False)  #: what the program printed

    def __post_init__(self) -> None:
        directory = path_of(self.directory, "Run")
        history = os.path.join(directory, "history.csv")
        if self.log is None and not os.path.isfile(history):
            refuse_input(directory)
            raise PliantError(f"no run: {history} does not exist{results_elsewhere(directory, 'history.csv')}", FILE)

    def __repr__(self) -> str:
        return notebook.run_in_a_line(self)

    def _repr_html_(self) -> str:
        """For notebooks: how it ended, energies, the last values of probes, its files, and small pictures where matplotlib is
        installed."""
        return notebook.run_as_html(self)

    @property
    def warnings(self) -> "list[str]":
        """What the program has warned of; the command line shows it in lines that begin with `warning:`."""
        return list(self.summary.get("warnings", []))

    @property
    def notes(self) -> "list[str]":
        """What the program has noted."""
        return list(self.summary.get("notes", []))

    @functools.cached_property
    def result(self) -> Result:
        """The frames."""
        return Result(self.directory)

    @functools.cached_property
    def history(self) -> History:
        """A row per step."""
        return History(self.directory)

    @functools.cached_property
    def summary(self) -> "dict[str, Any]":
        """How it ended, where the time went, what the solver did (summary.json)."""
        name = os.path.join(path_of(self.directory, "the directory of a run"), "summary.json")
        try:
            with open(name, encoding="utf-8") as file:
                return json.load(file)
        except OSError as error:
            raise PliantError(f"{name}: {error.strerror}; a run writes it at its end", FILE) from None
        except ValueError as error:
            raise PliantError(f"{name} is not the summary of a run: {error}", FILE) from None

    def gradient(self, weights: "Mapping[str, Any]", to: Sequence[str] = (), *, fields: Sequence[str] = (), ranks: int = 1,
                 timeout: Optional[float] = None, kept_steps: Optional[int] = None) -> "Gradient":
        """The derivatives of a number J by numbers and fields of the input. `weights`: (n,) arrays of dJ/d(column) by column, one
        number for each row of the history. The run is computed again, into `gradient` in its directory; everything else as in
        `pliant.gradient`."""
        from .studies import gradient
        if not isinstance(weights, Mapping):
            raise InputError(f"weights: a dictionary of arrays is expected, such as {{'tip_z': w}}, not {short(weights)}")
        return gradient(os.path.join(self.directory, "run.yaml"), {"time": self.history.time, **weights}, to=to, fields=fields,
                        output=os.path.join(self.directory, "gradient"), ranks=ranks, timeout=timeout, kept_steps=kept_steps,
                        _steps=int(self.history["step"][-1]))

    @property
    def checkpoint(self) -> Checkpoint:
        """The newest one."""
        return Checkpoint(self.directory)


def program() -> str:
    """The pliant to start: that of the environment variable PLIANT, else that on PATH, else the one next to this package, as built
    or installed."""
    named = os.environ.get("PLIANT")
    if named:
        return named
    on_path = shutil.which("pliant")
    if on_path:
        return on_path
    for folder in pathlib.Path(__file__).resolve().parents:
        for place in ("bin/pliant", "build/bin/pliant"):
            if os.access(folder / place, os.X_OK) and (folder / place).is_file():
                return str(folder / place)
    raise PliantError("the program pliant was not found; put it on PATH, or name it in the environment variable PLIANT")


# What launchers of MPI (Open MPI's mpirun and its PMIx, MPICH's, srun) say to the processes that they start: with it a program that such a
# process starts would take the place of that process in its job, and fail in MPI_Init, or wait for it.
_OF_LAUNCHERS = re.compile(r"(PMIX?|PRTE|HYDI?|MPIEXEC|MPI_LOCAL\w+|OMPI_COMM_WORLD|OMPI_MCA_(orte|ess|prte|pmix))(_|$)|"
                           r"OMPI_(COMMAND|ARGV|UNIVERSE_SIZE|NUM_APP_CTX|FIRST_RANKS|APP_CTX_NUM_PROCS|FILE_LOCATION|MCA_initial_wdir)$")


def _environment() -> "dict[str, str]":
    """That of the program, which starts a job of its own even if mpirun has started this process."""
    is_launched = any(name in os.environ for name in ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"))
    own = {name: value for name, value in os.environ.items() if not (is_launched and _OF_LAUNCHERS.match(name))}
    return {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **own}


class _Dumper(yaml.SafeDumper):
    """YAML of what Python's users put into dictionaries."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_undefined(self, data: Any) -> Any:
        if isinstance(data, np.generic):
            return self.represent_data(data.item())
        if isinstance(data, np.ndarray):
            return self.represent_data(data.tolist())
        if isinstance(data, Mapping):
            return self.represent_dict(dict(data))
        if isinstance(data, os.PathLike):
            return self.represent_str(os.fspath(data))
        hint = "; a formula is a text, such as 'sin(t)'" if callable(data) else ""
        raise InputError(f"an input cannot hold {data!r}, a {type(data).__name__}{hint}")


_Dumper.add_multi_representer(object, _Dumper.represent_undefined)
_Dumper.add_representer(set, _Dumper.represent_undefined)


def run(source: "Union[Path, Mapping[str, Any]]", overrides: "Optional[Mapping[str, Any]]" = None, *, output: Optional[Path] = None,
        ranks: int = 1, go_on: bool = False, petsc_options: Sequence[str] = (), timeout: Optional[float] = None) -> Run:
    """Runs a simulation to its end.

    `source`: an input file, its text, or its content as a dictionary; files that a text or a dictionary names are relative to
    the current directory. `overrides`: values by key, {"time.step": "5 ms", "loads.0.gravity": [0, 0, -1.6]}. `output`: the
    directory of the results, instead of the input's. `go_on`: a run of this input in that directory resumes from its newest
    checkpoint, or stays as it is if it is finished. `timeout` [s].

    PliantError with the program's message if it fails; subprocess.TimeoutExpired if it takes too long.
    """
    settings = settings_of(overrides, output) + ["--continue"] * bool(go_on)
    content = content_of(source)
    if content is None:
        return _finished(["run", os.fspath(source), *settings], ranks, petsc_options, timeout)  # type: ignore[arg-type]
    try:
        handle, name = tempfile.mkstemp(prefix=".pliant-", suffix=".yaml", dir=os.getcwd())
    except OSError as error:
        raise PliantError(f"the input cannot be written into the current directory {os.getcwd()}: {error.strerror}", FILE) from None
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(content)
        if output is None and not _names_directory(content):
            settings += ["--output", os.path.abspath("out")]
        return _finished(["run", name, *settings], ranks, petsc_options, timeout)
    except PliantError as error:
        if name not in str(error):
            raise
        raise PliantError(str(error).replace(name, "input"), error.code) from None
    finally:
        os.unlink(name)


def _names_directory(content: str) -> bool:
    """Does this input say where its results go? What is wrong with it is for the program to say."""
    try:
        given = yaml.safe_load(content)
    except yaml.YAMLError:
        return False
    output = given.get("output") if isinstance(given, Mapping) else None
    return isinstance(output, Mapping) and "directory" in output


def resume(checkpoint: Path, overrides: "Optional[Mapping[str, Any]]" = None, *, output: Optional[Path] = None, ranks: int = 1,
           petsc_options: Sequence[str] = (), timeout: Optional[float] = None) -> Run:
    """Resumes from a checkpoint, or from the newest one in a directory; otherwise as `run`."""
    return _finished(["resume", path_of(checkpoint, "checkpoint"), *settings_of(overrides, output)], ranks, petsc_options, timeout)


def content_of(source: "Union[Path, Mapping[str, Any]]") -> Optional[str]:
    """The text of an input that is given as such, or as a dictionary; None for the name of a file."""
    if not isinstance(source, (Mapping, str, os.PathLike)):
        raise InputError(f"an input is a file, its text, or a dictionary, not {short(source)}")
    if isinstance(source, Mapping):
        return yaml.dump(source, Dumper=_Dumper, sort_keys=False)
    return os.fspath(source) if "\n" in os.fspath(source) else None


def settings_of(overrides: "Optional[Mapping[str, Any]]", output: Optional[Path]) -> "list[str]":
    """The options of the command line."""
    settings = []
    for key, value in changes_of(overrides):
        settings += ["--set", f"{key}={value}"]
    if output is not None:
        settings += ["--output", os.path.abspath(path_of(output, "output"))]
    return settings


def changes_of(overrides: "Optional[Mapping[str, Any]]") -> "list[tuple[str, str]]":
    """Keys of the input and what is put there, in YAML."""
    if overrides is not None and not isinstance(overrides, Mapping):
        raise InputError(f"values of the input: a dictionary is expected, such as {{'time.step': '5 ms'}}, not {short(overrides)}")
    for key, value in (overrides or {}).items():
        if not isinstance(key, str):
            raise InputError(f"a key of the input is a text, such as 'time.step' or 'loads.0.gravity', not {short(key)}")
        if isinstance(value, (float, np.floating)) and not np.isfinite(value):
            raise InputError(f"set {key}: a finite number is expected, not {value}")
    return [(key, _flow(value)) for key, value in (overrides or {}).items()]


def _flow(value: Any) -> str:
    """YAML in one line."""
    if isinstance(value, str):
        return value
    text = yaml.dump(value, Dumper=_Dumper, default_flow_style=True, width=1 << 30).strip()
    return text[: -len("\n...")] if text.endswith("\n...") else text


def completed(arguments: "list[str]", ranks: int, petsc_options: Sequence[str], timeout: Optional[float],
              accepted: "tuple[int, ...]" = (0,)) -> "subprocess.CompletedProcess[str]":
    """Starts the program and waits for its end; PliantError unless the exit code is one of those accepted."""
    if not isinstance(ranks, (int, np.integer)) or ranks < 1:
        raise InputError(f"ranks={ranks!r}: a whole number from 1 is needed")
    if timeout is not None:
        timeout = positive_of(timeout, "timeout, a time [s]")
    command = [program(), *arguments, *_petsc_options(petsc_options)]
    if ranks > 1:
        command = ["mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), *command]
    try:
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL, env=_environment(), timeout=timeout, check=False)
    except OSError as error:
        raise PliantError(f"{command[0]} could not be started: {error.strerror}", FILE) from None
    if done.returncode not in accepted:
        raise PliantError(done.stderr.strip() or f"pliant ended with {done.returncode}", done.returncode)
    return done


def _petsc_options(given: Sequence[str]) -> "list[str]":
    """As the command line has them."""
    is_list = isinstance(given, Sequence) and not isinstance(given, (str, bytes))
    if not is_list or not all(isinstance(word, (str, int, float)) for word in given):
        raise InputError(f"petsc_options: a list of words is expected, such as ['-ksp_type', 'cg'], not {short(given)}")
    return ["--", *map(str, given)] if given else []


def _finished(arguments: "list[str]", ranks: int, petsc_options: Sequence[str], timeout: Optional[float]) -> Run:
    done = completed(arguments, ranks, petsc_options, timeout)
    # The last line that it prints of the results names them: "results: DIRECTORY/result.xdmf, DIRECTORY/history.csv".
    line = next(line for line in reversed(done.stdout.splitlines()) if line.startswith("results: "))
    directory = line[len("results: "):].split("/result.xdmf,")[0]
    return Run(os.path.abspath(directory), done.stdout)
