#!/usr/bin/python3
"""Stresses and energies of cells: the sum of all parts, and each part, of a cube in a prescribed homogeneous motion."""
import unittest

import h5py
import numpy as np

from program import ProgramTest, swept, write_box

MU, LAMBDA = 1e4, 4e4
PARTS = ("elastic", "viscous", "active")
RATES = np.array([0.4, -0.1, 0.2])  # of the sides: F = diag(1 + rate t)
SHEAR = 0.3                         # F_xy = SHEAR t
END = 0.5
FIELDS = ("cauchy_stress, elastic_cauchy_stress, viscous_cauchy_stress, active_cauchy_stress, von_mises_stress, "
          "energy_density, elastic_energy_density, viscous_energy_density")
CUBE = f"""mesh: {{file: cube.msh}}
element: %s
bodies:
  - density: 1000
    elasticity: {{model: saint-venant-kirchhoff, shear_modulus: {MU}, lame_lambda: {LAMBDA}}}
    %s
constraints:
  - where: "x > -1"
    displacement: ["{RATES[0]}*t*x + {SHEAR}*t*y", "{RATES[1]}*t*y", "{RATES[2]}*t*z"]
time: {{method: dirk33, step: 10 ms, end: {END}}}
output: {{every: 0.1, fields: [{FIELDS}]}}
"""


def gradient(t):
    F = np.eye(3) + np.diag(RATES * t)
    F[0, 1] = SHEAR * t
    return F


def strain(t):
    F = gradient(t)
    return (F.T @ F - np.eye(3)) / 2


def isotropic(shear, bulk, D):
    return 2 * shear * D + (bulk - 2 / 3 * shear) * np.trace(D) * np.eye(3)


def elastic(t):
    return isotropic(MU, LAMBDA + 2 / 3 * MU, strain(t))


def pushed_forward(S, t):
    F = gradient(t)
    sigma = F @ S @ F.T / np.linalg.det(F)
    return sigma[(0, 1, 2, 0, 1, 0), (0, 1, 2, 1, 2, 2)]


def distance_from_relaxed(t, tau):
    """E - G at t of tau Gdot = E - G, G(0) = 0: E is a polynomial of second degree in time, E = a t + b t^2."""
    b = (strain(1) + strain(-1)) / 2
    a = strain(1) - b
    decay = 1 - np.exp(-t / tau)
    # d(E - G)/dt = a + 2 b t - (E - G)/tau
    return a * tau * decay + 2 * b * tau * (t - tau * decay)


def von_mises(s):
    xx, yy, zz, xy, yz, xz = s
    return np.sqrt(((xx - yy)**2 + (yy - zz)**2 + (zz - xx)**2) / 2 + 3 * (xy**2 + yz**2 + xz**2))


