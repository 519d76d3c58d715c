#!/usr/bin/python3
"""`pliant convert`: models of Abaqus, CalculiX and FEBio become inputs that have the stresses which those programs' manuals define.

The models here are written by the test: one brick, or a few. Files of the programs' own test suites were converted too (docs/from-other-programs.md).
"""
import contextlib
import io
import math
import os
import random
import re
import sys
import unittest

import numpy as np
import yaml

from program import LONG, ROOT, ProgramTest, read_history

sys.path.insert(0, str(ROOT / "src/python"))

from pliant import PliantError  # noqa: E402
from pliant.convert import convert as converter  # noqa: E402

BRICK = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
SIDES = {"left": (1, 4, 5, 8), "front": (1, 2, 5, 6), "bottom": (1, 2, 3, 4), "right": (2, 3, 6, 7)}
STRETCH = 1.4


def abaqus_cubes(materials, step, more=""):
    """Unit cubes that are held on three sides: cube1, left1, ..."""
    text = "*HEADING\n cubes\n"
    for k in range(1, len(materials) + 1):
        text += "*NODE\n" + "".join(f"{8 * k + n}, {x}, {y + 3 * k}, {z}\n" for n, (x, y, z) in enumerate(BRICK, 1))
        text += f"*ELEMENT, TYPE=C3D8, ELSET=cube{k}\n{k}, {', '.join(str(8 * k + n) for n in range(1, 9))}\n*SURFACE, NAME=end{k}\ncube{k}, S4\n"
        text += "".join(f"*NSET, NSET={name}{k}\n{', '.join(str(8 * k + n) for n in of)}\n" for name, of in SIDES.items())
        text += f"*BOUNDARY\nleft{k}, 1\nfront{k}, 2\nbottom{k}, 3\n"
    for k, material in enumerate(materials, 1):
        text += f"*MATERIAL, NAME=rubber{k}\n{material}*SOLID SECTION, ELSET=cube{k}, MATERIAL=rubber{k}\n"
    return f"{text}{more}*STEP, NLGEOM\n{step}*END STEP\n"


def pulled(count, by=0.4):
    return "*STATIC\n0.25, 1.\n*BOUNDARY\n" + "".join(f"right{k}, 1, 1, {by}\n" for k in range(1, count + 1))


def febio_cubes(materials, conditions, loads="", steps=4):
    """The same; `materials`: type and constants of each."""
    text = '<?xml version="1.0"?>\n<febio_spec version="4.0">\n<Module type="solid"><units>SI</units></Module>\n'
    text += f"<Control><analysis>STATIC</analysis><time_steps>{steps}</time_steps><step_size>{1 / steps}</step_size></Control>\n<Material>\n"
    text += "".join(f'<material id="{k}" name="rubber{k}" type="{kind}">{constants}</material>\n' for k, (kind, constants) in enumerate(materials, 1))
    mesh, domains, held = "", "", ""
    for k in range(1, len(materials) + 1):
        mesh += f'<Nodes name="all{k}">' + "".join(f'<node id="{8 * k + n}">{x},{y + 3 * k},{z}</node>' for n, (x, y, z) in enumerate(BRICK, 1)) + "</Nodes>\n"
        mesh += f'<Elements type="hex8" name="cube{k}"><elem id="{k}">{",".join(str(8 * k + n) for n in range(1, 9))}</elem></Elements>\n'
        mesh += "".join(f'<NodeSet name="{name}{k}">{",".join(str(8 * k + n) for n in of)}</NodeSet>\n' for name, of in SIDES.items())
        mesh += f'<Surface name="end{k}"><quad4 id="1">{8 * k + 2},{8 * k + 3},{8 * k + 7},{8 * k + 6}</quad4></Surface>\n'
        domains += f'<SolidDomain name="cube{k}" mat="rubber{k}"/>\n'
        held += "".join(f'<bc type="zero displacement" node_set="{name}{k}"><{dof}_dof>1</{dof}_dof></bc>\n' for name, dof in (("left", "x"), ("front", "y"), ("bottom", "z")))
    return (f"{text}</Material>\n<Mesh>\n{mesh}</Mesh>\n<MeshDomains>\n{domains}</MeshDomains>\n<Boundary>\n{held}{conditions}</Boundary>\n<Loads>\n{loads}</Loads>\n"
            '<LoadData><load_controller id="1" type="loadcurve"><interpolate>LINEAR</interpolate><points><pt>0,0</pt><pt>1,1</pt></points></load_controller></LoadData>\n'
            "</febio_spec>\n")


def febio_pull(count):
    return "".join(f'<bc type="prescribed displacement" node_set="right{k}"><dof>x</dof><value lc="1">0.4</value></bc>\n' for k in range(1, count + 1))


def uniaxial_force(energy):
    """Force on a unit cube of the energy psi(l1, l2, l3) at STRETCH, free across: by differences and bisection."""
    def slope(k, lateral, step=1e-5):
        ends = []
        for sign in (1, -1):
            stretches = [STRETCH, lateral, lateral]
            stretches[k] += sign * step
            ends.append(energy(*stretches))
        return (ends[0] - ends[1]) / (2 * step)

    low, high = 0.5, 1.2
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if slope(1, middle) > 0 else (middle, high)
    return slope(0, low)


def invariants(*stretches):
    """J, I1b, I2b."""
    squares = np.square(stretches)
    jacobian = float(np.prod(stretches))
    i1 = squares.sum()
    return jacobian, i1 * jacobian ** (-2 / 3), (i1 ** 2 - (squares ** 2).sum()) / 2 * jacobian ** (-4 / 3)


def isochoric(stretches):
    return np.array(stretches) / np.prod(stretches) ** (1 / 3)


def of_abaqus(deviatoric, d=2e-6):
    """Abaqus's volumetric part."""
    return lambda *l: deviatoric(*l) + (np.prod(l) - 1) ** 2 / d


def of_febio(deviatoric, k=1e6):
    return lambda *l: deviatoric(*l) + k / 2 * math.log(np.prod(l)) ** 2


def chains(mu, squared):
    """Arruda and Boyce's series; `squared`: locking stretch squared, or links."""
    a = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    return lambda *l: mu * sum(a[k] / squared**k * (invariants(*l)[1] ** (k + 1) - 3 ** (k + 1)) for k in range(5))


def polynomial(**c):
    def psi(*l):
        _, i1, i2 = invariants(*l)
        return sum(value * (i1 - 3) ** int(name[1]) * (i2 - 3) ** int(name[2]) for name, value in c.items())
    return psi


def ogden(*terms):
    """Of Abaqus: 2 mu/alpha^2 (sum l^alpha - 3)."""
    return lambda *l: sum(2 * mu / alpha**2 * ((isochoric(l) ** alpha).sum() - 3) for mu, alpha in terms)


def saint_venant(young, nu):
    mu, lam = young / 2 / (1 + nu), young * nu / (1 + nu) / (1 - 2 * nu)
    return lambda *l: mu * sum(((x * x - 1) / 2) ** 2 for x in l) + lam / 2 * sum((x * x - 1) / 2 for x in l) ** 2


def coupled_mooney(c1, c2, k):
    def psi(*l):
        s, ln = np.square(l), math.log(np.prod(l))
        return c1 * (s.sum() - 3) + c2 * ((s.sum() ** 2 - (s ** 2).sum()) / 2 - 3) - 2 * (c1 + 2 * c2) * ln + k / 2 * ln**2
    return psi


def neo_hookean(young, nu):
    mu, lam = young / 2 / (1 + nu), young * nu / (1 + nu) / (1 - 2 * nu)
    return lambda *l: mu / 2 * (np.square(l).sum() - 3) - mu * math.log(np.prod(l)) + lam / 2 * math.log(np.prod(l)) ** 2


ABAQUS = {
    "neo-Hooke": ("*HYPERELASTIC, NEO HOOKE\n1e5, 2e-6\n", of_abaqus(polynomial(c10=1e5))),
    "Mooney-Rivlin": ("*HYPERELASTIC, MOONEY-RIVLIN\n8e4, 2e4, 2e-6\n", of_abaqus(polynomial(c10=8e4, c01=2e4))),
    "polynomial by default": ("*HYPERELASTIC\n8e4, 2e4, 2e-6\n", of_abaqus(polynomial(c10=8e4, c01=2e4))),
    "polynomial, N = 2": ("*HYPERELASTIC, POLYNOMIAL, N=2\n8e4, 2e4, 5e3, 1e3, 5e2, 2e-6, 0.\n", of_abaqus(polynomial(c10=8e4, c01=2e4, c20=5e3, c11=1e3, c02=5e2))),
    "reduced polynomial": ("*HYPERELASTIC, REDUCED POLYNOMIAL, N=2\n8e4, 9e3, 2e-6, 0\n", of_abaqus(polynomial(c10=8e4, c20=9e3))),
    "Yeoh": ("*HYPERELASTIC, YEOH\n8e4, -4e3, 3e3, 2e-6, 0, 0\n", of_abaqus(polynomial(c10=8e4, c20=-4e3, c30=3e3))),
    "Ogden, N = 2": ("*HYPERELASTIC, OGDEN, N=2\n2e5, 3.5, 1e5,\n-2., 2e-6, 0.\n", of_abaqus(ogden((2e5, 3.5), (1e5, -2)))),
    "Arruda-Boyce": ("*HYPERELASTIC, ARRUDA-BOYCE\n2e5, 1.8, 2e-6\n", lambda *l: chains(2e5, 1.8**2)(*l) + ((np.prod(l) ** 2 - 1) / 2 - math.log(np.prod(l))) / 2e-6),
    "elastic": ("*ELASTIC\n1e6, 0.3\n", saint_venant(1e6, 0.3)),
}
FEBIO = {
    "neo-Hookean": (("neo-Hookean", "<E>1e6</E><v>0.3</v>"), neo_hookean(1e6, 0.3)),
    "isotropic elastic": (("isotropic elastic", "<E>1e6</E><v>0.3</v>"), saint_venant(1e6, 0.3)),
    "Mooney-Rivlin": (("Mooney-Rivlin", "<c1>8e4</c1><c2>2e4</c2><k>1e6</k>"), of_febio(polynomial(c10=8e4, c01=2e4))),
    "Mooney-Rivlin, NIKE3D": (("Mooney-Rivlin", "<c1>8e4</c1><c2>0</c2><k>1e6</k><pressure_model>1</pressure_model>"),
                              lambda *l: polynomial(c10=8e4)(*l) + 0.25e6 * (np.prod(l) ** 2 - 1 - 2 * math.log(np.prod(l)))),
    "coupled Mooney-Rivlin": (("coupled Mooney-Rivlin", "<c1>8e4</c1><c2>2e4</c2><k>4e5</k>"), coupled_mooney(8e4, 2e4, 4e5)),
    # c/m^2 (sum l^m - 3): twice Abaqus's mu
    "Ogden": (("Ogden", "<c1>4e5</c1><m1>3.5</m1><c3>2e5</c3><m3>-2</m3><k>1e6</k>"), of_febio(ogden((2e5, 3.5), (1e5, -2)))),
    "Yeoh": (("Yeoh", "<c1>8e4</c1><c2>-4e3</c2><c3>3e3</c3><k>1e6</k>"), of_febio(polynomial(c10=8e4, c20=-4e3, c30=3e3))),
    "Arruda-Boyce": (("Arruda-Boyce", "<mu>2e5</mu><N>3</N><k>1e6</k>"), of_febio(chains(2e5, 3))),
}


