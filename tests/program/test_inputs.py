"""The inputs that come with the program run, each at a small size, and show what the gallery says of them."""
import unittest

import numpy as np
from program import ROOT, ProgramTest

# File in input/ -> what makes it small.
SMALL = {
    "beam_small.yaml": ["time.end=0.03"],
    "bracket.yaml": ["mesh.size=0.006", "element=P1", "time.load_steps=2"],
    "cantilever.yaml": ["mesh.size=0.2", "time.end=0.05"],
    "dropped_club.yaml": ["mesh.size=0.02", "time.end=0.25"],
    "falling_blocks.yaml": ["mesh.size=0.012", "time.end=0.1", "time.step=0.004"],
    "four_clubs.yaml": ["mesh.size=0.02", "time.end=0.02"],
    "gripper.yaml": ["mesh.size=50 mm", "time.step=20 ms"],
    "gripper_finger.yaml": ["time.end=0.02"],
    "muscle.yaml": ["mesh.size=0.2", "time.end=0.1"],
    "pneumatic_actuator.yaml": ["time.end=0.02", "time.events=[]"],
    "relaxation.yaml": ["time.step=20 ms", "time.end=1"],
    "static_bending.yaml": ["mesh.size=0.2", "time.load_steps=4"],
    "thrown_box.yaml": ["mesh.size=0.025", "time.end=0.8", "time.step=0.004"],
    "ventricle.yaml": ["mesh.size=0.004", "time.load_steps=10"],
}
SEEN = {}  # what the tests below look at is not run twice


class Inputs(ProgramTest):
    def run_small(self, name, *settings):
        return self.run_input(ROOT / "input" / name, *SMALL[name], *settings)

    def test_each_runs(self):
        names = {file.name for file in (ROOT / "input").glob("*.yaml")}
        self.assertEqual(names, set(SMALL), "each input has a small size here")
        for name in sorted(names - SEEN.keys()):
            with self.subTest(name):
                self.run_small(name)

    @staticmethod
    def looked_at(name):
        def mark(test):
            SEEN[name] = test
            return test
        return mark

    @looked_at("gripper.yaml")
    def test_the_gripper_carries_a_weight(self):
        # Coarser in space and time than the input: what the fingers carry is the grip, and friction is part of it.
        held = self.run_small("gripper.yaml")
        self.assertEqual(len(held["step"]), 51, "a step was cut")
        still, lifting = held["time"] < 0.05, (held["time"] > 0.7) & (held["time"] < 0.9)
        self.assertEqual(np.abs(held["rod_fz"][still]).max(), 0)
        weight = -held["rod_fz"][lifting]  # that of a cylinder that the fingers would carry
        self.assertGreater(weight.min(), 0.5)
        self.assertLess(np.abs(held["rod_fx"][lifting]).max(), 0.05 * weight.max(), "both fingers push alike")
        self.assertGreater(held["dissipated_friction"][-1], 1e-4)
        self.assertLess(np.abs(held["energy_balance_error"]).max(), 1e-6 * held["elastic_energy"].max())

    @looked_at("thrown_box.yaml")
    def test_the_box_turns_over_and_keeps_its_momentum_and_energy(self):
        history = self.run_small("thrown_box.yaml")
        self.assertLess(history["corner_y"].min(), -0.025, "from one side to the other")
        self.assertLess(np.abs(history["Ly"] / history["Ly"][0] - 1.0).max(), 1e-8)
        energy = history["kinetic_energy"] + history["elastic_energy"]
        self.assertLess(np.abs(energy / energy[0] - 1.0).max(), 2e-3)

        damped = self.run_small("thrown_box.yaml", "time.method=backward-euler")
        self.assertLess(damped["kinetic_energy"][-1], 0.7 * damped["kinetic_energy"][0])

    @looked_at("dropped_club.yaml")
    def test_backward_euler_takes_what_the_material_of_the_club_must(self):
        share = {}
        for method in ("bdf2", "backward-euler"):
            history = self.run_small("dropped_club.yaml", f"time.method={method}")
            by_method = history["numerical_dissipation"][-1]
            share[method] = by_method / (by_method + history["dissipated_energy"][-1])
        self.assertLess(share["bdf2"], 0.3)
        self.assertGreater(share["backward-euler"], 0.6)

    @looked_at("relaxation.yaml")
    def test_the_force_of_the_strap_falls_while_it_is_held(self):
        history = self.run_small("relaxation.yaml")
        held = history["time"] >= 0.1 - 1e-9
        force = history["tip_fx"][held]
        self.assertTrue((np.diff(force) < 0.0).all())
        # Branches of .5, .4 and .3 times the elastic force, of .1, 1 and 10 s; pulled for a tenth of a second.
        ratios, times = np.array([0.5, 0.4, 0.3]), np.array([0.1, 1.0, 10.0])
        start = ratios * times / 0.1 * (1.0 - np.exp(-0.1 / times))
        expected = 1.0 + (start * np.exp(-(history["time"][held][:, None] - 0.1) / times)).sum(axis=1)
        self.assertLess(np.abs(force / force[-1] / (expected / expected[-1]) - 1.0).max(), 0.02)

    @looked_at("ventricle.yaml")
    def test_the_apex_of_the_ventricle_goes_where_the_gallery_says(self):
        history = self.run_small("ventricle.yaml")
        self.assertAlmostEqual(history["apex_inside_z"][-1], -26.5e-3, delta=1e-3)  # a coarse mesh
        self.assertAlmostEqual(history["apex_outside_z"][-1], -28.1e-3, delta=1e-3)  # a coarse mesh


if __name__ == "__main__":
    unittest.main()
