"""tools/check_sizes.py finds long files and long functions, wherever they are defined, and nothing else."""
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]


class CheckSizes(unittest.TestCase):
    def complaints(self, text):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "a.hpp").write_text(text)
            command = [ROOT / "tools/check_sizes.py", folder]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            lines = [line for line in done.stdout.splitlines() if line.startswith("a.hpp")]
            self.assertEqual(done.returncode, 1 if lines else 0, done.stderr)
            return lines

    def test_long_file_is_found(self):
        self.assertEqual(self.complaints("\n" * 450), [])
        self.assertEqual(self.complaints("\n" * 451), ["a.hpp: 451 lines, of 450 at most: part it"])

    def test_long_function_is_found_with_its_line(self):
        body = "  if (x) {\n    y(\"}\", '}');  // }\n  }\n"
        heads = {
            "of a namespace": "namespace a {\nint f(const std::vector<int>& x = {1, 2}) {\n",
            "of a class": "class A final : public B<C> {\n  int f() const override {\n",
            "of a class template": "template <class T>\nrequires std::copyable<T>\nstruct A {\n  auto f() -> std::optional<T> {\n",
            "a constructor": "struct A {\n  explicit A(int n) : n_(n), m_{{n, n}} {\n",
            "after a table": "constexpr std::array<int, 2> x{{1, 2}};\nenum class B { c };\nvoid f(B) noexcept {\n",
            "after raw text": 'const char* page = R"md({ ( )md";\n/* { */ void f() {\n',
            "an operator": "#define M {\ntemplate <class T>\nvoid A<T>::operator()(int k) const& {\n",
        }
        for what, head in heads.items():
            closing = "}\n" * (head.count("{\n") - what.startswith("an operator")) if "raw" not in what else "}\n"
            for lines, found in ((75, 0), (81, 1)):
                with self.subTest(what, lines=lines):
                    text = head + body * (lines // 3) + closing
                    self.assertEqual(len(self.complaints(text)), found, self.complaints(text))
        (line,) = self.complaints("\n\nint f() {\n" + "\n" * 79 + "}\n")
        self.assertEqual(line, "a.hpp:3: a function of 81 lines, of 80 at most: part it")

    def test_what_is_no_function_may_be_long(self):
        rows = "    {1, f(2)},\n" * 100
        for head in ("constexpr std::array<A, 100> table{{\n", "const A table = {{\n"):
            self.assertEqual(self.complaints(head + rows + "}};\n"), [])
        self.assertEqual(self.complaints("class A {\n" + "  int f() { return 1; }\n" * 100 + "};\n"), [])


if __name__ == "__main__":
    unittest.main()