class ConvertTest(ProgramTest):
    def convert(self, name, text, *options):
        """The input, as a document, and what was said."""
        self.write(name, text)
        out, said = io.StringIO(), io.StringIO()
        with contextlib.chdir(self.directory), contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
            converter.convert(converter.parser_of("pliant convert").parse_args([name, "--force", *options]))
        file = out.getvalue().split("\n")[0]
        return yaml.safe_load((self.directory / file).read_text()), said.getvalue()

    def history(self, name, *settings):
        self.pliant("run", name, "--quiet", "--output", "out", *[word for s in settings for word in ("--set", s)])
        return read_history(self.directory / "out")

    def fails(self, text, words, name="cubes.inp"):
        """The model is refused with a message."""
        with self.assertRaisesRegex(PliantError, "^" + words):
            self.convert(name, text)


class Convert(ConvertTest):
    def check_laws(self, name, text, energies):
        self.convert(name, text)
        history = self.history("cubes.yaml")
        for k, (law, energy) in enumerate(energies.items(), 1):
            with self.subTest(law):
                expected = uniaxial_force(energy)
                self.assertGreater(expected, 1e4)
                self.assertAlmostEqual(history[f"right{k}_fx"][-1] / expected, 1, delta=2e-6)

    def test_laws_of_abaqus(self):
        """Its energies by differences, on cubes that are pulled."""
        text = abaqus_cubes([material for material, _ in ABAQUS.values()], pulled(len(ABAQUS)))
        self.check_laws("cubes.inp", text, {law: energy for law, (_, energy) in ABAQUS.items()})

    def test_laws_of_febio(self):
        text = febio_cubes([constants for constants, _ in FEBIO.values()], febio_pull(len(FEBIO)))
        self.check_laws("cubes.feb", text, {law: energy for law, (_, energy) in FEBIO.items()})

    def test_versions_of_febio(self):
        """The same model as versions 3 and 2.5 have it."""
        newest = febio_cubes([("neo-Hookean", "<density>1</density><E>1e6</E><v>0.3</v>")], febio_pull(1),
                             '<surface_load type="pressure" surface="end1"><pressure lc="1">4</pressure></surface_load>\n')
        third = re.sub(r'<NodeSet name="(\w+)">([\d,]+)</NodeSet>', lambda m: f'<NodeSet name="{m[1]}">' + "".join(f'<n id="{n}"/>' for n in m[2].split(",")) + "</NodeSet>", newest)
        third = re.sub(r'<bc type="zero displacement" node_set="(\w+)"><(\w)_dof>1</\w_dof></bc>', r'<bc type="fix" node_set="\1"><dofs>\2</dofs></bc>', third)
        third = third.replace('type="prescribed displacement"', 'type="prescribe"').replace("<value lc", "<scale lc").replace("0.4</value>", "0.4</scale>")
        third = third.replace('version="4.0"', 'version="3.0"').replace("<pt>", "<point>").replace("</pt>", "</point>")
        second = third.replace('version="3.0"', 'version="2.5"').replace("<Mesh>", "<Geometry>").replace("</Mesh>", "</Geometry>")
        second = re.sub(r"(?s)<MeshDomains>.*</MeshDomains>", "", second).replace('<Elements type="hex8" name="cube1">', '<Elements type="hex8" name="cube1" mat="1">')
        second = re.sub(r'<bc type="fix" node_set="(\w+)"><dofs>(\w)</dofs></bc>', r'<fix bc="\2" node_set="\1"/>', second)
        second = re.sub(r'<bc type="prescribe" node_set="(\w+)"><dof>(\w)</dof>(.*)</bc>', r'<prescribe bc="\2" node_set="\1">\3</prescribe>', second)
        second = re.sub(r'<load_controller id="1" .*?<points>(.*)</points></load_controller>', r'<loadcurve id="1" type="linear" extend="constant">\1</loadcurve>', second)
        second = second.replace("<analysis>STATIC</analysis>", '<analysis type="static"/>')
        configs = [self.convert("cubes.feb", text)[0] for text in (newest, third, second)]
        self.assertEqual(configs[0]["constraints"][-1], {"surface": "right1", "displacement": ["0.4*t", "free", "free"]})
        self.assertEqual(configs[0], configs[1])
        self.assertEqual(configs[0], configs[2])

    def test_relaxation(self):
        """Prony series: of Abaqus relative to fast motion, of FEBio to the state at rest."""
        series = "*VISCOELASTIC, TIME=PRONY\n0.4, 0., 0.5\n"
        materials = [f"*HYPERELASTIC, NEO HOOKE, MODULI={moduli}\n1e5, 2e-9\n{series}" for moduli in ("LONG TERM", "INSTANTANEOUS")]
        step = "*VISCO, CETOL=1e-3\n0.05, 1.\n*BOUNDARY, AMPLITUDE=jump\nright1, 1, 1, 0.01\nright2, 1, 1, 0.01\n"
        config, said = self.convert("cubes.inp", abaqus_cubes(materials, step, "*AMPLITUDE, NAME=jump\n0, 0, 0.01, 1, 1, 1\n"))
        self.assertEqual(config["volumetric"], "mixed")
        self.assertIn("*VISCO, CETOL", said)
        history = self.history("cubes.yaml", "time.step=10ms")
        after = history["time"] > 0.02
        for k, at_rest in ((1, 1.0), (2, 0.6)):
            rest = at_rest * 2e5 * (1.01 - 1.01**-2)
            expected = rest * (1 + 0.4 / 0.6 * np.exp(-(history["time"][after] - 0.005) / 0.5))
            self.assertLess(np.abs(history[f"right{k}_fx"][after] / expected - 1).max(), 1.2e-2)
        elastic = '<elastic type="neo-Hookean"><density>1</density><E>1e5</E><v>0</v></elastic>'
        config, _ = self.convert("cubes.feb", febio_cubes([("viscoelastic", f"<g1>0.95</g1><t1>0.01</t1>{elastic}")], ""))
        self.assertEqual(config["bodies"][0]["viscosity"], [{"model": "prony", "ratio": 0.95, "relaxation_time": 0.01}])
        self.assertEqual(config["bodies"][0]["elasticity"]["youngs_modulus"], 1e5)

    def check_forces(self, name, text, loads, *options):
        config, _ = self.convert(name, text, *options)
        history = self.history("cubes.yaml")
        for k, (load, force) in enumerate(loads, 1):
            with self.subTest(load):
                self.assertAlmostEqual(history[f"left{k}_fx"][-1] / -force, 1, delta=1e-7)
        return config

    def test_loads_and_units(self):
        """Pressure, traction, forces on nodes and gravity have their resultants; millimetres, newtons, MPa."""
        loads = [("*DLOAD\ncube1, P4, 2e-3\n", -2e-3), ("*DSLOAD\nend2, P, 2e-3\n", -2e-3), ("*DSLOAD, FOLLOWER=NO\nend3, TRVEC, 3e-3, 2., 0., 0.\n", 3e-3),
                 ("*CLOAD\nright4, 1, 1e-3\n", 4e-3), ("*CLOAD\n42, 1, 1e-3\n", 1e-3), ("*DLOAD\ncube6, GRAV, 1e6, 1., 0., 0.\n", 1e-3), ("*DLOAD\n7, BX, 2e-3\n", 2e-3)]
        text = abaqus_cubes(["*ELASTIC\n1., 0.3\n*DENSITY\n1e-9\n"] * len(loads), "*STATIC\n1., 1.\n" + "".join(load for load, _ in loads))
        config = self.check_forces("cubes.inp", text.replace("*STEP, NLGEOM", "*STEP"), loads, "--units", "mm-N-s")
        self.assertEqual(config["time"], {"method": "static"})
        self.assertEqual(config["bodies"][0]["density"], 1000)
        self.assertEqual(config["bodies"][0]["elasticity"], {"model": "linear", "youngs_modulus": 1e6, "poissons_ratio": 0.3})
        # A uniform traction, given by nodal forces, is one.
        self.assertIn({"surface": "traction_1", "traction": [4000, 0, 0]}, config["loads"])
        pressure = '<surface_load type="pressure" surface="end2"><pressure lc="1">4</pressure><linear>1</linear></surface_load>\n'
        inward = '<surface_load type="pressure" surface="end3"><pressure lc="1">4</pressure></surface_load>\n'
        loads = [('<nodal_load type="nodal_force" node_set="right1"><value lc="1">2,0,0</value></nodal_load>\n', 8), (pressure, -4), (inward, 4),
                 ('<surface_load type="traction" surface="end4"><scale lc="1">2</scale><traction>3,0,0</traction></surface_load>\n', 6),
                 ('<body_load type="const" elem_set="cube5"><x lc="1">-5</x><y>0</y><z>0</z></body_load>\n', 5)]
        text = febio_cubes([("neo-Hookean", "<density>1</density><E>1e6</E><v>0.3</v>")] * len(loads), "", "".join(load for load, _ in loads))
        ordered = ",".join(str(24 + n) for n in (2, 3, 7, 6))
        self.assertIn(ordered, text)
        # A follower pressure on a face that has become wider pushes more; there the lateral stretch enters.
        self.check_forces("cubes.feb", text.replace(ordered, ",".join(reversed(ordered.split(",")))), loads[:2])
        history = read_history(self.directory / "out")
        for k, (_, force) in enumerate(loads[2:], 3):
            self.assertAlmostEqual(history[f"left{k}_fx"][-1] / -force, 1, delta=1e-4)

    def test_courses(self):
        """Ramps over steps and amplitudes."""
        steps = (pulled(1, 0.1) + "*END STEP\n*AMPLITUDE, NAME=saw\n0, 1, 1, 0.5, 2, 2\n*STEP, NLGEOM\n*STATIC\n0.5, 2.\n"
                 "*BOUNDARY, AMPLITUDE=saw\nright1, 1, 1, 0.1\n")
        config, _ = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], steps))
        self.assertEqual(config["constraints"][-1]["displacement"], ["t < 1 ? 0.1*t : t < 2 ? 0.1 - 0.05*(t - 1) : 0.05 + 0.15*(t - 2)", "free", "free"])
        self.assertEqual(config["time"], {"method": "quasistatic", "step": 0.25, "end": 3})
        history = self.history("cubes.yaml", "probes=[{name: tip, point: [1, 4, 1]}]")
        np.testing.assert_allclose(history["tip_x"] - 1, np.interp(history["time"], [0, 1, 2, 3], [0, 0.1, 0.05, 0.2]), atol=1e-9)

    def test_loads_of_one_step_add_up_and_total_time_continues(self):
        steps = ("*END STEP\n*AMPLITUDE, NAME=total, TIME=TOTAL TIME\n0, 0, 4, 4\n*AMPLITUDE, NAME=other\n0, 0, 1, 1\n*STEP\n*STATIC\n0.5, 1.\n"
                 "*DSLOAD, FOLLOWER=NO\nend1, TRVEC, 2., 1., 0., 0.\nend1, TRVEC, 3., 1., 0., 0.\n*DSLOAD, FOLLOWER=NO, AMPLITUDE=total\nend2, TRVEC, 2., 1., 0., 0.\n"
                 "*END STEP\n*STEP\n*STATIC\n0.5, 1.\n*DSLOAD, FOLLOWER=NO\nend1, TRVEC, 4., 1., 0., 0.\n*END STEP\n")
        config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"] * 2, steps))
        self.assertNotIn("not complete", said)
        history = self.history("cubes.yaml")
        at = [np.flatnonzero(np.abs(history["time"] - t) < 1e-9)[0] for t in (1.0, 2.0)]
        np.testing.assert_allclose(history["left1_fx"][at], [-5, -4], rtol=1e-9)
        np.testing.assert_allclose(history["left2_fx"][at], [-2, -4], rtol=1e-9)
        twice = "*DSLOAD, FOLLOWER=NO\nend1, TRVEC, 2., 1., 0., 0.\n*DSLOAD, FOLLOWER=NO, AMPLITUDE=other\nend1, TRVEC, 3., 1., 0., 0.\n"
        steps = "*END STEP\n*AMPLITUDE, NAME=other\n0, 0, 1, 1\n*STEP\n*STATIC\n0.5, 1.\n" + twice + "*END STEP\n"
        _, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], steps))
        self.assertIn("a second load on the same place, with another amplitude", said)
        self.assertIn("not complete", said)

    def test_any_order_of_cards_and_any_case_of_names(self):
        text = abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], pulled(1))
        usual, _ = self.convert("cubes.inp", text)
        heading, nodes, rest = re.fullmatch(r"(?s)(\*HEADING.*?\n)(\*NODE.*?)(\*NSET.*)", text).groups()
        sets, others = re.fullmatch(r"(?s)(.*?)(\*BOUNDARY.*)", rest).groups()
        self.assertEqual(self.convert("cubes.inp", heading + sets + nodes + others)[0], usual)
        steps = "*STATIC\n0.25, 1.\n*DLOAD\ncube1, P4, -10.\n*END STEP\n*STEP, NLGEOM\n*STATIC\n0.25, 1.\n*DLOAD\nCUBE1, P4, -20.\n"
        config, _ = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], steps))
        self.assertEqual(len(config["loads"]), 1)

    def test_elements_without_a_section_are_told(self):
        text = abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"] * 2, pulled(2)).replace("*SOLID SECTION, ELSET=cube2, MATERIAL=rubber2\n", "")
        _, said = self.convert("cubes.inp", text)
        self.assertIn("1 of 2 elements have no *SOLID SECTION", said)

    def test_loads_of_a_visco_step_act_at_once(self):
        for step, expected in (("*STATIC", True), ("*VISCO", False)):
            text = abaqus_cubes(["*HYPERELASTIC, NEO HOOKE\n1e5, 2e-6\n"], f"{step}\n0.25, 1.\n*DLOAD\ncube1, P4, -10.\n")
            config, _ = self.convert("cubes.inp", text)
            self.assertEqual("*t" in str(config["loads"]), expected, config["loads"])
        text = abaqus_cubes(["*ELASTIC\n1e5, 0.3\n*DENSITY\n1\n"], "*DYNAMIC\n0.25, 1.\n*DLOAD\ncube1, P4, -10.\n")
        self.assertNotIn("*t", str(self.convert("cubes.inp", text)[0]["loads"]))
        self.assertIn("*t", str(self.convert("cubes.inp", text.replace("*STEP, NLGEOM", "*STEP, NLGEOM, AMPLITUDE=RAMP"))[0]["loads"]))

    def test_quadratic_and_other_elements(self):
        """A curved quadratic brick keeps its volume, to that of its tetrahedra; wedges and pyramids fit; all match at their faces."""
        edges = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
        corners = np.array(BRICK, dtype=float)
        middles = np.array([(corners[a] + corners[b]) / 2 for a, b in edges])
        middles[4:8, 2] += 0.1
        nodes = "".join(f"{k}, {', '.join(map(str, x))}\n" for k, x in enumerate(np.concatenate([corners, middles]), 1))
        model = (f"*NODE\n{nodes}*ELEMENT, TYPE=C3D20R, ELSET=cube\n1, {', '.join(map(str, range(1, 16)))},\n16, 17, 18, 19, 20\n*MATERIAL, NAME=m\n*ELASTIC\n1e6, 0.3\n"
                 "*DENSITY\n1.\n*SOLID SECTION, ELSET=cube, MATERIAL=m\n*BOUNDARY\n1, 1, 3\n2, 2, 3\n4, 3\n*STEP\n*STATIC\n*DLOAD\ncube, GRAV, 1., 0, 0, -1.\n*END STEP\n")
        self.convert("curved.inp", model)
        reactions = self.history("curved.yaml")
        # The top is raised by 0.1 in the middle of its edges: by 0.2 in its middle, by 0.1333 in the mean.
        weight = sum(reactions[f"nodes_{k}_fz"][-1] for k in (1, 2, 3))
        self.assertAlmostEqual(weight, 1 + 0.4 / 3, delta=1e-9)
        # A house: two wedges and a pyramid.
        model = ("*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,.5,.5,1.8\n*ELEMENT, TYPE=C3D6, ELSET=all\n1, 1,2,3,5,6,7\n"
                 "2, 1,3,4,5,7,8\n*ELEMENT, TYPE=C3D5, ELSET=all\n3, 5,6,7,8,9\n*MATERIAL, NAME=m\n*ELASTIC\n1e6, 0.3\n*DENSITY\n3.\n"
                 "*SOLID SECTION, ELSET=all, MATERIAL=m\n*NSET, NSET=base\n1,2,3,4\n*BOUNDARY\nbase, ENCASTRE\n*STEP\n*STATIC\n*DLOAD\nall, GRAV, 2., 0, 0, -1.\n*END STEP\n")
        self.convert("house.inp", model)
        self.assertAlmostEqual(self.history("house.yaml")["base_fz"][-1], 6 * (1 + 0.8 / 3), delta=1e-9)

    def test_stiff_parts_next_to_incompressible_rubber(self):
        """`volumetric: mixed` of the rubber is not for saint-venant-kirchhoff, and `pliant check` takes what is written."""
        series = "*VISCOELASTIC, TIME=PRONY\n0.4, 0.2, 0.5\n"
        laws = ["*HYPERELASTIC, NEO HOOKE\n1e5, 0\n", "*ELASTIC\n1e8, 0.35\n" + series, "*ELASTIC\n1e8, 0\n"]
        text = abaqus_cubes(laws, "*VISCO\n0.05, 1.\n").replace("*HEADING\n cubes\n", "*HEADING\n three cubes, soft; mm, N,, s,\n")
        config, said = self.convert("cubes.inp", text)
        self.assertEqual((config["title"], config["volumetric"]), ("three cubes, soft; mm, N, s", "mixed"))
        models = [body["elasticity"]["model"] for body in config["bodies"]]
        self.assertEqual(models, ["neo-hookean-isochoric", "neo-hookean", "neo-hookean-isochoric"])
        self.assertEqual([config["bodies"][k]["elasticity"]["poissons_ratio"] for k in (1, 2)], [0.35, 0])
        self.assertEqual([branch["model"] for branch in config["bodies"][1]["viscosity"]], ["prony"])
        self.assertIn("cube2: neo-hookean with the same Young's modulus and Poisson's ratio stands for saint-venant-kirchhoff", said)
        self.assertIn("cube3: neo-hookean-isochoric with the same", said)
        self.assertNotIn("becomes saint-venant-kirchhoff", said)
        self.pliant("check", "cubes.yaml")
        _, said = self.convert("cubes.inp", abaqus_cubes(laws[1:2], "*VISCO\n0.05, 1.\n"), "--force")
        self.assertIn("becomes saint-venant-kirchhoff", said)

    def test_what_is_left_out_is_listed(self):
        model = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n*PLASTIC\n1e3, 0.\n"], "*STATIC\n*CONTROLS, RESET\n*CONTACT DAMPING\n1.\n*DLOAD\n"
                             "cube1, CENTRIF, 1., 0, 0, 0, 0, 0, 1\n*NODE PRINT, NSET=all\nU\n")
        _, said = self.convert("cubes.inp", model)
        text = (self.directory / "cubes.yaml").read_text()
        lines = model.split("\n")
        for card in ("*PLASTIC", "*CONTACT DAMPING", "*DLOAD of the type CENTRIF", "*NODE PRINT", "*CONTROLS"):
            line = 1 + next(k for k, content in enumerate(lines) if content.startswith("cube1, CENTRIF" if "CENTRIF" in card else card))
            self.assertIn(f"warning: cubes.inp:{line}: {card}", said)
            self.assertIn(f"#   cubes.inp:{line}: {card}", text)
        self.assertRegex(said, r"\*PLASTIC: left out; pliant convert does not know this keyword\n")
        _, said = self.convert("typo.inp", abaqus_cubes(["*ELASTC, TYPE=ISO\n1e6, 0.3\n"], "*STATIC\n"))
        self.assertIn("*ELASTC, TYPE=ISO: left out; pliant convert does not know this keyword (did you mean *ELASTIC?)", said)
        model = febio_cubes([("trans iso Mooney-Rivlin", "<c1>1</c1>")], "").replace("<Loads>", '<Contact><contact type="sticky"/></Contact><Loads>')
        _, said = self.convert("cubes.feb", model)
        self.assertIn("the law 'trans iso Mooney-Rivlin' is not supported", said)
        self.assertIn("<contact type=sticky>: this kind of interface", said)
        self.assertIn("the input is not complete", said)
        self.assertIn("missing key 'elasticity'", self.pliant("check", "cubes.yaml", status=2).stderr)

    def test_contact_of_febio(self):
        """Two cubes on each other: pairs by their surfaces, with friction, and the penalty where it is the stiffness of a spring."""
        text = febio_cubes([("neo-Hookean", "<E>1e6</E><v>0.3</v>")] * 2, '<bc type="prescribed displacement" node_set="right2"><dof>x</dof><value lc="1">-0.02</value></bc>', steps=2)
        text = re.sub(r'<node id="(1[789]|2\d)">([\d.]+),([\d.]+),', lambda m: f'<node id="{m[1]}">{float(m[2]) + 1},{float(m[3]) - 3},', text)
        text = re.sub(r'<bc type="zero displacement" node_set="left2">.*?</bc>\n', "", text)
        text = text.replace("</Mesh>", '<Surface name="start2"><quad4 id="1">17,20,24,21</quad4></Surface><SurfacePair name="both"><primary>start2</primary><secondary>end1</secondary></SurfacePair></Mesh>')
        contact = lambda kind, more: text.replace("<Loads>", f'<Contact><contact type="{kind}" surface_pair="both">{more}</contact></Contact><Loads>')  # noqa: E731
        for kind, more, keys in (("sliding-elastic", "<laugon>0</laugon><penalty>1e8</penalty><fric_coeff>0.25</fric_coeff>", {"friction": 0.25, "stiffness": 1e8}),
                                 ("sliding-node-on-facet", "<auto_penalty>1</auto_penalty><penalty>10</penalty>", {}), ("sliding-facet-on-facet", "<laugon>1</laugon><penalty>1e8</penalty>", {})):
            config, said = self.convert("cubes.feb", contact(kind, more))
            self.assertNotIn("not complete", said)
            (pair,) = config["contact"]["pairs"]
            pair.pop("width")
            self.assertEqual(pair, {"name": "start2_end1", "surface": "start2", "with": "end1", **keys})
        # E 0.02/2 for small strains; the springs take a little.
        self.assertAlmostEqual(self.history("cubes.yaml")["left1_fx"][-1] / 1e4, 1, delta=0.05)
        for kind, more, words in (("sliding-elastic", "<tension>1</tension>", "<tension> has no counterpart"), ("sticky", "", "this kind of interface has no counterpart"),
                                  ("sliding-elastic", '<fric_coeff lc="1">0.3</fric_coeff>', "<fric_coeff> follows a load curve")):
            _, said = self.convert("cubes.feb", contact(kind, more))
            self.assertIn(words, said)
            self.assertIn("not complete", said)

    def test_errors(self):
        def fails(text, words, name="cube.inp", status=2):
            self.write(name, text)
            done = self.call("convert", name, "--force")
            self.assertEqual((done.returncode, done.stdout, done.stderr.count("\n")), (status, "", 1), done.stderr)
            self.assertRegex(done.stderr, "^pliant convert: " + words)

        good = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1))
        fails("hello\n", "cube.inp:1: the file begins with data")
        fails(good.replace("14, 1, 3, 1", "14, one, 3, 1"), "cube.inp:9: a coordinate is missing or not a number: 'one'")
        fails(good.replace("15, 16\n", "15, 99\n"), "cube.inp:13: node 99 of element 1 is not defined")
        fails(good.replace("right1, 1, 1", "rihgt1, 1, 1"), "cube.inp:\\d+: the set of nodes 'rihgt1' is not defined before this line \\(did you mean 'right1'\\?\\)\n")
        fails(good.replace("MATERIAL=rubber1\n*S", "MATERIAL=steel\n*S"), "cube.inp:\\d+: the material 'steel' is not defined\n")
        fails(good.replace("MATERIAL=rubber1\n*S", "MATERIAL=Rubbr1\n*S"), "cube.inp:\\d+: the material 'Rubbr1' is not defined \\(did you mean 'rubber1'\\?\\)\n")
        fails(good.replace("*SOLID SECTION, ELSET=cube1", "*SOLID SECTION, ELSET=CBUE1"), "cube.inp:\\d+: the set of elements 'CBUE1' is not defined \\(did you mean 'cube1'\\?\\)\n")
        fails(good + "*NSET, NSET=all, ELSET=cub1\n", "cube.inp:\\d+: 'cub1' is neither a number nor the name of a set of elements before this line \\(did you mean 'cube1'\\?\\)\n")
        for kind in ("S4", "C3D8X"):
            fails(good.replace("C3D8", kind), f"cube.inp: no solid elements .* have a material; elements of types without a counterpart: 1 {kind}\n")
        fails(good.replace("C3D8", "C3D10"), "cube.inp:\\d+: element 1 has 8 nodes, and one of type C3D10 has 10\n")
        fails(good.replace(", MATERIAL=rubber1\n*S", "\n*S"), "cube.inp:\\d+: \\*SOLID SECTION of cube1 names no material")
        fails(good.replace("left1, 1\n", "left1, XSYM\n"), "cube.inp:\\d+: 'XSYM' is not a support \\(did you mean 'XSYMM'\\?\\)\n")
        fails(good.replace("right1, 1, 1", "part-1-1.right1, 1, 1"), "cube.inp:\\d+: .*did you mean 'right1'\\?\\)\n")
        fails("<febio_spec", "cube.feb:1: not an XML file", "cube.feb")
        fails('<febio_spec version="1.2"/>', "cube.feb:1: the version 1.2 is too old", "cube.feb")
        fails('<febio_spec version="4.0"><Module type="biphasic"/></febio_spec>', "cube.feb:1: the module 'biphasic' is not supported", "cube.feb")
        fails(febio_cubes([FEBIO["Yeoh"][0]], "").replace('mat="rubber1"', 'mat="gel"'), "cube.feb:\\d+: the material 'gel' of cube1 is not defined\n", "cube.feb")
        fails(febio_cubes([FEBIO["Yeoh"][0]], "").replace('mat="rubber1"', 'mat="ruber1"'), "cube.feb:\\d+: the material 'ruber1' of cube1 is not defined \\(did you mean 'rubber1'\\?\\)\n", "cube.feb")
        fails("", "cube.vtk: the name must end in .inp", "cube.vtk")
        self.write("cube.inp", good)
        self.write("cube.yaml", "mine")
        done = self.call("convert", "cube.inp")
        self.assertEqual((done.returncode, (self.directory / "cube.yaml").read_text()), (2, "mine"))
        self.assertIn("cube.yaml exists: name another file with --output, or replace it with --force", done.stderr)
        self.assertEqual(self.call("convert", "cube.inp", "-o", "missing/cube.yaml").returncode, 4)

    def test_nodes_that_coincide_have_the_numbers_of_the_deck(self):
        two = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"] * 2, pulled(2))
        moved = re.sub(r"^(1[789]|2[0-4]), (\d), (\d), (\d)$", lambda m: f"{m[1]}, {m[2]}, {int(m[3]) - 2}, {m[4]}", two, flags=re.MULTILINE)
        _, said = self.convert("cubes.inp", moved)
        self.assertIn("cubes.inp: 4 nodes lie where others do (17 on 12, 18 on 11, 21 on 16, 22 on 15): the parts that meet there are not joined", said)
        _, said = self.convert("cubes.inp", two)
        self.assertNotIn("lie where others do", said)

    def test_sets_that_no_user_has_made_are_no_volumes(self):
        text = abaqus_cubes([next(iter(ABAQUS.values()))[0]], pulled(1), "*ELSET, ELSET=_top_S1, INTERNAL\n1\n*ELSET, ELSET=mine\n1\n")
        self.convert("cubes.inp", text)
        mesh = (self.directory / "cubes.msh").read_text()
        self.assertIn('"mine"', mesh)
        self.assertNotIn("_top_S1", mesh)

    def test_damaged_files(self):
        """Whatever stands in a file, it is converted, or refused with an exception that has its name."""
        models = {"x.inp": abaqus_cubes([material for material, _ in ABAQUS.values()][:3], pulled(2) + "*DLOAD\ncube1, P4, 2e-3\n*CLOAD\nright3, 1, 1.\n",
                                        "*AMPLITUDE, NAME=a\n0, 0, 1, 1\n*NSET, NSET=g, GENERATE\n9, 30, 1\n*TIE, NAME=t\nend1, end2\n*NODE\n500, 1, 9, 0\n*COUPLING, REF NODE=500, SURFACE=end3\n*KINEMATIC\n"),
                  "y.inp": abaqus_cubes(["*ELASTIC\n1e6, 0.3\n*VISCOELASTIC, TIME=PRONY\n0.4, 0.4, 0.5\n"], pulled(1) + "*DLOAD\ncube1, GRAV, 1., 0, 0, 1\n*CLOAD\n10, 2, 1.\n" + step(
                      "*BOUNDARY, OP=NEW\nleft1, 1\nright1, 1, 1, 0.2\n*DLOAD\ncube1, GRAV, 2., 0, 1, 0\n*CLOAD, OP=NEW\nright1, 2, 3.\n"), '*SURFACE, NAME="b c", COMBINE=UNION\nend1\n'),
                  "x.feb": febio_cubes([constants for constants, _ in FEBIO.values()][:3], febio_pull(2),
                                       '<surface_load type="pressure" surface="end1"><pressure lc="1">4</pressure></surface_load>\n'),
                  "y.feb": Febio.glued(Febio, '<rigid_bc type="rigid_fixed"><rb>2</rb><Rx_dof>1</Rx_dof></rigid_bc><rigid_load type="rigid_force"><rb>2</rb><dof>Ry</dof><value lc="1">1</value>'
                                       "</rigid_load>", "<center_of_mass>1,2,3</center_of_mass>").replace("<points>", "<extend>REPEAT</extend><points>").replace("<pt>1,1<", "<pt>0.5,1<")}
        some, refused = random.Random(7), 0
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.directory)
        for _ in range(2000 if LONG else 150):
            name = some.choice(list(models))
            lines = models[name].split("\n")
            for _ in range(some.randint(1, 3)):
                i = some.randrange(len(lines))
                at = some.randrange(len(lines[i]) + 1)
                lines[i] = some.choice(["", lines[some.randrange(len(lines))], lines[i][:at] + some.choice("0-,.*=<>/aZ\"9e") + lines[i][at + 1:], lines[i][:at],
                                        lines[i].replace(some.choice("0123456789"), some.choice(["", "-1", "nan", "1e999", "999999999999", "x"]))])
            self.write(name, "\n".join(lines))
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                try:
                    converter.convert(converter.parser_of("pliant convert").parse_args([name, "--force"]))
                except PliantError as error:
                    self.assertTrue(str(error).startswith(name), error)
                    refused += 1
        self.assertGreater(refused, 50)


