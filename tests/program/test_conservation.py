#!/usr/bin/python3
"""Long flight of a free body: symplectic methods keep its momenta to the solver's tolerance, and bound its energy."""
import unittest

import numpy as np

from program import ROOT, ProgramTest, swept

INPUT = ROOT / "input/convergence/flying_block.yaml"


def gained(time, values):
    """Over the whole time, by the straight line of least squares."""
    return np.polyfit(time, values, 1)[0] * np.ptp(time)


class Conservation(ProgramTest):
    flown = {}  # histories of runs on one rank, which several tests look at

    def fly(self, method, ranks=1, end=80):
        h = self.flown.get((method, ranks, end)) or self.run_input(INPUT, "time.method=" + method, f"time.end={end}", ranks=ranks, timeout=300)
        self.flown[method, ranks, end] = h
        momentum = np.array([h["p" + c] for c in "xyz"])
        spin = np.array([h["L" + c] for c in "xyz"])
        energy = h["kinetic_energy"] + h["elastic_energy"]
        drift = [np.abs(x - x[:, :1]).max() / np.linalg.norm(x[:, 0]) for x in (momentum, spin)]
        return h, drift, energy / energy[0] - 1

    def test_a_thousand_steps(self):
        # Newton's method stops at 1e-12 of the forces. What it leaves is an error of the momenta, of either sign, in each
        # step: some 3e-11 in 1000 steps, 1e-9 if all of it had one sign.
        for method, bound in (("implicit-midpoint", 2.5e-3), ("symplectic-dirk22", 7e-4)):
            with self.subTest(method):
                h, drift, energy = self.fly(method, end=40)
                self.assertEqual(len(h["step"]), 1001)
                self.assertLess(max(drift), 1e-10)
                # The error of the energy swings with the vibration and does not grow: what a straight line through it
                # gains over the run is small beside the swings.
                self.assertLess(np.abs(energy).max(), bound)
                self.assertGreater(np.abs(energy).max(), bound / 10)
                self.assertLess(abs(gained(h["time"], energy)), 0.25 * np.abs(energy).max())

    def test_a_drift_would_be_seen(self):
        h, _, energy = self.fly("implicit-midpoint", end=40)
        for sign in (1, -1):
            drifting = energy + sign * 0.6 * np.abs(energy).max() * h["time"] / h["time"][-1]
            self.assertGreater(abs(gained(h["time"], drifting)), 0.25 * np.abs(drifting).max())

    def test_two_ranks(self):
        for method in swept(("implicit-midpoint", "symplectic-dirk22"), ("symplectic-dirk22",)):
            with self.subTest(method):
                _, drift, _ = self.fly(method, ranks=2, end=1)
                self.assertLess(max(drift), 1e-10)

    def test_others_lose_spin(self):
        # That the measure above sees what is lost: bdf2 loses a hundred thousand times more within 100 steps.
        _, drift, energy = self.fly("bdf2", end=4)
        self.assertLess(drift[0], 1e-10)
        self.assertGreater(drift[1], 1e-4)
        self.assertLess(energy[-1], -1e-3)


if __name__ == "__main__":
    unittest.main()
