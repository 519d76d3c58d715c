"""What the tests of mistakes share: many runs at a time, each of which must end with one message and the right exit code."""
import concurrent.futures
import re
import time

from program import LONG, ProgramTest, finish, start

FROM_MPIRUN = re.compile(r"-{20,}\n.*?-{20,}\n", re.DOTALL)  # what it says of a code that is not 0
NOISE = ("PETSC ERROR", "Traceback", "terminate called", "Segmentation", "PetscFailure", "MPI_ABORT", "HDF5-DIAG", "pliant failed",
         "gmsh died", "HDF5:")


class MistakesTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.pool = concurrent.futures.ThreadPoolExecutor(4)  # most of a run under mpirun is waiting
        self.addCleanup(self.pool.shutdown)

    def judge(self, directory, arguments, ranks, code, place, words):
        """The program ends with `code` and one message, which has `words` (a pattern) and names `place` (or None) once."""
        done = finish(start(arguments, directory, ranks), 60)
        told = FROM_MPIRUN.sub("", done.stderr)
        shown = f"{' '.join(map(str, arguments))} on {ranks} ranks: code {done.returncode}\n{done.stdout}{done.stderr}"
        self.assertEqual(done.returncode, code, shown)
        self.assertRegex(told, words, shown)
        if place is not None:
            self.assertEqual(told.count(place), 1, f"{place} is not named once\n{shown}")
        lines = [line for line in told.splitlines() if line and not line.startswith("  ")]  # gmsh's words are indented
        self.assertEqual(len(lines), len(set(lines)), shown)
        self.assertLessEqual(len(lines), 2, shown)
        for noise in (noise for noise in NOISE if noise not in words):
            self.assertNotIn(noise, done.stdout + done.stderr, shown)

    def judge_all(self, cases, every):
        """Each case, several at a time. `every`: number of ranks -> each how many-th case runs on them; with PLIANT_LONG_TESTS each.
        The runs of one case are one after another: they share its directory. Those that took longest are
        printed if LONG."""
        took = {ranks: [] for ranks in every}

        def judge_one(number, name, case):
            for ranks in (ranks for ranks, nth in every.items() if LONG or number % nth == 0):
                directory, arguments, code, place, words = case
                begin = time.perf_counter()
                self.judge(directory, arguments, ranks, code, place, words)
                took[ranks].append((time.perf_counter() - begin, name))

        waiting = [(name, self.pool.submit(judge_one, number, name, case)) for number, (name, case) in enumerate(cases.items())]
        for name, result in waiting:
            with self.subTest(name):
                result.result()
        for ranks, times in took.items():
            if LONG and times:
                slowest = ", ".join(f"{name} {seconds:.1f} s" for seconds, name in sorted(times, reverse=True)[:3])
                print(f"{self.id()}: {len(times)} mistakes on {ranks}, the slowest: {slowest}")