class Decks(ConvertTest):
    """Files of Abaqus as editors and programs write them."""

    def test_marks_of_files(self):
        """A byte order mark, line ends of Windows, tabs, comments and capitals change nothing."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1))
        usual, _ = self.convert("cubes.inp", text)
        other = text.lower().replace("1, 9, 10", "1,\t9,\n** a comment\n10").replace("type=c3d8, ", "type = C3D8 ,\n** another, with a comma,\n")
        for content in ("\ufeff" + other.replace("\n", "\r\n"), other.replace("\n", "\r"), "\ufeff" + other):
            (self.directory / "cubes.inp").write_bytes(content.encode())
            self.pliant("convert", "cubes.inp", "--force")
            self.assertEqual(yaml.safe_load((self.directory / "cubes.yaml").read_text()), usual)
        (self.directory / "cubes.inp").write_bytes(other.encode("utf-16"))
        self.pliant("convert", "cubes.inp", "--force")
        self.assertEqual(yaml.safe_load((self.directory / "cubes.yaml").read_text()), usual)

    def test_quoted_names(self):
        """Names in quotes may have blanks and commas, in parameters and in data."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1) + "*DSLOAD\nend1, P, 2.\n")
        usual, _ = self.convert("cubes.inp", text)
        for name in ("right1", "end1", "left1", "cube1", "rubber1"):
            text = re.sub(rf"\b{name}\b", f'"my, {name}"', text)
        config, _ = self.convert("cubes.inp", text)
        self.assertEqual(config, yaml.safe_load(re.sub(r"\b(right1|end1|left1|cube1)\b", r'"my, \1"', yaml.safe_dump(usual))))
        self.pliant("check", "cubes.yaml")

    def test_names_of_the_converter_are_not_those_of_the_user(self):
        """A user's sets have the names that the converter would give, and other members."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.\n"], "*STATIC\n1., 1.\n*BOUNDARY\nend1, 2, 3\n*DLOAD\ncube1, P4, -1.\n*DSLOAD\ncube1_P4, P, 3.\n*CLOAD\n11, 1, 2.\n14, 1, 5.\nedge, 1, 7\n",
                            "*NSET, NSET=end1\n11\n*NSET, NSET=end1_nodes\n14, 15\n*SURFACE, NAME=cube1_P4\ncube1, S1\n*NSET, NSET=nodes_1\n16\n*NSET, NSET=edge\n10, 11, 15, 13\n"
                            "*NSET, NSET=edge_points\n9\n")
        config, _ = self.convert("cubes.inp", text.replace("*STEP, NLGEOM", "*STEP"))
        self.assertIn({"surface": "cube1_P4_1", "traction": [1, 0, 0]}, config["loads"])
        self.assertIn({"surface": "cube1_P4", "traction": [0, 0, 3]}, config["loads"])
        self.assertIn({"point": "end1_nodes_2", "name": "end1", "displacement": ["free", 0, 0]}, config["constraints"])
        self.assertAlmostEqual(self.history("cubes.yaml")["left1_fx"][-1], -1 - 2 - 5 - 4 * 7, delta=1e-6)
        second = febio_cubes([("neo-Hookean", "<E>1e6</E><v>0.3</v>")], "").replace("<Surface", '<NodeSet name="left1">9</NodeSet><Surface')
        self.fails(second, "cubes.feb:\\d+: a second NodeSet has the name 'left1'", "cubes.feb")

    def test_other_files(self):
        """They are next to the deck, or to the file that names them; data may come from a file of their own."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1))
        usual, _ = self.convert("cubes.inp", text)
        nodes = re.search(r"(?s)\*NODE\n(.*?)\*ELEMENT", text)[1]
        material = re.search(r"(?s)\*MATERIAL.*?(?=\*SOLID)", text)[0]
        self.directory.joinpath("deck/parts").mkdir(parents=True)
        self.write("deck/parts/nodes.txt", nodes)
        self.write("deck/parts/material.inp", "*INCLUDE, INPUT=law.inp\n")
        self.write("deck/parts/law.inp", material)
        self.write("deck/cubes.inp", text.replace(f"*NODE\n{nodes}", "*NODE, INPUT=parts/nodes.txt\n").replace(material, "*INCLUDE, INPUT=parts\\material.inp\n"))
        self.pliant("convert", "deck/cubes.inp", "--force")
        self.assertEqual(yaml.safe_load((self.directory / "cubes.yaml").read_text()), usual)
        self.fails(text.replace(material, "*INCLUDE, INPUT=law.inp\n"), r"cubes.inp:\d+: law.inp: No such file or directory")
        self.fails(text.replace(material, "*INCLUDE\n"), r"cubes.inp:\d+: \*INCLUDE: the name of the file \(INPUT=...\) is missing")

    def test_commas_at_the_end_of_cards(self):
        """Nothing continues them where data follow."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1), "*ELSET, ELSET=g, GENERATE\n1, 99999999\n")
        usual, _ = self.convert("cubes.inp", text)
        for card in ("*ELEMENT, TYPE=C3D8, ELSET=cube1", "*BOUNDARY", "*STATIC", "*NSET, NSET=left1", "*MATERIAL, NAME=rubber1", "*ELASTIC", "GENERATE"):
            self.assertIn(card + "\n", text)
            text = text.replace(card + "\n", card + ",\n")
        self.assertEqual(self.convert("cubes.inp", text)[0], usual)

    def test_numbers_and_names_that_are_not_there(self):
        """Elements and nodes have one meaning; members of sets that the file does not have are named."""
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1) + "*DSLOAD\nend1, P, 2.\n")
        usual, _ = self.convert("cubes.inp", text)
        again = "*ELEMENT, TYPE=C3D8, ELSET=other\n1, 9, 10, 11, 12, 13, 14, 15, 16\n"
        config, said = self.convert("cubes.inp", text.replace("*MATERIAL", again + "*MATERIAL"))
        self.assertEqual((config, "not complete" in said), (usual, False))
        self.fails(text.replace("*MATERIAL", again.replace("9, 10, 11, 12", "10, 11, 12, 9") + "*MATERIAL"), r"cubes.inp:\d+: a second element has the number 1")
        _, said = self.convert("cubes.inp", text.replace("NSET=left1\n", "NSET=left1\n99, "))
        self.assertIn("*NSET: 1 of its numbers, the first one 99, are not nodes of the file", said)
        self.fails(text.replace("end1, P", "ned1, P"), r"cubes.inp:\d+: the surface 'ned1' is not defined before this line")
        self.fails("*PARAMETER\na = 1.\n" + text, r"cubes.inp:1: \*PARAMETER: names of numbers are not supported")
        self.fails(text.replace("right1, 1, 1", "right1, 3, 1"), r"cubes.inp:\d+: the last degree of freedom, 1, is below the first, 3")
        joined = text.replace("*MATERIAL", "*SURFACE, NAME=both, COMBINE=UNION\nend1, end1\n*MATERIAL").replace("end1, P", "both, P")
        self.assertEqual(self.convert("cubes.inp", joined)[0]["loads"], [{"surface": "both", "pressure": "2*t"}])
        _, said = self.convert("cubes.inp", joined.replace("UNION", "DIFFERENCE"))
        self.assertIn("*DLOAD of the type NEWTON", self.convert("cubes.inp", text.replace("*DSLOAD\nend1, P, 2.", "*DLOAD\ncube1, NEWTON"))[1])
        self.assertIn("*SURFACE, COMBINE=DIFFERENCE: give its faces one by one", said)
        self.assertIn("*DSLOAD of the type P on both, which has no elements of the input: left out", said)
        febio = febio_cubes([FEBIO["Yeoh"][0]], "")
        self.fails(febio.replace('node id="10"', 'node id="9"'), "cubes.feb:\\d+: a second node has the number 9", "cubes.feb")
        self.fails(re.sub(r"(<elem .*?</elem>)", r"\1\1", febio), "cubes.feb:\\d+: a second element has the number 1", "cubes.feb")

    def test_what_changes_the_result_is_not_complete(self):
        text = abaqus_cubes(["*ELASTIC\n1e6, 0.3\n"], pulled(1))
        for card, is_complete in (("*ORIENTATION, NAME=o\n1, 0, 0, 0, 1, 0\n", True), ("*SPRING, ELSET=s\n\n1.\n", False), ("*PLASTIC\n1e3, 0.\n", False), ("*MPC\nBEAM, 9, 10\n", False),
                                  ("*EXPANSION, TYPE=ORTHO\n1e-5, 1e-5, 2e-5\n", False), ("*ELEMENT, TYPE=S4\n7, 9, 10, 11, 12\n", False),
                                  ("*ELEMENT, TYPE=C3D8X\n7, 9, 10, 11, 12, 13, 14, 15, 16\n", False), ("*EMBEDDED ELEMENT\ncube1\n", False)):
            _, said = self.convert("cubes.inp", text.replace("*SOLID SECTION", card + "*SOLID SECTION"))
            self.assertIn("elements of types" if "*ELEMENT" in card else card.split(",")[0].split("\n")[0], said)
            self.assertEqual("not complete" in said, not is_complete, said)


def step(content, procedure="*STATIC\n0.5, 1."):
    return f"*END STEP\n*STEP, NLGEOM\n{procedure}\n{content}"


class Steps(ConvertTest):
    """What steps of Abaqus and CalculiX begin, change and end."""

    STIFF = "*ELASTIC\n1e9, 0.\n*DENSITY\n2.\n"

    def reactions(self, column, times):
        history = self.history("cubes.yaml")
        return [history[column][np.flatnonzero(np.abs(history["time"] - t) < 1e-9)[0]] for t in times]

    def test_displacements_that_begin_or_end_in_a_later_step(self):
        """They cannot be written, and are named; those of nodes that are held already change."""
        first = "*STATIC\n0.5, 1.\n*CLOAD\nright1, 1, 1e5\n"
        config, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], first + step("*BOUNDARY\nright1, 1, 3, 0.1\n")))
        self.assertIn("*BOUNDARY on right1 (degrees of freedom 1, 2, 3) begins at t = 1: a constraint holds from the start of a run, and this one is left out", said)
        self.assertIn("not complete", said)
        self.assertEqual([c["surface"] for c in config["constraints"]], ["left1", "front1", "bottom1"])
        both = "*BOUNDARY\nright1, 1, 1, 0.1\nright1, 2, 2, 0.\n"
        _, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], first + both + step("*BOUNDARY, OP=NEW\nleft1, 1\nfront1, 2\nbottom1, 3\nright1, 1, 1, 0.2\n")))
        self.assertIn("*BOUNDARY, OP=NEW releases the displacements of right1 in y at t = 1", said)
        self.assertNotIn("displacements of left1", said)
        config, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], pulled(1, 0.1) + step("*BOUNDARY, FIXED\nright1, 1\n") + step("*BOUNDARY\n10, 1, 1, 0.3\n")))
        self.assertNotIn("not complete", said)
        displaced = [(c.get("surface") or c["name"], c["displacement"][0]) for c in config["constraints"] if c["displacement"][0] != "free"][1:]
        self.assertEqual(sorted(displaced), [("nodes_1", "t < 1 ? 0.1*t : t < 2 ? 0.1 : 0.1 + 0.2*(t - 2)"), ("right1_1", "t < 1 ? 0.1*t : 0.1")])
        self.assertIn("3 nodes of right1 keep its displacement in x", said)

    def test_forces_belong_to_nodes(self):
        """Forces of one step add up, and those of a later one replace the node's, whatever the names: CalculiX 2.20 has these reactions."""
        loads = "*STATIC\n1., 1.\n*NSET, NSET=two\n10, 11\n*CLOAD\n10, 1, 1.\n10, 1, 2.\ntwo, 1, 10.\n" + step("*CLOAD\n10, 1, 3.\n") + step("*CLOAD, OP=NEW\n11, 1, 5.\n")
        self.convert("cubes.inp", abaqus_cubes([self.STIFF], loads))
        np.testing.assert_allclose(self.reactions("left1_fx", [1, 2, 2.5, 3]), [-23, -13, -9, -5], rtol=1e-6)

    def test_loads_change_and_end(self):
        """OP=NEW removes the loads of its keyword; a load in another direction, or on a surface of another name, replaces the earlier one."""
        loads = ("*STATIC\n1., 1.\n*SURFACE, NAME=same\ncube1, S4\n*DLOAD\ncube1, GRAV, 10., 1., 0., 0.\n*DSLOAD, FOLLOWER=NO\nend1, TRVEC, 7., 1., 0., 0.\n"
                 + step("*DLOAD\ncube1, GRAV, 5., -1., 0., 0.\n*DSLOAD, FOLLOWER=NO\nsame, TRVEC, 8., 1., 0., 0.\n") + step("*DLOAD\ncube1, GRAV, 4., 0., 1., 0.\n")
                 + step("*DLOAD, OP=NEW\ncube1, BX, 3.\n") + step("*DSLOAD, OP=NEW\n"))
        config, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], loads))
        self.assertEqual(len(config["loads"]), 3)
        np.testing.assert_allclose(self.reactions("left1_fx", [1, 2, 3, 3.5, 4, 5]), [-27, 2, -8, -9.5, -11, -3], rtol=1e-5)
        self.assertIn("*DLOAD, GRAV on cube1 replaces that of an earlier step, which has another direction, as in Abaqus; CalculiX adds them", said)
        self.assertIn("*DLOAD, OP=NEW: the loads of *DSLOAD of earlier steps remain, as in Abaqus; CalculiX removes them", said)
        loads = "*STATIC\n1., 1.\n*DSLOAD\nend1, P, 7.\n*SURFACE, NAME=both\ncube1, S4\ncube1, S5\n" + step("*DSLOAD\nboth, P, 8.\n")
        config, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], loads))
        self.assertIn("*DSLOAD on a part of what has such a load of an earlier step by another name: left out", said)
        self.assertEqual(len(config["loads"]), 1)

    def test_steps_follow_one_another(self):
        """A step without its end would begin at the same time as the next one."""
        steps = pulled(1) + step("")
        self.fails(abaqus_cubes([self.STIFF], steps.replace("*END STEP\n", "")), r"cubes.inp:\d+: the step before this one, of line \d+, has no \*END STEP")
        self.fails("*RESTART, READ, STEP=1\n" + abaqus_cubes([self.STIFF], steps), r"cubes.inp:1: \*RESTART, READ: the model is in the files of another run")
        _, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], steps).replace("*STEP, NLGEOM", "*STEP", 1))
        self.assertIn("*STEP, NLGEOM: displacements are large in the input from the first step on", said)
        _, said = self.convert("cubes.inp", abaqus_cubes(["*HYPERELASTIC, NEO HOOKE\n1e5, 2e-6\n"], steps).replace("*STEP, NLGEOM", "*STEP"))
        self.assertIn("no step has NLGEOM: displacements are large in the input", said)

    def test_perturbations_are_runs_of_their_own(self):
        steps = "*STATIC\n1., 1.\n*CLOAD\n10, 1, 1.\n*END STEP\n*STEP, PERTURBATION\n*STATIC\n*CLOAD\n10, 1, 2.\n"
        config, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], steps))
        self.assertIn("the step with *STEP, and its conditions: a linear perturbation is a run of its own", said)
        self.assertEqual((config["loads"][0]["force"][0], config["time"]["end"]), ("t", 1))
        self.assertIn("not complete", said)

    def test_dropped_steps_are_not_complete(self):
        for procedure, words, is_complete in (("*DYNAMIC\n0.1, 1.", "an input has one method", False), ("*BUCKLE\n3,", "Pliant has no analysis of this kind", False),
                                              ("*FREQUENCY\n3,", "run `pliant modes` on the input", True)):
            _, said = self.convert("cubes.inp", abaqus_cubes([self.STIFF], pulled(1) + step("*CLOAD\n10, 1, 2.\n", procedure)))
            self.assertIn(words, said)
            self.assertEqual("not complete" not in said, is_complete, said)

    def test_tables_of_amplitudes(self):
        def amplitude(data, parameters=""):
            return abaqus_cubes([self.STIFF], "*STATIC\n0.25, 4.\n*BOUNDARY, AMPLITUDE=a\nright1, 1, 1, 0.1\n", f"*AMPLITUDE, NAME=a{parameters}\n{data}\n")

        config, _ = self.convert("cubes.inp", amplitude("0, 1, 2, 3,\n3, 4", ", SHIFTX=1, SHIFTY=-1"))
        self.assertEqual(config["constraints"][-1]["displacement"][0], "t < 1 ? 0 : t < 3 ? 0.1*(t - 1) : 0.2 + 0.1*(t - 3)")
        for data, words in (("0, 0, 1,", "\\*AMPLITUDE a: a line has pairs of a time and a value, not 3 numbers"), ("0, 0, , 1", "a time of the amplitude is missing"),
                            ("0, 0, 1, ,2, 1", "a value of the amplitude is missing"), ("0, 0, 2, 1, 1, 0", "\\*AMPLITUDE a: its times must not decrease: 1 follows 2")):
            self.fails(amplitude(data), rf"cubes.inp:\d+: {words}")
        _, said = self.convert("cubes.inp", amplitude("0, 0, 1, 1", ", VALUE=ABSOLUTE"))
        self.assertIn("*AMPLITUDE, VALUE=ABSOLUTE: write its formula of t", said)

    def test_a_model_without_steps_is_static(self):
        model = abaqus_cubes(["*HYPERELASTIC, NEO HOOKE\n1e5, 2e-5\n"], "", "*AMPLITUDE, NAME=ramp\n0., 0., 1., 1.\n*DSLOAD, AMPLITUDE=ramp\nend1, P, 10.\n")
        _, said = self.convert("cubes.inp", model.replace("*STEP, NLGEOM\n*END STEP\n", ""))
        self.assertIn("no step is static or dynamic: the input is static", said)
        made = yaml.safe_load((self.directory / "cubes.yaml").read_text())
        self.assertEqual(made["time"], {"method": "static"})
        self.assertEqual(made["loads"][0]["pressure"], 10)
        self.pliant("check", "cubes.yaml")

    def test_static_steps_do_not_relax(self):
        """They have the moduli of fast motion, or at rest with LONG TERM; what damps motion has no effect."""
        def materials(moduli):
            return [law.replace("\n", f", MODULI={moduli}\n", 1) + "*VISCOELASTIC, TIME=PRONY\n0.4, 0.4, 0.5\n*DAMPING, ALPHA=2., BETA=0.1\n"
                    for law in ("*HYPERELASTIC, NEO HOOKE\n1e5, 2e-5\n", "*ELASTIC\n1e6, 0.3\n")]

        for moduli, procedure, factor in (("LONG TERM", "*STATIC", 1 / 0.6), ("INSTANTANEOUS", "*STATIC", 1), ("LONG TERM", "*STATIC, LONG TERM", 1),
                                          ("INSTANTANEOUS", "*STATIC, LONG TERM", 0.6)):
            with self.subTest((moduli, procedure)):
                config, said = self.convert("cubes.inp", abaqus_cubes(materials(moduli), pulled(2).replace("*STATIC", procedure)))
                hyper, linear = (body["elasticity"] for body in config["bodies"])
                np.testing.assert_allclose([hyper["shear_modulus"], hyper["bulk_modulus"], linear["youngs_modulus"], linear["poissons_ratio"]],
                                           [2e5 * factor, 1e5 * factor, 1e6 * factor, 0.3], rtol=1e-9)
                self.assertFalse(any("viscosity" in body for body in config["bodies"]))
                self.assertIn("*VISCOELASTIC: static steps with", said)
                self.assertIn("*DAMPING acts in motion only", said)
        config, said = self.convert("cubes.inp", abaqus_cubes(materials("LONG TERM"), pulled(2) + step("", "*VISCO, CETOL=1\n0.1, 1.")))
        self.assertEqual(config["bodies"][0]["viscosity"][0]["model"], "prony")
        self.assertIn("the material relaxes in the static steps, too", said)
        config, _ = self.convert("cubes.inp", abaqus_cubes(materials("LONG TERM"), pulled(2).replace("*STATIC", "*DYNAMIC")))
        self.assertEqual([branch["model"] for branch in config["bodies"][0]["viscosity"]], ["mass-proportional", "stiffness-proportional", "prony"])


