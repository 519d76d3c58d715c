"""What pip calls to make a wheel (PEP 517): CMake builds and installs Pliant into a folder, which becomes the wheel. Only Python's own modules
are needed.

The wheel has the installed tree as it is (bin/pliant, lib/pliant, lib/python3/dist-packages, share/pliant), relative to the prefix of the
environment, and the package with its compiled module where Python looks. The libraries that the program needs are not in it.

Settings: `pip install . --config-settings=KEY=VALUE`
  build-dir   folder of an existing or new build; default: build-wheel
  native      ON: for the instruction set of this machine; default OFF, for any of its architecture
"""
import base64
import csv
import hashlib
import io
import os
import pathlib
import re
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
PACKAGES = "lib/python3/dist-packages"
# The time of every file in the archives, so that the same sources give the same wheel.
FIRST_TIME = (1980, 1, 1, 0, 0, 0)


def version():
    return re.search(r"project\(pliant VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")).group(1)


def metadata():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = ["Metadata-Version: 2.1", f"Name: {project['name']}", f"Version: {version()}", f"Summary: {project['description']}",
             f"Requires-Python: {project['requires-python']}", *(f"Requires-Dist: {name}" for name in project["dependencies"]),
             "Description-Content-Type: text/markdown", "", (ROOT / project["readme"]).read_text(encoding="utf-8")]
    return "\n".join(lines)


def tag():
    """This interpreter, its binary interface and this platform, as pip has them."""
    interpreter = f"cp{sys.version_info.major}{sys.version_info.minor}"
    return f"{interpreter}-{interpreter}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def run(*command):
    subprocess.run([str(word) for word in command], check=True, stdout=sys.stderr)


def install(prefix, settings):
    """Builds, and installs the program into a folder."""
    build = pathlib.Path(settings.get("build-dir", ROOT / "build-wheel"))
    if not (build / "CMakeCache.txt").exists():
        run("cmake", "--preset", "package", "-S", ROOT, "-B", build, f"-DPLIANT_NATIVE={settings.get('native', 'OFF')}",
            f"-DPython3_EXECUTABLE={sys.executable}")
    run("cmake", "--build", build, "--target", "pliant_program", "pliant_gmsh", *(["pliant_python"] if has_module(build) else []))
    run("cmake", "--install", build, "--prefix", prefix, "--component", "program", "--strip")


def has_module(build):
    """Whether the build makes the module of Python: without pybind11 there is a program without pliant.Simulation."""
    return "pliant_python" in subprocess.run(["cmake", "--build", str(build), "--target", "help"], check=True, capture_output=True, text=True).stdout


def members(prefix, name):
    """(place in the wheel, file): the tree as data of the environment, and the package as Python finds it."""
    for file in sorted(path for path in prefix.rglob("*") if path.is_file()):
        place = file.relative_to(prefix).as_posix()
        if not place.endswith(".so") or not place.startswith(PACKAGES):  # the module is in the wheel once
            yield f"{name}.data/data/{place}", file
        if place.startswith(PACKAGES):
            yield place.removeprefix(PACKAGES + "/"), file


class Wheel:
    """An archive that lists what it holds."""

    def __init__(self, path):
        self.archive = zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED)
        self.records = []

    def add(self, place, data, mode=0o644):
        entry = zipfile.ZipInfo(place, FIRST_TIME)
        entry.external_attr = (0o100000 | mode) << 16
        entry.compress_type = zipfile.ZIP_DEFLATED
        self.archive.writestr(entry, data)
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        self.records.append((place, f"sha256={digest}", len(data)))

    def close(self, information):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([*self.records, (f"{information}/RECORD", "", "")])
        self.archive.writestr(zipfile.ZipInfo(f"{information}/RECORD", FIRST_TIME), text.getvalue())
        self.archive.close()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):  # noqa: ARG001 - the names are those of PEP 517
    name = f"pliant-{version()}"
    file = f"{name}-{tag()}.whl"
    with tempfile.TemporaryDirectory() as directory:
        prefix = pathlib.Path(directory) / "prefix"
        install(prefix, config_settings or {})
        wheel = Wheel(pathlib.Path(wheel_directory) / file)
        for place, source in members(prefix, name):
            wheel.add(place, source.read_bytes(), 0o755 if os.access(source, os.X_OK) else 0o644)
        information = f"{name}.dist-info"
        wheel.add(f"{information}/METADATA", metadata().encode())
        wheel.add(f"{information}/WHEEL", f"Wheel-Version: 1.0\nGenerator: pliant\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode())
        wheel.add(f"{information}/LICENSE", (ROOT / "LICENSE").read_bytes())
        wheel.close(information)
    return file


def build_sdist(sdist_directory, config_settings=None):  # noqa: ARG001
    """The files of the repository."""
    name = f"pliant-{version()}"
    files = subprocess.run(["git", "-C", str(ROOT), "ls-files", "-z"], check=True, capture_output=True, text=True).stdout.split("\0")
    path = pathlib.Path(sdist_directory) / f"{name}.tar.gz"
    with tarfile.open(path, "w:gz", format=tarfile.PAX_FORMAT) as archive:
        for file in filter(None, files):
            archive.add(ROOT / file, f"{name}/{file}")
        information = tarfile.TarInfo(f"{name}/PKG-INFO")
        data = metadata().encode()
        information.size = len(data)
        archive.addfile(information, io.BytesIO(data))
    return path.name
