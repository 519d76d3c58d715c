#!/usr/bin/python3
"""The quick cases of input/verification keep to their published numbers; docs/verification.md says where those come from."""
import unittest

import h5py
import numpy as np

from program import ROOT, ProgramTest, write_box
from thick_shell import ThickShell

INPUTS = ROOT / "input/verification"


class Verification(ProgramTest):
    def history(self, case, *settings, ranks=1):
        return self.run_input(INPUTS / f"{case}.yaml", *settings, ranks=ranks)

    def assert_close(self, value, expected, relative):
        self.assertAlmostEqual(value / expected, 1, delta=relative)

    def frames(self):
        with h5py.File(self.directory / "out/result.h5") as file:
            names = sorted(file["frames"])
            mesh = {name: file["mesh"][name][()] for name in ("coordinates", "cells")}
            return mesh, [{name: data[()] for name, data in file["frames"][frame].items()} for frame in names]

    def test_turek_hron_statics(self):
        # 70 x 4 elements along and across: the error halves twice with the next mesh.
        for case, ux, uy in (("turek_hron_csm1", -7.187e-3, -66.10e-3), ("turek_hron_csm2", -0.4690e-3, -16.97e-3)):
            with self.subTest(case):
                h = self.history(case, ranks=2)
                self.assert_close(h["A_x"][-1] - 0.6, ux, 3e-3)
                self.assert_close(h["A_y"][-1] - 0.2, uy, 2e-3)

    def test_turek_hron_dynamics(self):
        # A fifth of the period; within the difference of two time integrators at this step.
        h = self.history("turek_hron_csm3", "time.end=0.2")
        self.assertEqual(len(h["time"]), 81)
        self.assert_close(h["A_x"][-1] - 0.6, -4.3498e-3, 3e-3)
        self.assert_close(h["A_y"][-1] - 0.2, -52.011e-3, 1e-3)

    def test_cooks_membrane(self):
        h = self.history("cooks_membrane")
        self.assert_close(h["end_y"][-1] - 0.052, 14.505e-3, 2e-3)
        self.assertAlmostEqual(h["clamp_fy"][-1], -1, delta=1e-7)

    def test_cooks_membrane_with_the_volume_split_off(self):
        # Quadrilaterals of second order, 32 x 32; here triangles cut from 16 x 16.
        h = self.history("cooks_membrane_isochoric", ranks=2)
        self.assert_close(h["end_y"][-1] - 0.052, 14.74e-3, 2e-3)

    def test_long_wall(self):
        # The closed form, to the digits it is published with.
        h = self.history("long_wall")
        self.assertAlmostEqual(h["corner_x"][-1] - 1, -0.1675, delta=1e-4)
        self.assertAlmostEqual(h["corner_y"][-1] - 2, 0.4025, delta=1e-4)

    def test_twisting_column(self):
        # The start of the motion, within what the independent code's two meshes differ by.
        h = self.history("twisting_column", "time.end=0.02")
        self.assert_close(h["kinetic_energy"][0], 3.0319e6, 1e-4)
        for time, degrees in ((0.01, 55.87), (0.02, 110.84)):
            at = np.argmin(np.abs(h["time"] - time))
            turned = np.degrees(np.arctan2(h["corner_x"][at], h["corner_z"][at])) - 45
            self.assert_close(turned, degrees, 1e-2)

    def test_vibrating_cantilever(self):
        # Against another code and element, 1.5 % of the largest displacement.
        h = self.history("cantilever_vibration", "time.end=0.3")
        for time, expected in ((0.1, 0.81436), (0.2, 2.00586), (0.3, 2.76568)):
            at = np.argmin(np.abs(h["time"] - time))
            u = np.linalg.norm([h["end_x"][at] - 0.1, h["end_y"][at] - 0.1, h["end_z"][at] - 2])
            self.assertAlmostEqual(u, expected, delta=0.015 * 2.8)

    def test_bent_cube(self):
        # dolfinx, the same mesh and quadrature.
        h = self.history("bent_cube", "solver.newton.relative=1e-11")
        self.assert_close(h["elastic_energy"][-1], 2.190388296086e-1, 1e-10)
        for axis, expected in zip("xyz", (1.09436176, 0.95054436, -0.14346301)):
            self.assertAlmostEqual(h[f"corner_{axis}"][-1], expected, delta=2e-8)
        # Finer: the independent code integrates by another rule.
        for n, energy in ((4, 2.192716468225e-1), (8, 2.207060693174e-1)):
            points_per_side = write_box(self.directory / "cube.msh", (n, n, n))
            h = self.history("bent_cube", f"mesh.file={points_per_side}", "constraints.0.surface=left")
            self.assert_close(h["elastic_energy"][-1], energy, 2e-3)

    def test_rotation_and_stretch(self):
        h = self.history("rotation_and_stretch", ranks=2)
        turned, stretched, end = (np.argmin(np.abs(h["time"] - t)) for t in (1, 2, 3))
        self.assertLess(h["elastic_energy"][: turned + 1].max(), 1e-10)
        np.testing.assert_allclose([h[f"end_{c}"][turned] for c in "xyz"], [-0.5, 1, 0.5], atol=1e-12)
        self.assertAlmostEqual(h["end_y"][stretched], 1.1, delta=1e-8)
        np.testing.assert_allclose([h[f"end_{c}"][end] for c in "xyz"], [-0.5, 1, 0.5], atol=1e-12)
        _, frames = self.frames()
        stress = frames[stretched]["cauchy_stress"]  # xx yy zz xy yz xz; the axis lies along y now
        np.testing.assert_allclose(stress[:, 1], 31096.154e6, rtol=1e-7)
        np.testing.assert_allclose(stress[:, [0, 2]], 11013.986e6, rtol=1e-7)
        np.testing.assert_allclose(stress[:, 3:], 0, atol=1e3)

    def test_pulled_cube(self):
        h = self.history("pulled_cube")
        self.assert_close(h["elastic_energy"][-1], 4.065814263543e2, 1e-11)
        mesh, frames = self.frames()
        u, cells = frames[-1]["displacement"], mesh["cells"]
        corners = mesh["coordinates"][cells]
        edges = corners[:, 1:] - corners[:, :1]
        volumes = np.abs(np.linalg.det(edges)) / 6
        middle = u[cells].mean(axis=1)
        gradient = np.linalg.solve(edges, u[cells][:, 1:] - u[cells][:, :1])
        self.assert_close(np.sqrt((volumes * (middle**2).sum(axis=1)).sum()), 0.06019896863581861, 1e-9)
        self.assert_close(np.sqrt((volumes * (gradient**2).sum(axis=(1, 2))).sum()), 0.21798642314867062, 1e-9)
        self.assert_close(np.linalg.norm(middle, axis=1).max(), 0.08992836526, 1e-9)
        self.assert_close(self.history("pulled_cube", "element=P2")["elastic_energy"][-1], 3.904527566047e2, 1e-11)

    def test_beam_theory(self):
        h = self.history("slender_beam")
        self.assert_close(h["tip_z"][-1] - 0.1, -2.56e-3, 1e-3)

    def test_axial_vibration(self):
        h = self.history("axial_vibration")
        u, t = h["end_x"] - 1, h["time"]
        self.assert_close(h["elastic_energy"][0], 2.467401e-2, 1e-5)
        zero = [t[k] - u[k] * (t[k + 1] - t[k]) / (u[k + 1] - u[k]) for k in range(len(t) - 1) if u[k] * u[k + 1] < 0]
        # BDF2 lengthens a period by (w dt)^2 / 3 of it.
        self.assert_close(2 * (zero[1] - zero[0]), 0.126491 * (1 + (49.673 * 0.5e-3) ** 2 / 3), 1e-4)

    def test_damped_bar(self):
        h = self.history("damped_bar")
        u, t = h["end_x"] - 1, h["time"]
        ratio, omega = 0.0496729, 49.67294
        damped = omega * np.sqrt(1 - ratio**2)
        # Of a decaying vibration u[k + 1] = 2 r cos(w dt) u[k] - r^2 u[k - 1], r the decay in a step.
        (p, q), *_ = np.linalg.lstsq(np.stack([u[1:-1], -u[:-2]], axis=1), u[2:], rcond=None)
        angle = np.arccos(p / (2 * np.sqrt(q)))
        self.assert_close(angle / (t[1] - t[0]), damped, 2e-4)
        self.assert_close(-np.pi * np.log(q) / angle, 0.312490, 1e-3)
        # The motion by its formula, cos(w t) + z / sqrt(1 - z^2) sin(w t) within the decay.
        decay = np.exp(-ratio * omega * t)
        exact = 1e-5 * decay * (np.cos(damped * t) + ratio / np.sqrt(1 - ratio**2) * np.sin(damped * t))
        np.testing.assert_allclose(u, exact, atol=2e-4 * 1e-5)
        self.assert_close(h["dissipated_stiffness_proportional"][-1], h["dissipated_energy"][-1], 1e-12)

    def test_viscous_column(self):
        exact = 3 * 0.5 / 5 + 1 - (1 - 9 / 4 * 0.25) ** (1 / 3)
        # Backward Euler's recursion for 2 l^2 dl/dt = -3 t, by hand.
        for step, expected in ((0.1, 0.72458), (0.05, 0.59605)):
            h = self.history("viscous_column", "time.method=backward-euler", f"time.step={step}")
            self.assertAlmostEqual(h["foot_z"][-1], expected, delta=1e-5)
        errors = [abs(self.history("viscous_column", f"time.step={step}")["foot_z"][-1] - exact) for step in (0.025, 0.0125)]
        self.assertLess(errors[1], 2e-3)
        self.assertAlmostEqual(np.log2(errors[0] / errors[1]), 2, delta=0.3)

    def test_viscous_tube(self):
        h = self.history("viscous_tube", "time.end=1000", ranks=2)
        branches = ((2.93, 30), (5.86, 300), (6.60, 3000), (18.32, 12000))
        # Lame's solution in plane strain; four quadratic elements through the wall are 0.2 % off at this node.
        self.assert_close(h["outer_x"][-1] - 10e-3, 0.6175115e-6, 3e-3)
        n, step = h["step"][1:], 50
        # Backward Euler holds the exponentials by (1 + step / tau)^-n, so exactly as the stresses do.
        modulus = 39.58 + sum(E / (1 + step / tau) ** n for E, tau in branches)
        force = h["inner_fx"][1:]
        np.testing.assert_allclose(force / force[0], modulus / modulus[0], rtol=1e-8)
        continuous = 39.58 + sum(E * np.exp(-h["time"][-1] / tau) for E, tau in branches)
        self.assert_close(modulus[-1], continuous, 3e-3)

    def test_inflated_tube(self):
        h = self.history("inflated_tube", ranks=2)
        tube = ThickShell(5e-3, 10e-3, 1e6, 0.4, curved=1)
        radii = 5e-3 * np.sqrt(h["bore_volume"] / h["bore_volume"][0])
        expected = [tube.pressure(radius, 20) for radius in radii]
        # 3.6e-4 off, with elements of half the size 2.5e-5.
        np.testing.assert_allclose(h["bore_pressure"], expected, rtol=5e-4, atol=1e-3)
        self.assert_close(h["bore_pressure"][-1], 1e5, 1e-12)
        # Nodes lie off the circle by more.
        self.assert_close(h["inside_x"][-1], radii[-1], 1e-3)

    def test_balloon(self):
        # Past the greatest pressure, where one that is given would have no stable answer. Two quadratic elements through
        # the wall are 1e-4 off at most.
        h = self.history("balloon", "time.load_steps=8")
        ball = ThickShell(8e-3, 10e-3, 1e6, 0.45, curved=2)
        expected = np.array([ball.pressure(radius) for radius in h["inside_x"]])
        np.testing.assert_allclose(h["hollow_pressure"], expected, rtol=3e-4, atol=1e-3)
        np.testing.assert_allclose(h["energy_balance_error"], 0, atol=1e-8 * h["elastic_energy"][-1])
        self.assertLess(h["hollow_pressure"][-1], 0.9 * h["hollow_pressure"].max())
        np.testing.assert_allclose(h["inside_x"] / 8e-3, (h["hollow_volume"] / h["hollow_volume"][0]) ** (1 / 3), rtol=3e-4)


if __name__ == "__main__":
    unittest.main()