class References(ConvertTest):
    """Conditions on nodes through which a rigid body or a coupling moves."""

    MORE = "*NODE, NSET=ref\n500, 1.2, 3.5, 0.5\n*COUPLING, CONSTRAINT NAME=c, REF NODE=ref, SURFACE=end1\n"

    def test_a_displacement_has_the_force_that_makes_it(self):
        rubber = "*HYPERELASTIC, NEO HOOKE\n1e5, 2e-5\n"
        guided = "*BOUNDARY\nref, 2, 6\n"
        config, said = self.convert("cubes.inp", abaqus_cubes([rubber], f"*STATIC\n0.5, 1.\n{guided}ref, 1, 1, 0.2\n", self.MORE + "*KINEMATIC\n"))
        self.assertNotIn("not complete", said)
        self.assertIn({"surface": "end1", "name": "ref", "rigid": {"translation": ["0.2*t", 0, 0], "rotation": "fixed", "center": [1.2, 3.5, 0.5]}}, config["constraints"])
        force = self.history("cubes.yaml")["ref_fx"][-1]
        for kind, delta in (("*KINEMATIC\n1, 6\n", 1e-7), ("*DISTRIBUTING\n", 0.02)):
            _, said = self.convert("cubes.inp", abaqus_cubes([rubber], f"*STATIC\n0.5, 1.\n{guided}*CLOAD\n500, 1, {force}\n", self.MORE + kind))
            self.assertNotIn("not complete", said)
            self.assertAlmostEqual(self.history("cubes.yaml")["ref_x"][-1] - 1.2, 0.2, delta=delta)

    def test_sets_of_nodes_with_a_force(self):
        """They are attached if they are one surface."""
        rigid = "*NODE, NSET=ref\n500, 1., 3., 0.\n*NSET, NSET=two\n10, 15\n*RIGID BODY, REF NODE=ref, TIE NSET={}\n"
        for name, is_surface in (("right1", True), ("two", False)):
            config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], "*STATIC\n0.5, 1.\n*CLOAD\nref, 1, 2.\n", rigid.format(name)))
            self.assertEqual(config.get("rigid_bodies"), [{"name": "ref", "center": [1, 3, 0], "attached": ["right1"]}] if is_surface else None)
            self.assertEqual(config.get("loads"), [{"force": ["2*t", 0, 0], "volume": "ref"}] if is_surface else None)
            self.assertEqual("the nodes of two move with a reference node in the model, and are not one surface or volume" in said, not is_surface)

    def test_two_couplings_of_one_node(self):
        """Both have its motion; where it is free they are parts of their own, which is said."""
        both = "*NODE, NSET=ref\n500, 1.2, 3.5, 0.5\n" + "".join(
            f"*COUPLING, CONSTRAINT NAME=c{k}, REF NODE=ref, SURFACE=end{k}\n*KINEMATIC\n" for k in (1, 2))
        for conditions, is_free in (("*BOUNDARY\nref, 2, 6\nref, 1, 1, 0.2\n", False), ("*BOUNDARY\nref, 2, 6\n*CLOAD\nref, 1, 2.\n", True)):
            config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"] * 2, "*STATIC\n0.5, 1.\n" + conditions, both))
            rigid = [c["rigid"]["translation"][0] for c in config["constraints"] if "rigid" in c]
            self.assertEqual(len(rigid), 2)
            self.assertEqual(set(rigid), {"free" if is_free else "0.2*t"})
            self.assertEqual("shares its reference node" in said, is_free)
            self.assertEqual(len(config.get("loads", [])), 1 if is_free else 0)

    def test_a_reference_node_of_an_element(self):
        rigid = "*RIGID BODY, REF NODE=10, TIE NSET=right1\n"
        config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], "*STATIC\n0.5, 1.\n*CLOAD\n10, 1, 2.\n", rigid))
        self.assertNotIn("belongs to no element", said)
        self.assertEqual([load["force"] for load in config["loads"]], [["2*t", 0, 0]])

    def test_rotations(self):
        rigid = "*NODE, NSET=ref\n500, 1., 3., 0.\n*RIGID BODY, REF NODE=500, TIE NSET=right1\n"
        for conditions, expected in (("ref, 1, 6\n", "fixed"), ("ref, 1, 5\nref, 6, 6, 0.3\n", {"axis": [0, 0, 1], "angle": "0.3*t"}), ("ref, 1, 5\n", {"axis": [0, 0, 1], "angle": "free"}),
                                     ("ref, 1, 3\n", "free"), ("ref, 1, 4\n", None), ("ref, 1, 4\nref, 5, 6, 0.1\n", None)):
            with self.subTest(conditions):
                config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], "*STATIC\n0.5, 1.\n*BOUNDARY\n" + conditions, rigid))
                found = [c["rigid"]["rotation"] for c in config["constraints"] if "rigid" in c]
                self.assertEqual(found, [] if expected is None else [expected])
                self.assertEqual("rotations about several axes" in said, expected is None)

    def test_reference_points_of_an_assembly(self):
        """Numbers of the assembly are not those of the part."""
        flat = abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], "")
        mesh = re.search(r"(?s)\*NODE.*?(?=\*SURFACE)", flat)[0]
        sets = "".join(f"*NSET, NSET={name}1, INSTANCE=one\n{', '.join(str(8 + n) for n in of)}\n" for name, of in SIDES.items())
        text = (f"*PART, NAME=p\n{mesh}*SOLID SECTION, ELSET=cube1, MATERIAL=m\n*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=one, PART=p\n*END INSTANCE\n"
                f"*NODE\n9, 1., 3.5, 0.5\n*NSET, NSET=RP\n9\n{sets}*ELSET, ELSET=_end_S4, INTERNAL, INSTANCE=one\n1\n*SURFACE, NAME=end1\n_end_S4, S4\n"
                "*COUPLING, CONSTRAINT NAME=c, REF NODE=RP, SURFACE=end1\n*KINEMATIC\n*END ASSEMBLY\n*MATERIAL, NAME=m\n*ELASTIC\n1e5, 0.3\n*BOUNDARY\nleft1, 1\nfront1, 2\nbottom1, 3\n"
                "*STEP, NLGEOM\n*STATIC\n0.5, 1.\n*BOUNDARY\n9, 1, 1, 0.1\n{}*END STEP\n")
        config, said = self.convert("cubes.inp", text.replace("{}", "RP, 2, 6\n"))
        self.assertNotIn("not complete", said)
        self.assertIn({"surface": "end1", "name": "RP", "rigid": {"translation": ["0.1*t", 0, 0], "rotation": "fixed", "center": [1, 3.5, 0.5]}}, config["constraints"])
        config, said = self.convert("cubes.inp", text.replace("{}", "one.9, 2, 2, 0.1\n").replace("*COUPLING, CONSTRAINT NAME=c, REF NODE=RP, SURFACE=end1\n*KINEMATIC\n", ""))
        self.assertIn("*BOUNDARY on node 9, which belongs to no element of the input, and to no rigid part or coupling that it has: left out", said)
        self.assertEqual(config["constraints"][-1]["displacement"], ["free", "0.1*t", "free"])

    def test_an_instance_is_where_the_assembly_has_it(self):
        """Translated by one in y, and rotated by 90 degrees about the z-axis through (0, 4, 0): its x-axis becomes y."""
        flat = abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], pulled(1) + "*DLOAD\ncube1, BX, 2.\n")
        part = re.search(r"(?s)\*NODE.*?(?=\*BOUNDARY)", flat)[0] + "*SOLID SECTION, ELSET=cube1, MATERIAL=rubber1\n"
        steps = re.sub(r"\*SOLID.*\n", "", flat[flat.index("*BOUNDARY"):]).replace("1, 1\nfront", "1, 2\nfront").replace("front1, 2", "front1, 1").replace("right1, 1, 1", "right1, 2, 2")
        steps = re.sub(r"\b(left|right|front|bottom|cube)1,", r"one.\g<1>1,", steps)
        text = f"*PART, NAME=p\n{part}*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=one, PART=p\n0., 1., 0.\n0., 4., 0., 0., 4., 2., 90.\n*END INSTANCE\n*END ASSEMBLY\n{steps}"
        self.convert("cubes.inp", text)
        nodes = re.search(r"(?s)\$Nodes\n.*?\$EndNodes", (self.directory / "cubes.msh").read_text())[0]
        points = np.array([[float(x) for x in line.split()] for line in nodes.split("\n") if line.count(" ") == 2])
        np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [[-1, 4, 0], [0, 5, 1]], atol=1e-12)
        self.assertAlmostEqual(self.history("cubes.yaml", "probes=[{name: tip, point: [0, 5, 0]}]")["tip_uy"][-1], 0.4, delta=1e-9)
        self.fails(text.replace("0., 4., 2., 90.", "0., 4., 0., 90."), r"cubes.inp:\d+: a rotation of an instance has two different points on its axis")

    def test_several_instances(self):
        """Two bricks of one part, the second rotated by 180 degrees about an axis between them, and tied to the first: they are one bar."""
        material, energy = ABAQUS["neo-Hooke"]
        flat = abaqus_cubes([material], "")
        part = re.search(r"(?s)\*NODE.*?(?=\*BOUNDARY)", flat)[0] + "*SOLID SECTION, ELSET=cube1, MATERIAL=m\n"
        text = (f"*PART, NAME=p\n{part}*END PART\n*PART, NAME=unused\n*NODE\n1, 0, 0, 0\n*END PART\n*ASSEMBLY, NAME=a\n*INSTANCE, NAME=one, PART=P\n*END INSTANCE\n"
                "*INSTANCE, NAME=two, PART=p\n0., 0., 0.\n1., 3.5, 0., 1., 3.5, 1., 180.\n*END INSTANCE\n*NSET, NSET=grip, INSTANCE=two\n9, 12, 13, 16\n"
                "*ELSET, ELSET=_both, INSTANCE=one, INTERNAL\n1\n*ELSET, ELSET=_both, INSTANCE=two, INTERNAL\n1\n*TIE, NAME=t\ntwo.end1, one.end1\n*END ASSEMBLY\n"
                f"*MATERIAL, NAME=m\n{material}*BOUNDARY\none.left1, 1\none.front1, 2\nONE.bottom1, 3\ntwo.Bottom1, 3\n*STEP, NLGEOM\n*STATIC\n0.25, 1.\n*BOUNDARY\ngrip, 1, 1, 0.8\n*END STEP\n")
        config, said = self.convert("cubes.inp", text)
        self.assertNotIn("not complete", said)
        self.assertEqual([body["volume"] for body in config["bodies"]], ["one_cube1", "two_cube1"])
        self.assertIn({"surface": "two_end1", "tied_to": "one_end1"}, config["constraints"])
        history = self.history("cubes.yaml")
        self.assertAlmostEqual(history["grip_fx"][-1] / uniaxial_force(energy), 1, delta=2e-6)
        one_node = text.replace("grip, 1, 1, 0.8\n", "one.10, 2, 2, 0.1\n")
        self.assertEqual(self.convert("cubes.inp", one_node)[0]["constraints"][-1]["displacement"], ["free", "0.1*t", "free"])
        for change, words in ((("PART=P", "PART=q"), "the part 'q' of the instance 'one' is not defined"), (("NAME=two", "NAME=One"), "a second instance has the name 'One'"),
                              (("NAME=unused", "NAME=p"), "a second part has the name 'p'")):
            self.fails(text.replace(*change), rf"cubes.inp:\d+: {words}")

    def test_what_has_no_counterpart_is_listed(self):
        for kind, words in (("*KINEMATIC\n1, 1\n", "*KINEMATIC of some degrees of freedom"), ("", "node 500, which belongs to no element")):
            config, said = self.convert("cubes.inp", abaqus_cubes(["*ELASTIC\n1e5, 0.3\n"], "*STATIC\n0.5, 1.\n*CLOAD\n500, 1, 1.\n", self.MORE + kind))
            self.assertIn(words, said)
            self.assertIn("not complete", said)
            self.assertNotIn("loads", config)


