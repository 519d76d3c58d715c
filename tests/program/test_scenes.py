#!/usr/bin/python3
"""Random scenes of bodies that hit one another: some seeds of those that scene_runs.py runs, and that its check finds what it should."""
import re
import unittest

from overlaps import overlaps
from program import ProgramTest, swept
from scene_runs import run_scene
from scenes import write_scene

# Seeds, and on how many ranks: the fast ones among those with a history (docs/developer/hygiene.md).
SEEDS = {3: 2, 7: 1, 8: 1, 13: 1, 57: 1}


class Scenes(ProgramTest):
    def test_bodies_do_not_pass_one_another(self):
        for seed, ranks in swept(list(SEEDS.items()), [(3, 2), (8, 1), (57, 1)]):
            with self.subTest(seed=seed, ranks=ranks):
                directory = self.directory / str(seed)
                directory.mkdir()
                outcome = run_scene(seed, directory, ranks)
                self.assertEqual(outcome.problems, [], outcome)
                self.assertGreater(outcome.accepted, 0)

    def test_bodies_that_pass_one_another_are_found(self):
        scene = write_scene(8, self.directory)
        text = scene.input.read_text(encoding="ascii")
        scene.input.write_text(re.sub("(?m)^contact: .*\n", "", text), encoding="ascii")
        self.run_input(scene.input)
        self.assertTrue(overlaps(self.directory / "out/result.h5", scene.touching))


if __name__ == "__main__":
    unittest.main()
