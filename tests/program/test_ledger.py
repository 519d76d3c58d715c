#!/usr/bin/python3
"""The ledger's columns against energies and losses that numpy finds from the frames, by the laws as the documents have them.

That the columns add up is an identity of the ledger; here none of them is taken from another. Elements are linear: strains are
constant in each cell, and integrals over cells exact. Time is integrated by trapezoids over the steps.
"""
import unittest

import h5py
import numpy as np

from program import ProgramTest, read_history, write_box

MU, LAMBDA, DENSITY = 2e5, 4e5, 1000.0
BULK = LAMBDA + 2 / 3 * MU
G = 9.81
BAR = f"""mesh: {{file: bar.msh}}
bodies:
  - density: {DENSITY}
    elasticity: {{model: saint-venant-kirchhoff, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}
    %s
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
initial: {{velocity: ["2*x", "x*y*20", "-3*x"]}}
time: {{method: dirk33, step: 0.25 ms, end: 40 ms}}
output: {{fields: [displacement, velocity]}}
solver: {{newton: {{relative: 1e-10}}}}
"""


def isotropic(shear, bulk, D):
    trace = np.trace(D, axis1=-2, axis2=-1)
    return 2 * shear * D + (bulk - 2 / 3 * shear) * trace[..., None, None] * np.eye(3)


def double_dot(A, B):
    return (A * B).sum(axis=(-2, -1))


def since_start(power, time):
    """Trapezoids: the integral from the first to each instant."""
    return np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(time))])


class Motion:
    """A motion in linear tetrahedra, from result.h5: arrays over frames, then cells or nodes."""

    def __init__(self, file):
        with h5py.File(file) as h5:
            self.X, self.cells = h5["mesh/coordinates"][()], h5["mesh/cells"][()]
            frames = [h5["frames"][name] for name in sorted(h5["frames"])]
            self.time = np.array([f.attrs["time"] for f in frames])
            self.u, self.v = (np.array([f[field][()] for f in frames]) for field in ("displacement", "velocity"))
        edges = self.X[self.cells[:, 1:]] - self.X[self.cells[:, :1]]  # rows: edges from the first corner
        self.volumes = np.abs(np.linalg.det(edges)) / 6
        self.inverse_edges = np.linalg.inv(edges)
        F = np.eye(3) + self.gradient(self.u)
        Fdot = self.gradient(self.v)
        self.E = (np.swapaxes(F, -1, -2) @ F - np.eye(3)) / 2
        self.Edot = (np.swapaxes(F, -1, -2) @ Fdot + np.swapaxes(Fdot, -1, -2) @ F) / 2

    def gradient(self, field):
        """d field_i / d X_J."""
        at = field[:, self.cells]
        return np.swapaxes(self.inverse_edges @ (at[:, :, 1:] - at[:, :, :1]), -1, -2)

    def over_body(self, density):
        return (density * self.volumes).sum(axis=-1)

    def square_over(self, simplices, sizes, field):
        """int |field|^2 of linear simplices: sizes/(n (n + 1)) (sum |f_a|^2 + |sum f_a|^2)."""
        n = simplices.shape[1]
        at = field[:, simplices]
        squares = (at**2).sum(axis=(-2, -1)) + (at.sum(axis=-2)**2).sum(axis=-1)
        return (squares * sizes).sum(axis=-1) / (n * (n + 1))

    def facets(self, where):
        """Corners of the cells' faces whose nodes all satisfy `where` of the reference position, with their areas."""
        chosen = where(self.X)
        faces = np.concatenate([self.cells[:, list(f)] for f in ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))])
        faces = faces[chosen[faces].all(axis=1)]
        a, b, c = np.moveaxis(self.X[faces], 1, 0)
        return faces, np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2

    def kinetic(self):
        return DENSITY / 2 * self.square_over(self.cells, self.volumes, self.v)

    def elastic(self):
        return self.over_body(double_dot(isotropic(MU, BULK, self.E), self.E)) / 2

    def weight_potential(self):
        """-int rho g . u of gravity along -z."""
        return DENSITY * G * self.over_body(self.u[:, self.cells, 2].mean(axis=-1))

    def in_dashpot(self, shear, bulk):
        """Lost since the start, and nothing stored."""
        return since_start(self.over_body(double_dot(isotropic(shear, bulk, self.Edot), self.Edot)), self.time), 0

    def in_branch(self, shear, bulk, tau):
        """Lost since the start, and stored: tau Gdot = E - G, solved as for strains that are linear over each step."""
        D = np.zeros_like(self.E)
        for k, h in enumerate(np.diff(self.time)):
            slope = (self.E[k + 1] - self.E[k]) / h
            decay = np.exp(-h / tau)
            D[k + 1] = decay * D[k] + tau * (1 - decay) * slope
        twice_stored = self.over_body(double_dot(isotropic(shear, bulk, D), D))
        return since_start(twice_stored / tau, self.time), twice_stored / 2


