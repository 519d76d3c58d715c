"""The inputs that come with the program run, each at a small size, and show what the gallery says of them."""
import unittest

import numpy as np
from program import ROOT, ProgramTest, long_test

# File in input/ -> what makes it small.
SMALL = {
    "beam_small.yaml": ["time.end=0.03"],
    "bellows.yaml": ["element=P1", "mesh.size=5 mm", "time.step=0.1", "time.end=0.2"],
    "bracket.yaml": ["mesh.size=0.006", "element=P1", "time.load_steps=2"],
    "buckled_plate.yaml": ["mesh.size=0.2", "time.path.max_load=1.2"],
    "cantilever.yaml": ["mesh.size=0.2", "time.end=0.05"],
    "coil_spring.yaml": ["time.end=0.03"],
    "draped_cloth.yaml": ["time.end=0.03"],
    "dropped_club.yaml": ["mesh.size=0.02", "time.end=0.25"],
    "falling_blocks.yaml": ["mesh.size=0.012", "time.end=0.1", "time.step=0.004"],
    "four_clubs.yaml": ["mesh.size=0.02", "time.end=0.02"],
    "gripper.yaml": ["time.step=20 ms", "time.end=0.52", "time.events=[]", "contact.friction_update=frozen"],
    "gripper_finger.yaml": ["mesh.size=0.02", "time.end=0.02"],
    "hung_rope.yaml": ["mesh.size=0.02", "time.end=0.03"],
    "layered_finger.yaml": ["mesh.size=12 mm", "element=P1", "time.end=0.06", "time.events=[]"],
    "muscle.yaml": ["mesh.size=0.2", "time.end=0.1"],
    "pile.yaml": ["mesh.size=8 mm", "time.end=0.04", "time.step=0.004"],
    "released_beam.yaml": ["mesh.size=0.2", "time.end=0.1"],
    "roof.yaml": [],
    "soft_flail.yaml": ["time.end=0.06"],
    "pneunet.yaml": ["element=P1", "mesh.size=12 mm", "time.end=0.1"],
    "pneunet_grip.yaml": ["element=P1", "mesh.size=12 mm", "time.end=0.2"],
    "pneumatic_actuator.yaml": ["time.end=0.02", "time.events=[]"],
    "relaxation.yaml": ["time.step=20 ms", "time.end=1"],
    "damper.yaml": ["mesh.size=6 mm", "time.end=0.01"],
    "tendon_gripper.yaml": ["mesh.size=6 mm", "time.step=20 ms", "time.end=0.6", "time.events=[]"],
    "snapping_cap.yaml": ["mesh.size=8 mm", "element=P1", "time.path.max_steps=8"],
    "static_bending.yaml": ["mesh.size=0.2", "time.load_steps=4"],
    "tendon_finger.yaml": ["mesh.size=12 mm", "time.end=0.04"],
    "thrown_box.yaml": ["mesh.size=0.025", "time.end=0.8", "time.step=0.004"],
    "wound_bend.yaml": ["loads.0.pressure=10 kPa", "time.load_steps=1"],
    "wound_twist.yaml": ["loads.0.pressure=3 kPa", "time.load_steps=1"],
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

    @looked_at("tendon_gripper.yaml")
    def test_the_gripper_with_tendons_lifts_the_ball(self):
        h = self.run_small("tendon_gripper.yaml")
        weight = 9.81 * 1000 * 4 / 3 * np.pi * 15e-3**3  # that of the mesh has a twentieth less
        at = lambda name, time: h[name][np.abs(h["time"] - time).argmin()]
        self.assertAlmostEqual(at("table_ball_fz", 0.06) / weight, 0.95, delta=0.03)
        self.assertEqual(np.abs(h["table_ball_fz"][h["time"] > 0.3]).max(), 0, "it still lies on the table")
        lift = 0.02 * (1 - np.cos(np.pi * 0.2 / 0.4))
        self.assertAlmostEqual(h["lift_travel"][-1], lift, delta=1e-4)
        self.assertAlmostEqual(h["ball_z"][-1] - at("ball_z", 0.4), lift, delta=0.02 * lift)
        # Halfway up the palm does not accelerate.
        self.assertAlmostEqual(h["grip_fz"][-1] / weight, 0.95, delta=0.03)
        self.assertEqual(h["left_tension"][-1], 5)

    @long_test  # test_documents.py runs some steps of it
    @looked_at("gripper.yaml")
    def test_the_gripper_lifts_the_fruit(self):
        # Coarser in time than the input, and up to where the fruit is in the air, held by the fingers alone.
        h = self.run_small("gripper.yaml")
        self.assertEqual(len(h["step"]), 27, "a step was cut")
        self.assertGreater(h["stand_fruit_fz"][5], 0.15, "it lies on the stand")
        self.assertEqual(np.abs(h["stand_fruit_fz"][h["time"] > 0.45]).max(), 0)
        mount = 0.03 * (1 - np.cos(np.pi * 0.12 / 0.5))
        self.assertAlmostEqual(h["fruit_z"][-1] - h["fruit_z"][h["time"] > 0.395][0], mount, delta=0.1 * mount)
        weight = 9.81 * 1000 * 4 / 3 * np.pi * 17e-3**2 * 22e-3  # of the ellipsoid; that of the mesh has a tenth less
        lift = 0.03 * (np.pi / 0.5) ** 2 * np.cos(np.pi * 0.12 / 0.5)  # the mount's acceleration
        self.assertAlmostEqual(h["grip_fz"][-1] / (weight * (1 + lift / 9.81)), 0.92, delta=0.05)
        self.assertLess(np.hypot(h["grip_fx"][-1], h["grip_fy"][-1]), 0.1 * h["grip_fz"][-1], "both fingers push alike")
        self.assertGreater(h["dissipated_friction"][-1], 1e-4)
        self.assertGreater(h["contact_gap_min"].min(), 0)
        self.assertLess(np.abs(h["energy_balance_error"]).max(), 1e-6 * h["elastic_energy"].max())

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
