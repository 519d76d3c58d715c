"""checkpoint-*.h5: the state from which a run is resumed."""
import os
from typing import Any, Union

import h5py
import numpy as np

from .checks import path_of
from .error import FILE, PliantError
from .files import opened, text


class Checkpoint:
    """What a checkpoint holds, read when it is asked for. `pliant info` also checks that it is whole."""

    def __init__(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """`path`: a checkpoint, or a directory: then the newest one in it."""
        self.file = self._find(path_of(path, "Checkpoint"))
        self._h5 = opened(self.file)
        attributes = self._h5.attrs
        if text(attributes.get("format", "")) != "pliant-checkpoint":
            raise PliantError(f"{self.file} is not a checkpoint of Pliant", FILE)
        self.step = int(attributes["step"])
        self.time = float(attributes["time"])  #: [s]; of a static run the load factor, or the length of its path
        self.title = text(attributes["title"])
        self.ranks = int(attributes["ranks"])  #: that wrote it
        self.program = text(attributes["program"])
        self.petsc_options = text(attributes["petsc_options"])
        self.input = text(self._h5["input"][()])  #: as understood, YAML

    @staticmethod
    def _find(path: str) -> str:
        if not os.path.isdir(path):
            return path
        names = [name for name in os.listdir(path) if name.startswith("checkpoint-") and name.endswith(".h5")]
        if not names:
            raise PliantError(f"no checkpoint in {path}", FILE)
        return os.path.join(path, max(names, key=lambda name: (len(name), name)))

    @property
    def state(self) -> "dict[str, np.ndarray]":
        """All that was kept, by name: numbers as arrays of a few, vectors as rows x components. Nodes have an order of their
        own, which does not depend on the ranks, and is not that of a result."""
        group = self._h5["state"]
        state: "dict[str, np.ndarray]" = {name: np.atleast_1d(value) for name, value in group.attrs.items()}

        def add(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset):
                state[name] = item[()]

        group.visititems(add)
        return state

    def close(self) -> None:
        self._h5.close()

    def __enter__(self) -> "Checkpoint":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