class Ledger(ProgramTest):
    tolerance = 1e-3  # of the largest energy: what trapezoids leave at these steps

    def assert_same(self, column, computed, scale, **more):
        np.testing.assert_allclose(column, computed, atol=more.get("tolerance", self.tolerance) * scale, rtol=0,
                                   err_msg=more.get("name", ""))

    def swing(self, viscosity, *settings, ranks=1):
        write_box(self.directory / "bar.msh", (4, 2, 1), (1, 0.4, 0.2))
        h = self.run_input(self.write("bar.yaml", BAR % (f"viscosity: [{viscosity}]" if viscosity else "")), *settings, ranks=ranks)
        motion = Motion(self.directory / "out/result.h5")
        np.testing.assert_allclose(motion.time, h["time"], rtol=1e-12)
        return h, motion

    VISCOSITY = {  # model: its parameters, and what numpy makes of a motion
        "kelvin-voigt": ("shear: 200, bulk: 300", lambda m: m.in_dashpot(200, 300)),
        "stiffness-proportional": ("time: 1 ms", lambda m: m.in_dashpot(1e-3 * MU, 1e-3 * BULK)),
        "mass-proportional": ("decay_rate: 5", lambda m: (since_start(2 * 5 * m.kinetic(), m.time), 0)),
        "maxwell": ("shear_modulus: 1e5, bulk_modulus: 5e4, relaxation_time: 20 ms",
                    lambda m: m.in_branch(1e5, 5e4, 0.02)),
        "prony": ("ratio: 0.5, relaxation_time: 30 ms", lambda m: m.in_branch(0.5 * MU, 0.5 * BULK, 0.03)),
    }

    def check_swing(self, models, *settings, ranks=1):
        h, motion = self.swing(", ".join(f"{{model: {m}, {self.VISCOSITY[m][0]}}}" for m in models), *settings, ranks=ranks)
        scale = h["kinetic_energy"][0]
        self.assert_same(h["kinetic_energy"], motion.kinetic(), scale, tolerance=1e-12)
        stored = motion.elastic()
        for model in models:
            lost, in_branch = self.VISCOSITY[model][1](motion)
            stored = stored + in_branch
            self.assertGreater(lost[-1], 0.02 * scale, model)
            self.assert_same(h["dissipated_" + model.replace("-", "_")], lost, scale, name=model)
        self.assert_same(h["elastic_energy"], stored, scale)
        # The theorem of energy, without what the ledger books as the method's.
        there = h["kinetic_energy"] + h["elastic_energy"] + h["dissipated_energy"]
        self.assert_same(there, scale, scale)

    def test_every_viscosity(self):
        for model in self.VISCOSITY:
            with self.subTest(model):
                self.check_swing([model])

    def test_viscosities_side_by_side(self):
        self.check_swing(list(self.VISCOSITY))

    def test_foundation(self):
        h, m = self.swing("", "loads=[{surface: bottom, spring: 1e5, dashpot: 500}]")
        scale = h["kinetic_energy"][0]
        faces, areas = m.facets(lambda X: X[:, 2] < 1e-9)
        self.assertAlmostEqual(areas.sum(), 0.4, delta=1e-12)
        spring = 1e5 / 2 * m.square_over(faces, areas, m.u)
        lost = since_start(500 * m.square_over(faces, areas, m.v), m.time)
        self.assertGreater(spring.max(), 0.01 * scale)
        self.assertGreater(lost[-1], 0.02 * scale)
        self.assert_same(h["elastic_energy"], m.elastic() + spring, scale)
        self.assert_same(h["dissipated_foundation"], lost, scale)
        self.assert_same(h["kinetic_energy"] + h["elastic_energy"] + h["dissipated_energy"], scale, scale)

    def test_work_of_loads_and_of_prescribed_motion(self):
        # A traction on the free end, and the clamp shaken: force times velocity, the force of the clamp as the history has it.
        h, m = self.swing("", "loads=[{surface: right, traction: [0, 0, '2e4*sin(40*t)']}, {gravity: [0, 0, -9.81]}]",
                          "constraints=[{surface: left, displacement: [0, 0, '0.01*sin(30*t)^2']}]", "time.method=bdf2",
                          "time.step=0.25 ms", "time.end=50 ms")
        faces, areas = m.facets(lambda X: X[:, 0] > 1 - 1e-9)
        mean_velocity = (m.v[:, faces, 2].mean(axis=-1) * areas).sum(axis=-1)
        of_traction = since_start(2e4 * np.sin(40 * m.time) * mean_velocity, m.time)
        of_clamp = since_start(h["left_fz"] * 0.01 * 30 * np.sin(60 * m.time), m.time)
        scale = (m.kinetic() + m.elastic()).max()
        self.assert_same(h["load_potential"], m.weight_potential(), scale)
        self.assert_same(h["support_work"], of_clamp, scale, tolerance=5e-3)  # its force is that of the end of the step
        self.assert_same(h["load_work"] - h["support_work"], of_traction, scale, tolerance=5e-3)
        self.assertGreater(np.abs(of_traction).max(), 0.02 * scale)

    # ---- cavities

    def tube(self, content, *settings):
        """A quarter of a tube, as in test_cavities; the volume of its bore, swept by the deformed facets."""
        inner, length = 0.5, 0.2
        volume = float(4 * inner**2 / 2 * np.sin(np.pi / 8) * length)  # behind four flat facets

        def bent(points):
            r, angle, z = np.moveaxis(points, -1, 0)
            return np.stack([(inner + r) * np.cos(angle * np.pi / 2), (inner + r) * np.sin(angle * np.pi / 2), z], axis=-1)

        write_box(self.directory / "tube.msh", (2, 4, 1), (0.5, 1, length), shape=bent)
        text = f"""mesh: {{file: tube.msh}}
bodies:
  - {{density: {DENSITY}, elasticity: {{model: saint-venant-kirchhoff, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}}}
constraints:
  - {{surface: front, displacement: [free, 0, free]}}
  - {{surface: back, displacement: [0, free, free]}}
  - {{surface: bottom, displacement: [free, free, 0]}}
  - {{surface: top, displacement: [free, free, 0]}}
cavities: [{{name: bore, surface: left, volume: {volume!r}, {content}}}]
time: {{method: dirk33, step: 0.5 ms, end: 50 ms}}
output: {{fields: [displacement, velocity]}}
solver: {{newton: {{relative: 1e-10}}}}
"""
        h = self.run_input(self.write("tube.yaml", text), *settings)
        m = Motion(self.directory / "out/result.h5")
        faces, _ = m.facets(lambda X: np.hypot(X[:, 0], X[:, 1]) < inner + 1e-9)
        a, b, c = np.moveaxis((m.X + m.u)[:, faces], 2, 0)
        outward = np.cross(b - a, c - a) / 2  # out of the bore, once it points away from the axis
        middle = (a + b + c) / 3
        outward *= np.sign((outward * middle)[..., :2].sum(axis=-1))[..., None]
        # The divergence theorem with (x, y, 0)/2, which is along all other faces of the bore.
        return h, m, (middle * outward)[..., :2].sum(axis=(-2, -1)) / 2

    def test_gas(self):
        p0, pa, n = 2e4, 1e5, 1.4
        h, m, V = self.tube(f"gas: {{pressure: {p0}, ambient: {pa}, exponent: {n}}}")
        self.assertGreater(np.ptp(V) / V[0], 0.02)
        pressure = (p0 + pa) * (V[0] / V)**n - pa
        np.testing.assert_allclose(h["bore_volume"], V, rtol=1e-9)
        np.testing.assert_allclose(h["bore_pressure"], pressure, rtol=1e-7)
        done = (p0 + pa) * V[0]**n * (V**(1 - n) - V[0]**(1 - n)) / (1 - n) - pa * (V - V[0])  # int p dV
        scale = done.max()
        self.assert_same(h["load_potential"] - h["load_potential"][0], -done, scale, tolerance=1e-6)
        self.assert_same(h["elastic_energy"], m.elastic(), scale, tolerance=1e-9)
        self.assert_same(m.kinetic() + m.elastic(), done, scale)

    def test_pumped_liquid(self):
        K = 1e6
        h, m, V = self.tube(f'liquid: {{bulk_modulus: {K}, added_volume: "0.002*sin(30*t)^2"}}')
        added = 0.002 * np.sin(30 * m.time)**2
        pressure = K * (added - (V - V[0])) / V[0]
        np.testing.assert_allclose(h["bore_pressure"], pressure, atol=1e-6 * pressure.max())
        # All that the bodies have came in with the liquid, which keeps a part.
        work = since_start(pressure * np.gradient(V, m.time, edge_order=2), m.time)
        scale = work.max()
        self.assert_same(m.kinetic() + m.elastic(), work, scale, tolerance=5e-3)
        self.assert_same(h["load_work"] - (h["load_potential"] - h["load_potential"][0]), work, scale, tolerance=5e-3)

    # ---- without inertia

    def test_a_start_out_of_balance(self):
        """Loads that act at once do twice the work that a linear body stores; the half that is lost has its column."""
        write_box(self.directory / "bar.msh", (4, 2, 1), (1, 0.4, 0.2))
        text = f"""mesh: {{file: bar.msh}}
bodies:
  - density: {DENSITY}
    elasticity: {{model: linear, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
loads: [%s]
time: {{method: quasistatic, step: 0.1, end: 0.3}}
output: {{fields: [displacement, velocity]}}
solver: {{newton: {{relative: 1e-10}}}}
"""
        constant = "{gravity: [0, 0, -9.81]}", "{surface: right, traction: [1e3, 0, 0]}"
        changing = '{surface: right, traction: ["1e3*(1 + t)", 0, 0]}', "{surface: right, pressure: 1e3*(1 + t)}"
        for load in (*constant, *changing, ", ".join(constant)):
            for more in ((), ("initial.displacement=[0, 0, 0.01*x^2]",), ("bodies.0.viscosity={model: kelvin-voigt, shear: 1e3}",)):
                with self.subTest(load=load, more=more):
                    h = self.run_input(self.write("bar.yaml", text % load), *more)
                    stored = h["elastic_energy"][-1]
                    self.assertGreater(stored, 1e-3)
                    self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-7 * max(stored, h["elastic_energy"][0]))
                    if load in constant and not more:
                        self.assertAlmostEqual(h["load_potential"][-1] / stored, -2, delta=1e-6)
                        self.assertAlmostEqual(h["numerical_dissipation"][-1] / stored, 1, delta=1e-6)
        whole = self.run_input(self.write("bar.yaml", text % constant[0]), "checkpoint={every: 1}")
        self.run_input("bar.yaml", "checkpoint={every: 1}", "time.end=0.1", output="part")
        done = self.call("resume", "part", "--set", "time.end=0.3")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_same_history(read_history(self.directory / "part"), whole, 1e-12)

    def test_the_log_speaks_of_a_method_only_where_there_is_one(self):
        write_box(self.directory / "bar.msh", (4, 2, 1), (1, 0.4, 0.2))
        self.write("bar.yaml", BAR % "")
        for method, lost in (("static", "lost between equilibria"), ("quasistatic", "lost between equilibria"),
                             ("bdf2", "by the method")):
            done = self.call("run", "bar.yaml", "--set", "time.method=" + method, "--set", "time.end=1 ms", "--set",
                             "loads=[{gravity: [0, 0, -9.81]}]")
            self.assertEqual(done.returncode, 0, done.stderr)
            energies = next(line for line in done.stdout.splitlines() if line.startswith("energy [J]:"))
            self.assertIn(lost, energies)
            self.assertEqual("kinetic" in energies, method == "bdf2", energies)

    # ---- contact

    def on_floor(self, floor, above, velocity, step, end, viscosity=""):
        write_box(self.directory / "cube.msh", (2, 2, 2), (1, 1, 1))
        text = f"""mesh: {{file: cube.msh}}
bodies:
  - density: {DENSITY}
    elasticity: {{model: saint-venant-kirchhoff, shear_modulus: 4e6, lame_lambda: 4e6}}
    {viscosity}
loads: [{{gravity: [0, 0, -{G}]}}]
initial: {{velocity: {velocity}}}
contact:
  friction_update: iterated
  obstacles: [{{name: floor, shape: plane, point: [0, 0, {-above}], normal: [0, 0, 1], {floor}}}]
time: {{method: dirk33, step: {step}, end: {end}}}
output: {{fields: [displacement, velocity]}}
"""
        h = self.run_input(self.write("cube.yaml", text))
        m = Motion(self.directory / "out/result.h5")
        elastic = m.over_body(double_dot(isotropic(4e6, 4e6 + 8e6 / 3, m.E), m.E)) / 2
        there = m.kinetic() + elastic + m.weight_potential()
        return h, m, there

    def test_friction(self):
        # The cube slides, rocks and comes to rest; what is not there any more went into friction and the material.
        h, m, there = self.on_floor("friction: 0.3", 0.005, [1, 0, 0], "0.5 ms", 0.4,
                                    "viscosity: {model: kelvin-voigt, shear: 2e4, bulk: 2e4}")
        in_material = m.in_dashpot(2e4, 2e4)[0]
        scale = DENSITY / 2
        self.assert_same(h["dissipated_kelvin_voigt"], in_material, scale, tolerance=5e-3)
        in_friction = there[0] - (there + h["contact_energy"]) + h["contact_energy"][0] - in_material
        self.assertGreater(in_friction[-1], 0.8 * scale)
        self.assert_same(h["dissipated_friction"], in_friction, scale, tolerance=1e-2)

    def test_steps_that_are_too_long_for_relaxation(self):
        # A Prony series under a vibration, with so many steps a period.
        write_box(self.directory / "bar.msh", (2, 1, 1), (0.2, 0.1, 0.1))
        self.write("bar.yaml", """mesh: {file: bar.msh}
bodies: [{elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}, viscosity: {model: prony, ratio: 0.5, relaxation_time: 0.16}}]
constraints: [{surface: left, displacement: [0, 0, 0]}, {surface: right, displacement: ["0.01*sin(2*pi*t)", 0, 0]}]
time: {method: quasistatic, step: 0.1, end: 2}
""")
        for steps, is_warned in ((10, True), (100, False)):
            done = self.call("run", "bar.yaml", "--set", f"time.step={1 / steps}")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual("the works between equilibria miss" in done.stderr, is_warned, done.stderr)

    def test_walls_that_move_without_inertia(self):
        # A plane moves onto a block, by almost the width of the barrier in each step: it does the work that is stored.
        write_box(self.directory / "cube.msh", (2, 2, 2), (0.2, 0.2, 0.2))
        text = """mesh: {file: cube.msh}
bodies: [{elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.3}}]
constraints: [{surface: bottom, displacement: [0, 0, 0]}]
contact:
  surface: top
  LAW
  obstacles: [{name: lid, shape: plane, normal: [0, 0, -1], point: [0, 0, 0.205], motion: {translate: [0, 0, "-0.02*t"]}}]
"""
        for law in ("law: barrier, width: 5 mm", "law: penalty", "law: penalty, stiffness: 1e11"):
            for time in ("method: static, load_steps: 5, end: 1", "method: quasistatic, step: 0.2, end: 1"):
                h = self.solve(text.replace("LAW", law.replace(", ", "\n  ")), time)
                stored = h["elastic_energy"][-1]
                self.assertGreater(stored, 1)
                np.testing.assert_allclose(h["load_work"][-1], stored, rtol=0.05, err_msg=law + time)
                np.testing.assert_allclose(h["numerical_dissipation"][-1], 0, atol=0.05 * stored, err_msg=law + time)
                self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-4 * stored)
        # The impulse, by trapezoids of the force.
        steps, force = np.diff(h["time"]), h["lid_fz"]
        np.testing.assert_allclose(h["lid_jz"][-1], 0.5 * steps @ (force[1:] + force[:-1]), rtol=1e-9)

    def test_contact_damping(self):
        h, m, there = self.on_floor("normal_damping: 0.3 s/m", 0.02, [0, 0, -1], "0.5 ms", 0.12)
        scale = there[0]
        apart = h["floor_fz"] == 0
        self.assertTrue(apart[-1], "it has bounced off")
        self.assertLess(h["floor_jz"][0] + 500, h["floor_jz"][-1])
        lost = there[0] - there[-1]
        self.assertGreater(lost, 0.05 * scale)
        self.assert_same(h["dissipated_contact_damping"][-1], lost, scale, tolerance=1e-2)


if __name__ == "__main__":
    unittest.main()
