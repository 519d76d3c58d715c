"""What `pliant render`, `pliant plot` and `pliant convert` start, as a script: python3 start.py COMMAND ARGUMENT [OPTION ...]

Exit codes are those of the program: 0 done, 2 an error that the user can correct, packages that are missing among them, 4 a file that
could not be read or written.
"""
import importlib
import os
import pathlib
import shutil
import signal
import sys

MODULES = {"render": "pliant.pictures.render", "plot": "pliant.pictures.plot", "convert": "pliant.convert.convert"}
# The packages of Debian that have the modules and the programs.
PACKAGES = {"h5py": "python3-h5py", "numpy": "python3-numpy", "yaml": "python3-yaml", "PIL": "python3-pil", "matplotlib": "python3-matplotlib",
            "vtkmodules": "python3-vtk9", "Xvfb": "xvfb", "ffmpeg": "ffmpeg"}
PROGRAMS = ("Xvfb", "ffmpeg")
PICTURE_NEEDS = ("h5py", "numpy", "yaml", "PIL", "matplotlib")


def needs(command, arguments):
    """Names of PACKAGES that the command takes with these arguments."""
    if command == "convert":
        return ["h5py", "numpy", "yaml"]
    if command == "plot":
        return [*PICTURE_NEEDS]
    endings = [word.lower().rpartition("=")[2] for word in arguments]
    if any(word == "glb" or word.endswith(".glb") for word in endings):
        return [*PICTURE_NEEDS]
    screen = [] if os.environ.get("DISPLAY") else ["Xvfb"]
    return [*PICTURE_NEEDS, "vtkmodules", *screen, *(["ffmpeg"] if "mp4" in endings else [])]


def is_missing(name):
    if name in PROGRAMS:
        return shutil.which(name) is None
    try:
        importlib.import_module(name)
    except ImportError:
        return True
    return False


def missing(names):
    """What to do about those of the names that are missing, in one line; empty if none is."""
    lacking = [name for name in names if is_missing(name)]
    if not lacking:
        return ""
    modules = ", ".join(f"'{name}'" for name in lacking if name not in PROGRAMS)
    programs = ", ".join(f"'{name}'" for name in lacking if name in PROGRAMS)
    what = ([f"{sys.executable} lacks {modules}"] if modules else []) + ([f"there is no program {programs}"] if programs else [])
    other = "; or name another Python in the environment variable PLIANT_PYTHON" if modules else ""
    return f"{', and '.join(what)}: apt-get install {' '.join(PACKAGES[name] for name in lacking)}{other}"


def main(command, arguments):
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # ends it without a traceback
    program = f"pliant {command}"
    try:
        return importlib.import_module(MODULES[command]).main(arguments, program)
    except ImportError as error:
        print(f"{program}: {missing(needs(command, arguments)) or error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.path[0] = str(pathlib.Path(__file__).resolve().parents[1])
    sys.exit(main(sys.argv[1], sys.argv[2:]))