class StressFields(ProgramTest):
    def frames(self, body, element="P1", ranks=1, settings=()):
        """The history; time and fields of each frame, of which every cell has the same."""
        write_box(self.directory / "cube.msh", (2, 1, 1))
        history = self.run_input(self.write("cube.yaml", CUBE % (element, body)), *settings, ranks=ranks)
        frames = []
        with h5py.File(self.directory / "out/result.h5") as file:
            for name in sorted(file["frames"]):
                frame = file["frames"][name]
                values = {}
                for field in FIELDS.split(", "):
                    cells = frame[field][()]
                    np.testing.assert_allclose(cells, np.broadcast_to(cells[0], cells.shape), rtol=1e-8, atol=1e-7)
                    values[field] = cells[0]
                frames.append((frame.attrs["time"], values))
        return history, frames

    def check(self, body, viscous, active=lambda t: np.zeros((3, 3)), energy=lambda t: 0.0, tolerance=1e-9, **kind):
        """`viscous` and `active`: second Piola-Kirchhoff stresses as functions of time."""
        history, frames = self.frames(body, **kind)
        self.assertEqual(len(frames), 6)
        scale = np.abs(pushed_forward(elastic(END), END)).max()
        for t, fields in frames[1:]:
            want = {"elastic": elastic(t), "viscous": viscous(t), "active": active(t)}
            for part in PARTS:
                np.testing.assert_allclose(fields[f"{part}_cauchy_stress"], pushed_forward(want[part], t),
                                           atol=tolerance * scale, err_msg=f"{part} at {t}")
            total = pushed_forward(sum(want.values()), t)
            np.testing.assert_allclose(fields["cauchy_stress"], total, atol=2 * tolerance * scale)
            np.testing.assert_allclose(fields["von_mises_stress"], von_mises(total), atol=4 * tolerance * scale)
            stored = np.tensordot(elastic(t), strain(t)) / 2
            np.testing.assert_allclose(fields["elastic_energy_density"], stored, rtol=1e-9)
            np.testing.assert_allclose(fields["viscous_energy_density"], energy(t), atol=tolerance * stored)
            np.testing.assert_allclose(fields["energy_density"], stored + energy(t), atol=tolerance * stored)
        # What the history sums over the cube, which is of unit volume.
        np.testing.assert_allclose(frames[-1][1]["energy_density"], history["elastic_energy"][-1], rtol=1e-9)

    def test_kelvin_voigt(self):
        def stress(t):
            h = 1e-4  # E is of second degree in time: central differences are exact
            return isotropic(30, 50, (strain(t + h) - strain(t - h)) / (2 * h))

        rates = ("secant", "reconstructed", "exact")
        cases = [(element, ranks, rate) for element, ranks in (("P1", 1), ("P1", 2), ("P2", 1)) for rate in rates]
        for element, ranks, rate in swept(cases, [*cases[:3], *cases[7:8]]):
            with self.subTest(element=element, ranks=ranks, rate=rate):
                self.check(f"viscosity: {{model: kelvin-voigt, shear: 30, bulk: 50, rate: {rate}}}", stress,
                           element=element, ranks=ranks)

    def test_stiffness_proportional(self):
        def stress(t):
            return isotropic(MU, LAMBDA + 2 / 3 * MU, 0.02 * (strain(t + 1e-4) - strain(t - 1e-4)) / 2e-4)

        self.check("viscosity: {model: stiffness-proportional, time: 20 ms}", stress)

    def test_maxwell(self):
        tau, shear, bulk = 0.2, 3e3, 5e3
        cases = (("P1", 3), ("P2", 2), ("P1", 1))
        for element, ranks in swept(cases, cases[:1]):
            with self.subTest(element=element, ranks=ranks):
                self.check(f"viscosity: {{model: maxwell, shear_modulus: {shear}, bulk_modulus: {bulk}, "
                           f"relaxation_time: {tau}}}",
                           lambda t: isotropic(shear, bulk, distance_from_relaxed(t, tau)),
                           energy=lambda t: np.tensordot(isotropic(shear, bulk, distance_from_relaxed(t, tau)),
                                                         distance_from_relaxed(t, tau)) / 2,
                           tolerance=1e-5, element=element, ranks=ranks)  # of the method at its step

    def test_prony(self):
        # Where the law is linear in E, a branch is a spring and a dashpot of its moduli.
        branches = ((0.3, 0.2), (0.5, 0.05))
        body = "viscosity:\n" + "".join(f"      - {{model: prony, ratio: {g}, relaxation_time: {tau}}}\n"
                                        for g, tau in branches)

        def states(t):
            for g, tau in branches:
                D = distance_from_relaxed(t, tau)
                yield g * isotropic(MU, LAMBDA + 2 / 3 * MU, D), D

        for element, ranks in swept((("P1", 2), ("P2", 1)), (("P2", 1),)):
            with self.subTest(element=element, ranks=ranks):
                self.check(body, lambda t: sum(H for H, D in states(t)), element=element, ranks=ranks,
                           energy=lambda t: sum(np.tensordot(H, D) / 2 for H, D in states(t)), tolerance=1e-4)

    def test_active_stress(self):
        fibre = np.array([0.6, 0.0, 0.8])
        for element, ranks in swept((("P1", 2), ("P2", 1)), (("P2", 1),)):
            with self.subTest(element=element, ranks=ranks):
                self.check('active: {fibre: [0.6, 0, 0.8], stress: "5e3*t"}', lambda t: np.zeros((3, 3)),
                           active=lambda t: 5e3 * t * np.outer(fibre, fibre), element=element, ranks=ranks)

    def test_all_together(self):
        tau, g = 0.2, 0.3
        fibre = np.array([0.6, 0.0, 0.8])

        def viscous(t):
            rate = (strain(t + 1e-4) - strain(t - 1e-4)) / 2e-4
            return isotropic(30, 50, rate) + g * isotropic(MU, LAMBDA + 2 / 3 * MU, distance_from_relaxed(t, tau))

        D_energy = lambda t: g * np.tensordot(isotropic(MU, LAMBDA + 2 / 3 * MU, distance_from_relaxed(t, tau)),
                                              distance_from_relaxed(t, tau)) / 2
        self.check("viscosity: [{model: kelvin-voigt, shear: 30, bulk: 50}, "
                   f"{{model: prony, ratio: {g}, relaxation_time: {tau}}}]\n"
                   '    active: {fibre: [0.6, 0, 0.8], stress: "5e3*t"}',
                   viscous, active=lambda t: 5e3 * t * np.outer(fibre, fibre), energy=D_energy, tolerance=1e-5)

    def test_after_a_restart(self):
        """What branches remember is in the first frame after a checkpoint, too."""
        body = "viscosity: {model: maxwell, shear_modulus: 3e3, bulk_modulus: 5e3, relaxation_time: 0.2}"
        _, whole = self.frames(body)
        self.frames(body, settings=("time.end=0.3", "checkpoint={every: 10}"))
        done = self.call("resume", "out", "--set", f"time.end={END}")
        self.assertEqual(done.returncode, 0, done.stderr)
        with h5py.File(self.directory / "out/result.h5") as file:
            last = file["frames"][sorted(file["frames"])[-1]]
            for field in FIELDS.split(", "):
                np.testing.assert_array_equal(last[field][0], whole[-1][1][field])


if __name__ == "__main__":
    unittest.main()
