"""HDF5 files that a run may just be writing to."""
import glob
import os
import time
from collections.abc import Callable
from typing import Any

import h5py

from .error import FILE, InputError, PliantError


def opened(file: str, check: "Callable[[h5py.File], Any]" = lambda _: None) -> h5py.File:
    """Opens a file for reading, without locks, and reads what `check` does. A run that is just adding to it may be met between two
    of its writes; a moment later all is well."""
    if not os.path.isfile(file):
        raise PliantError(f"{file} does not exist", FILE)
    if not h5py.is_hdf5(file):
        raise PliantError(f"{file} is not an HDF5 file", FILE)
    reason = ""
    for attempt in range(5):
        h5 = None
        try:
            h5 = h5py.File(file, "r")
            check(h5)
            return h5
        except (OSError, KeyError, RuntimeError) as error:
            if h5 is not None:
                h5.close()
            reason = str(error)
            time.sleep(0.2 * attempt)
    raise PliantError(f"{file} cannot be read: {reason}", FILE)


def refuse_input(path: str) -> None:
    """InputError for the input of a run where its results are expected."""
    name, ending = os.path.splitext(os.path.basename(path))
    if os.path.isfile(os.path.join(os.path.dirname(path), "state.h5")) and name == "report" and not os.path.isdir(path):
        raise InputError(f"{path} is the text of a post-mortem; its pictures are those of the directory {os.path.dirname(path) or '.'}")
    if ending.lower() in (".yaml", ".yml") and not os.path.isdir(path):
        raise InputError(f"{path} is an input, not a result: give the directory of its results, such as out/{name}")


def results_elsewhere(path: str, name: str) -> str:
    """Where files of this name are near `path`, up to two directories below it or one above; else empty."""
    found = sorted(os.path.normpath(os.path.dirname(file)) for depth in ("*", "*/*") for file in glob.iglob(os.path.join(glob.escape(path), depth, name)))
    if found:
        return f"; there are results in {', '.join(found[:5] + ['...'] * (len(found) > 5))}"
    above = os.path.dirname(os.path.abspath(path))
    return f"; there is one in {os.path.relpath(above)}" if os.path.isfile(os.path.join(above, name)) else ""


def text(value: Any) -> str:
    """A text attribute."""
    return value.decode() if isinstance(value, bytes) else str(value)
