"""What `pliant render`, `pliant plot` and `pliant convert` start, as a script: python3 start.py COMMAND ARGUMENT [OPTION ...]

Exit codes are those of the program: 0 done, 2 an error that the user can correct, a module that is missing among them, 4 a file that
could not be read or written.
"""
import importlib
import pathlib
import signal
import sys

MODULES = {"render": "pliant.pictures.render", "plot": "pliant.pictures.plot", "convert": "pliant.convert.convert"}
# The packages of Debian that have the modules.
PACKAGES = {"h5py": "python3-h5py", "matplotlib": "python3-matplotlib", "numpy": "python3-numpy", "PIL": "python3-pil",
            "vtkmodules": "python3-vtk9", "yaml": "python3-yaml"}


def main(command, arguments):
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # ends it without a traceback
    program = f"pliant {command}"
    try:
        return importlib.import_module(MODULES[command]).main(arguments, program)
    except ImportError as error:
        module = (error.name or "").partition(".")[0]
        if module in PACKAGES:
            print(f"{program}: {sys.executable} has no module '{module}': install the package {PACKAGES[module]}, or name another Python in "
                  "the environment variable PLIANT_PYTHON", file=sys.stderr)
        else:
            print(f"{program}: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])
    sys.exit(main(sys.argv[1], sys.argv[2:]))
