"""What `cmake --install` and `cpack` make of the build: complete, wherever it is moved, and enough to build on."""
import importlib.util
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/program"), str(ROOT / "tests/tools")]

import synthetic  # noqa: E402
from program import ENVIRONMENT, read_history  # noqa: E402

BUILD = pathlib.Path(os.environ.get("PLIANT_BUILD", ROOT / "build"))
EXAMPLE = ROOT / "docs/examples/extending"


def run(*command, cwd=None):
    done = subprocess.run([str(c) for c in command], cwd=cwd, env=ENVIRONMENT, stdin=subprocess.DEVNULL, text=True,
                          capture_output=True, check=False, timeout=300)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} returned {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout


def imported_modules():
    """What `import pliant` needs beside Python itself, from the imports that stand at the left margin."""
    texts = "\n".join(f.read_text() for f in (ROOT / "src/python/pliant").glob("*.py"))
    return set(re.findall(r"^(?:import|from) ([a-z]\w*)", texts, re.M)) - sys.stdlib_module_names


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = pathlib.Path(tempfile.mkdtemp(prefix="pliant-package-"))
        cls.addClassCleanup(shutil.rmtree, cls.directory)
        run("cmake", "--install", BUILD, "--prefix", cls.directory / "first", "--strip")
        cls.prefix = cls.directory / "moved"
        os.rename(cls.directory / "first", cls.prefix)

    def test_the_installed_program_finds_its_parts(self):
        text = run(self.prefix / "bin/pliant", "check", self.prefix / "share/pliant/input/cantilever.yaml")
        self.assertIn("the input is valid", text)  # gmsh's module has meshed the geometry

    def test_the_documents_call_the_program_by_its_name(self):
        installed, here = self.prefix / "share/pliant/docs", ROOT / "docs"
        for page in here.glob("*.md"):
            text = page.read_text(encoding="utf-8")
            self.assertEqual((installed / page.name).read_text(encoding="utf-8"),
                             text if page.name == "install.md" else text.replace("build/bin/pliant", "pliant"), page.name)

    def test_the_python_package_is_where_python_finds_it(self):
        packages = self.prefix / "lib/python3/dist-packages"
        text = run("/usr/bin/python3", "-c", f"import sys; sys.path.insert(0, {str(packages)!r}); import pliant; print(pliant.__file__)")
        self.assertTrue(text.startswith(str(packages)), text)

    def test_a_simulation_runs_in_the_installed_package(self):
        packages = self.prefix / "lib/python3/dist-packages"
        text = run("/usr/bin/python3", "-c", f"""import sys; sys.path.insert(0, {str(packages)!r}); import pliant, _pliant
sim = pliant.Simulation({str(ROOT / "input/verification/single_tetrahedron.yaml")!r})
sim.run(); print(sim.done, _pliant.__file__)""")
        self.assertTrue(text.startswith(f"True {packages}"), text)

    def test_the_installed_program_draws(self):
        out = self.directory / "out"
        synthetic.write_result(out, num_frames=1, order=1, cubes=(2, 1, 1))
        synthetic.write_history(out, num_steps=2)
        for command, file in (("render", "picture.png"), ("plot", "history.png")):
            self.assertEqual(run(self.prefix / "bin/pliant", command, out), f"{out / file}\n")
            self.assertEqual((out / file).read_bytes()[:4], b"\x89PNG")
        # With the code that was installed, not that of the sources.
        code = self.prefix / "lib/python3/dist-packages/pliant/start.py"
        os.rename(code, code.with_suffix(".away"))
        self.addCleanup(os.rename, code.with_suffix(".away"), code)
        with self.assertRaisesRegex(AssertionError, f"returned 4\npliant plot: its Python code is missing: '{code}'"):
            run(self.prefix / "bin/pliant", "plot", out)

    @unittest.skipUnless(importlib.util.find_spec("venv") and importlib.util.find_spec("ensurepip"), "python3-venv is not installed")
    def test_pip_installs_it(self):
        """A wheel of this build, installed into an environment of its own: program and package are those of the environment."""
        wheels = self.directory / "wheels"
        run("/usr/bin/python3", "-m", "pip", "wheel", ROOT, "--no-build-isolation", "--no-deps", "--wheel-dir", wheels, f"--config-settings=build-dir={BUILD}")
        (wheel,) = wheels.iterdir()
        self.assertRegex(wheel.name, r"^pliant-[\d.]+-cp3\d+-cp3\d+-linux_\w+\.whl$")
        home = self.directory / "environment"
        run("/usr/bin/python3", "-m", "venv", "--system-site-packages", home)
        run(home / "bin/pip", "install", "--no-index", "--no-deps", wheel)
        self.assertIn("the input is valid", run(home / "bin/pliant", "check", home / "share/pliant/input/cantilever.yaml"))
        text = run("env", "-u", "PLIANT", home / "bin/python", "-c", f"""import pliant, pliant.runs
sim = pliant.Simulation({str(ROOT / "input/verification/single_tetrahedron.yaml")!r})
sim.run(); print(sim.done, pliant.runs.program(), pliant.__file__)""", cwd=self.directory)
        self.assertEqual(text.split()[:2], ["True", str(home / "bin/pliant")])
        self.assertTrue(text.split()[2].startswith(str(home / "lib")), text)
        run(home / "bin/pliant", "convert", EXAMPLE.parent / "rubber_block.inp", cwd=self.directory)
        run(home / "bin/pip", "uninstall", "--yes", "pliant")
        self.assertFalse((home / "bin/pliant").exists() or (home / "lib/pliant").exists())

    def test_another_program_adds_a_law_and_a_term(self):
        build = self.directory / "example"
        run("cmake", "-S", EXAMPLE, "-B", build, f"-DCMAKE_PREFIX_PATH={self.prefix}", "-DCMAKE_BUILD_TYPE=Release",
            "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror")
        run("cmake", "--build", build)
        of_ranks = []
        for ranks in (1, 2):
            directory = self.directory / f"trapped{ranks}"
            directory.mkdir()
            run("mpirun", "--oversubscribe", "--bind-to", "none", "-n", ranks, build / "trapped", EXAMPLE / "trapped.yaml",
                cwd=directory)
            of_ranks.append(read_history(directory / "out/trapped"))
        history = of_ranks[0]
        # The implicit midpoint rule turns an oscillator of frequency w by 2 atan(w dt/2) a step, exactly; the centre of
        # mass is one, whatever the cube does around it.
        mass, amplitude, w, dt = 1000.0, 1.5, 3.0, 0.01
        angles = 2 * math.atan(w * dt / 2) * history["step"]
        for step, angle in enumerate(angles):
            self.assertAlmostEqual(history["px"][step], mass * amplitude * w * math.sin(angle), delta=1e-4)
        # The trap squeezes the cube: the law is at work.
        self.assertGreater(history["elastic_energy"].max(), 1e-3)
        self.assertLess(abs(history["energy_balance_error"]).max(), 1e-6)
        for name in ("px", "elastic_energy", "load_potential"):
            scale = abs(history[name]).max()
            self.assertLess(abs(of_ranks[1][name] - history[name]).max(), 1e-8 * scale, name)

    def test_debian_packages(self):
        run("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", self.directory / "packages",
            "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip")
        files = sorted((self.directory / "packages").glob("*.deb"))
        version = re.search(r"project\(pliant VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
        self.assertEqual([f.name.split("_")[:2] for f in files], [["libpliant-dev", version], ["pliant", version]])
        of_libraries, of_program = files

        def fields(file):
            text = run("dpkg-deb", "-I", file)
            depends = re.search(r"^ Depends: (.*)$", text, re.M).group(1)
            return {re.match(r"\S+", d.strip()).group() for d in depends.split(",")}

        def content(file):
            return {line.split()[5][1:] for line in run("dpkg-deb", "-c", file).splitlines()}

        needed = fields(of_program)
        for start in ("libpetsc-real3", "libslepc-real3", "libgmsh4", "libopenmpi3", "libhdf5-openmpi", "libyaml-cpp", "libfmt", "libmuparser",
                      "libudunits2", "libmetis", "libc6", "libstdc++6", "openmpi-bin",
                      *(f"python3-{module}" for module in imported_modules())):
            self.assertTrue(any(name.startswith(start) for name in needed), f"{start} is not among {needed}")
        self.assertLessEqual({"/usr/bin/pliant", "/usr/lib/pliant/libpliant_gmsh.so", "/usr/share/pliant/input/gripper_finger.yaml",
                              "/usr/share/pliant/meshes/gripper_finger.geo", "/usr/share/pliant/docs/index.md",
                              "/usr/lib/python3/dist-packages/pliant/__init__.py", "/usr/lib/python3/dist-packages/pliant/start.py",
                              "/usr/share/doc/pliant/copyright"}, content(of_program))
        self.assertTrue(any(file.startswith("/usr/lib/python3/dist-packages/_pliant.") for file in content(of_program)))

        # What a program needs to be built on the libraries is there where this machine's list has it.
        wanted = run(ROOT / "tools/setup.sh", "list", "run").split()
        needed = fields(of_libraries) - {"pliant"}
        self.assertLessEqual(needed, set(wanted))
        headers = {f"/usr/include/pliant/{f.relative_to(ROOT / 'src')}" for f in (ROOT / "src").rglob("*.hpp")
                   if "viewer" not in f.parts}
        self.assertLessEqual(headers, content(of_libraries))


if __name__ == "__main__":
    unittest.main()