class Febio(ConvertTest):
    """Steps, load curves and sections of FEBio."""

    CUBE = [("neo-Hookean", "<density>1</density><E>1e6</E><v>0.3</v>")]
    CONTROL = "<Control><analysis>STATIC</analysis><time_steps>2</time_steps><step_size>0.5</step_size></Control>"

    def steps(self, *contents):
        steps = "".join(f'<step id="{k}">{self.CONTROL}{content}</step>' for k, content in enumerate(contents, 1))
        return re.sub(r"<Control>.*?</Control>\n", "", febio_cubes(self.CUBE, ""), count=1).replace("</febio_spec>", f"<Step>{steps}</Step></febio_spec>")

    @staticmethod
    def pull(value, more=""):
        return f'<Boundary><bc type="prescribed displacement" node_set="right1"><dof>x</dof><value lc="1">{value}</value>{more}</bc></Boundary>'

    def test_displacements_of_steps(self):
        """Those that begin or end in a step on the way are named; relative ones start where the step before ends."""
        _, said = self.convert("cubes.feb", self.steps(self.pull(0.1), self.pull(0.2), ""))
        self.assertIn("the displacement of right1 in x is released at the end of its step, t = 2", said)
        config, said = self.convert("cubes.feb", self.steps("", self.pull(0.2)))
        self.assertIn("a displacement of right1 in x that is prescribed from t = 1 on: a constraint holds from the start of a run, and this one is left out", said)
        self.assertEqual(len(config["constraints"]), 3)
        config, said = self.convert("cubes.feb", self.steps(self.pull(0.1), self.pull(0.2, "<relative>1</relative>")).replace("<pt>1,1</pt>", "<pt>1,1</pt><pt>2,3</pt>"))
        self.assertNotIn("not complete", said)
        self.assertEqual(config["constraints"][-1]["displacement"][0], "t < 1 ? 0.1*t : 0.3 + 0.4*(t - 1)")

    def test_controls_and_types(self):
        good = febio_cubes(self.CUBE, febio_pull(1))
        usual, _ = self.convert("cubes.feb", good)
        self.assertEqual(self.convert("cubes.feb", good.replace('type="hex8"', 'type="HEX8G8"'))[0], usual)
        for change, end in ((("<time_steps>4</time_steps>", ""), 2.5), (("<step_size>0.25</step_size>", ""), 0.4), (("<time_steps>4<", "<final_time>3</final_time><time_steps>-1<"), 3)):
            self.assertEqual(self.convert("cubes.feb", good.replace(*change))[0]["time"]["end"], end)
        steps = self.steps(self.pull(0.1), self.pull(0.2))
        for text, words in ((steps.replace(self.CONTROL, "", 1), "a model with steps has one Control in each of them"),
                            (steps.replace("</Module>", "</Module>" + self.CONTROL), "a model with steps has one Control in each of them"),
                            (good.replace("<time_steps>4<", "<time_steps>-1<"), "time_steps and step_size must be above 0")):
            self.fails(text, rf"cubes.feb:\d+: {words}", "cubes.feb")

    def glued(self, rigid, more=""):
        """A soft cube that is held on the left, and a rigid one on its right."""
        text = febio_cubes([*self.CUBE, ("rigid body", f"<density>1000</density>{more}")], "")
        text = text.replace('<elem id="2">17,18,19,20,21,22,23,24</elem>', '<elem id="2">10,18,19,11,14,22,23,15</elem>')
        text = re.sub(r'<node id="(1[789]|2\d)">([\d.]+),([\d.]+),', lambda m: f'<node id="{m[1]}">{float(m[2]) + 1},{float(m[3]) - 3},', text)
        text = re.sub(r'<bc type="zero displacement" node_set="(?!left1).*?</bc>\n', "", text)
        text = text.replace("<x_dof>1</x_dof>", "<x_dof>1</x_dof><y_dof>1</y_dof><z_dof>1</z_dof>")
        return text.replace("<Loads>", f"<Rigid>{rigid}</Rigid><Loads>")

    def test_rigid_bodies(self):
        """A force has the displacement that takes it; a displacement of the older version is the same."""
        guided = '<rigid_bc type="rigid_fixed"><rb>rubber2</rb>' + "".join(f"<R{axis}_dof>1</R{axis}_dof>" for axis in "yzuvw") + "</rigid_bc>"
        move = '<rigid_bc type="rigid_displacement"><rb>2</rb><dof>x</dof><value lc="1">0.2</value></rigid_bc>'
        config, said = self.convert("cubes.feb", self.glued(guided + move))
        self.assertNotIn("not complete", said)
        self.assertEqual(config["bodies"][1], {"volume": "cube2", "density": 1000, "rigid": True})
        motion = {"translation": ["0.2*t", 0, 0], "rotation": "fixed", "center": [1.5, 3.5, 0.5]}
        self.assertEqual(config["constraints"][-1], {"name": "cube2", "volume": "cube2", "rigid": motion})
        force = self.history("cubes.yaml")["cube2_fx"][-1]
        older = (guided + move).replace("rigid_bc", "rigid_constraint").replace("rigid_fixed", "fix").replace("rigid_displacement", "prescribe").replace("<dof>x", "<dof>Rx")
        older = re.sub(r"<Ry_dof>.*?(?=</rigid)", "<dofs>Ry,Rz,Ru,Rv,Rw</dofs>", older, count=1)
        self.assertEqual(self.convert("cubes.feb", self.glued(older))[0], config)
        push = f'<rigid_load type="rigid_force"><rb>2</rb><dof>Rx</dof><value lc="1">{force}</value><load_type>0</load_type></rigid_load>'
        self.convert("cubes.feb", self.glued(guided + push))
        self.assertAlmostEqual(self.history("cubes.yaml")["cube2_x"][-1], 1.7, delta=1e-6)
        turn = '<rigid_bc type="rigid_rotation"><rb>2</rb><dof>Ru</dof><value lc="1">0.3</value></rigid_bc>'
        config, _ = self.convert("cubes.feb", self.glued(guided + turn, "<center_of_mass>1,2,3</center_of_mass>"))
        self.assertEqual(config["constraints"][-1]["rigid"], {"translation": ["free", 0, 0], "rotation": {"axis": [1, 0, 0], "angle": "0.3*t"}, "center": [1, 2, 3]})
        for entry in (push.replace("<load_type>0", "<load_type>1"), push + push, '<rigid_connector type="rigid contractile force"><body_a>2</body_a></rigid_connector>', turn.replace("2</rb>", "7</rb>")):
            _, said = self.convert("cubes.feb", self.glued(guided + entry))
            self.assertIn("it has no counterpart, or stands in one of several steps", said)
            self.assertIn("not complete", said)

    def mechanism(self, connector, section="Rigid"):
        """Two rigid cubes, of which the first is held; the center of the second is at (0.5, 9.5, 0.5)."""
        text = febio_cubes([*self.CUBE, *[("rigid body", "<density>1000</density>")] * 2], "")
        text = re.sub(r'<bc type="zero displacement" node_set="\w+[23]">.*?</bc>\n', "", text)
        held = '<rigid_bc type="rigid_fixed"><rb>rubber2</rb>' + "".join(f"<R{axis}_dof>1</R{axis}_dof>" for axis in "xyzuvw") + "</rigid_bc>"
        both = f"<Rigid>{held}{connector}</Rigid>" if section == "Rigid" else f"<Rigid>{held}</Rigid><{section}>{connector}</{section}>"
        return text.replace("<Loads>", f"{both}<Loads>")

    @staticmethod
    def connector(kind, content, tag="rigid_connector"):
        return f'<{tag} name="j" type="rigid {kind}"><body_a>rubber2</body_a><body_b>3</body_b>{content}<laugon>1</laugon><force_penalty>1e4</force_penalty></{tag}>'

    def test_joints(self):
        """Prescribed rotations and translations are those of the second body; efforts have FEBio's sign."""
        hinge = "<joint_origin>0.5,3.5,0.5</joint_origin><rotation_axis>0,0,1</rotation_axis><transverse_axis>1,0,0</transverse_axis>"
        turned = self.connector("revolute joint", hinge + '<prescribed_rotation>1</prescribed_rotation><rotation lc="1">0.5</rotation><moment>0</moment>')
        config, said = self.convert("cubes.feb", self.mechanism(turned))
        self.assertNotIn("not complete", said)
        self.assertEqual(config["joints"], [{"name": "j", "type": "hinge", "between": ["ground", "cube3"], "point": [0.5, 3.5, 0.5], "axis": [0, 0, 1], "motion": "0.5*t"}])
        history = self.history("cubes.yaml")
        self.assertAlmostEqual(history["j_angle"][-1], 0.5, delta=1e-12)
        self.assertAlmostEqual(history["cube3_x"][-1], 0.5 - 6 * math.sin(0.5), delta=1e-9)
        self.assertEqual(self.convert("cubes.feb", self.mechanism(turned.replace("rigid_connector", "constraint"), "Constraints"))[0], config)
        slide = ('<joint_origin>0.5,3.5,0.5</joint_origin><translation_axis>0,1,0</translation_axis>', '<prescribed_translation>1</prescribed_translation><translation lc="1">0.5</translation>')
        for kind, content, expected in (("prismatic joint", "".join(slide), {"type": "slider", "axis": [0, 1, 0], "motion": "0.5*t"}),
                                        ("prismatic joint", slide[0] + '<prescribed_translation>0</prescribed_translation><force lc="1">2</force>', {"type": "slider", "axis": [0, 1, 0], "motor": {"effort": "-2*t"}}),
                                        ("spherical joint", "<joint_origin>0.5,3.5,0.5</joint_origin><prescribed_rotation>0</prescribed_rotation>", {"type": "ball"}),
                                        ("cylindrical joint", "<joint_origin>0.5,3.5,0.5</joint_origin><joint_axis>0,1,0</joint_axis>", {"type": "cylindrical", "axis": [0, 1, 0]}),
                                        ("planar joint", "<joint_origin>0.5,3.5,0.5</joint_origin><rotation_axis>0,1,0</rotation_axis>", {"type": "planar", "axis": [0, 1, 0]}),
                                        ("lock", "<joint_origin>0.5,3.5,0.5</joint_origin><first_axis>1,0,0</first_axis>", {"type": "fixed"}), ("joint", "<joint>0.5,3.5,0.5</joint>", {"type": "ball"})):
            with self.subTest(kind):
                config, said = self.convert("cubes.feb", self.mechanism(self.connector(kind, content)))
                self.assertNotIn("not complete", said)
                self.assertEqual(config["joints"], [{"name": "j", "between": ["ground", "cube3"], "point": [0.5, 3.5, 0.5], **expected}])
                self.assertIn(f"j: {expected['type']}, ground - cube3", self.pliant("check", "cubes.yaml", "--set", "time.method=bdf2").stdout)
        for content, words in ((self.connector("spherical joint", '<prescribed_rotation>1</prescribed_rotation><rotation_x lc="1">1</rotation_x>'), "<prescribed_rotation> of a rigid spherical joint"),
                               (self.connector("cylindrical joint", ""), "it has no joint_axis"),
                               (self.connector("lock", "") + '<rigid_bc type="rigid_rotation"><rb>3</rb><dof>Ru</dof><value lc="1">0.3</value></rigid_bc>', "the joint j is left out: it connects cube3, whose"), (self.connector("angular damper", "<c>1</c>"), "it has no counterpart"),
                               (self.connector("lock", "").replace("<body_b>3", "<body_b>1"), "body_a and body_b must be rigid bodies")):
            _, said = self.convert("cubes.feb", self.mechanism(content))
            self.assertIn(words, said)
            self.assertIn("not complete", said)

    def test_springs_between_rigid_bodies(self):
        for kind, more, expected in (("spring", "<k>2</k><free_length>0</free_length>", {"stiffness": 2}), ("spring", "<k>2</k><free_length>0.5</free_length>", {"stiffness": 2, "rest": 0.5}),
                                     ("damper", "<c>3</c>", {"damping": 3})):
            text = self.mechanism(self.connector(kind, f"<insertion_a>0.5,4,0.5</insertion_a><insertion_b>0.5,6,0.5</insertion_b>{more}").replace("<laugon>1</laugon><force_penalty>1e4</force_penalty>", ""))
            config, said = self.convert("cubes.feb", text)
            self.assertNotIn("not complete", said)
            self.assertEqual(config["springs"], [{"name": "j", "points": [{"body": "cube2", "point": [0.5, 4, 0.5]}, {"body": "cube3", "point": [0.5, 6, 0.5]}], **expected}])
            self.assertIn("spring", self.pliant("check", "cubes.yaml", "--set", "time.method=bdf2").stdout)

    def test_tied_surfaces(self):
        """The primary surface follows the secondary one: cubes that touch are pulled as one."""
        text = febio_cubes(self.CUBE * 2, '<bc type="prescribed displacement" node_set="right2"><dof>x</dof><value lc="1">0.2</value></bc>')
        text = re.sub(r'<node id="(1[789]|2\d)">([\d.]+),([\d.]+),', lambda m: f'<node id="{m[1]}">{float(m[2]) + 1},{float(m[3]) - 3},', text)
        text = re.sub(r'<bc type="zero displacement" node_set="\w+2">.*?</bc>\n', "", text)
        text = text.replace("</Mesh>", '<Surface name="start2"><quad4 id="1">17,21,24,20</quad4></Surface><SurfacePair name="both"><primary>start2</primary><secondary>end1</secondary></SurfacePair></Mesh>')
        for kind, more, keys in (("tied-elastic", "<penalty>10</penalty>", {}), ("tied-node-on-facet", "<max_distance>0.1</max_distance>", {"tolerance": 0.1})):
            config, said = self.convert("cubes.feb", text.replace("<Loads>", f'<Contact><contact type="{kind}" surface_pair="both">{more}</contact></Contact><Loads>'))
            self.assertNotIn("not complete", said)
            self.assertIn({"surface": "start2", "tied_to": "end1", **keys}, config["constraints"])
            history = self.history("cubes.yaml")
            self.assertAlmostEqual(history["right2_fx"][-1] / -history["left1_fx"][-1], 1, delta=1e-7)
            self.assertGreater(history["right2_fx"][-1], 5e4)
        _, said = self.convert("cubes.feb", text.replace("<Loads>", '<Contact><contact type="tied-elastic" surface_pair="other"/></Contact><Loads>'))
        self.assertIn("the surface pair 'other' has not two surfaces of the mesh", said)

    def test_load_curves(self):
        curve = "<interpolate>LINEAR</interpolate><points><pt>0,0</pt><pt>1,1</pt></points>"
        for interpolate, extend, points, expected in (
                ("LINEAR", "REPEAT", "0,0 0.25,1 0.5,0", "t < 0.25 ? 1.6*t : t < 0.5 ? 0.4 - 1.6*(t - 0.25) : t < 0.75 ? 1.6*(t - 0.5) : 0.4 - 1.6*(t - 0.75)"),
                ("LINEAR", "REPEAT OFFSET", "0,0 0.25,0.5 0.5,1", "t < 0.25 ? 0.8*t : t < 0.5 ? 0.2 + 0.8*(t - 0.25) : t < 0.75 ? 0.4 + 0.8*(t - 0.5) : 0.6 + 0.8*(t - 0.75)"),
                ("LINEAR", "EXTRAPOLATE", "0.25,0 0.5,1", "t < 0.25 ? -0.4 + 1.6*t : t < 0.5 ? 1.6*(t - 0.25) : 0.4 + 1.6*(t - 0.5)"),
                ("LINEAR", "CONSTANT", "0,0 0.5,1", "t < 0.5 ? 0.8*t : 0.4"), ("STEP", "EXTRAPOLATE", "0,0 0.5,1 1,3", "t < 0.5 ? 0.4 : 1.2")):
            with self.subTest((interpolate, extend)):
                table = "".join(f"<pt>{point}</pt>" for point in points.split())
                new = f"<interpolate>{interpolate}</interpolate><extend>{extend}</extend><points>{table}</points>"
                config, said = self.convert("cubes.feb", febio_cubes(self.CUBE, febio_pull(1)).replace(curve, new))
                self.assertNotIn("not complete", said)
                self.assertEqual(config["constraints"][-1]["displacement"][0], expected)
        new = curve.replace("</interpolate>", "</interpolate><extend>REPEAT</extend>").replace("<pt>1,1</pt>", "<pt>0.001,1</pt>")
        _, said = self.convert("cubes.feb", febio_cubes(self.CUBE, febio_pull(1)).replace(curve, new))
        self.assertIn("the load curve 1 repeats more than 50 times", said)

    def test_what_changes_the_result_is_not_complete(self):
        good = febio_cubes(self.CUBE, febio_pull(1))
        for text, words in ((good.replace("</Boundary>", '<bc type="rigid" node_set="left1"><rb>2</rb></bc></Boundary>'), "<bc type=rigid>"),
                            (good.replace("<v>0.3</v>", "<v>0.3</v><prestress>1</prestress>"), "material rubber1: <prestress> of 'neo-Hookean' has no counterpart"),
                            (good.replace("<E>", '<E lc="1">'), "E of a material follows a load curve"),
                            (good.replace("<Loads>", "<Rigid><rigid_bc/></Rigid><Loads>"), "<rigid_bc"),
                            (good.replace("</Mesh>", '</Mesh><MeshData><ElementData var="mat_axis"/></MeshData>'), "<MeshData>")):
            _, said = self.convert("cubes.feb", text)
            self.assertIn(words, said)
            self.assertIn("not complete", said)
        self.fails(good.replace("<Boundary>", '<Boundary from="x.feb">'), "cubes.feb:\\d+: <Boundary> is in another file, 'x.feb'", "cubes.feb")


if __name__ == "__main__":
    unittest.main()
