#!/usr/bin/env python3
"""measure_form.py on sources whose figures are known."""

import pathlib
import tempfile
import unittest

from measure_form import Form, Function, excesses, files_of, measure

CPP = """\
// A comment is no line of the function.
int sign(int x) {
    if (x > 0) {
        return 1;
    }

    return -1;
}

int tiny() { return 0; }
"""


class Measures(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def test_functions_of_five_lines_and_more_are_counted(self):
        self.write("common/sign.cpp", CPP)
        form = measure(self.root, ["common"], [".cpp"])
        (function,) = form.functions
        self.assertEqual(function.lines, 6)
        self.assertEqual(function.complexity, 2)
        self.assertIn("sign", function.place)
        self.assertAlmostEqual(form.branches_per_10_lines, 20 / 6)
        self.assertAlmostEqual(form.tokens_per_line, function.tokens / 6)

    def test_a_function_without_a_verb_is_named(self):
        self.write("common/a.cpp", "int A::size_of() { return 1; }\nint block_of() { return 1; }\n")
        form = measure(self.root, ["common"], [".cpp"])
        self.assertEqual(form.misnamed, ["common/a.cpp:1 size_of"])

    def test_a_line_is_long_from_101_columns(self):
        self.write("common/a.hpp", "/" * 100 + "\n" + "/" * 101 + "\n" + "ž" * 100 + "\n\n")
        form = measure(self.root, ["common"], [".hpp"])
        self.assertEqual((form.files, form.lines, form.long_lines), (1, 4, 1))
        self.assertEqual(form.long_percent, 25)

    def test_installed_packages_are_left_out(self):
        for name in ("src/a.ts", "src/node_modules/b/b.ts", "src/dist/c.ts", "src/d.json"):
            self.write(name, "\n")
        self.assertEqual(files_of(self.root, ["src"], [".ts"]), [self.root / "src" / "a.ts"])

    def test_a_figure_above_its_limit_is_reported(self):
        forms = {"C++": Form(lines=4, long_lines=1, functions=[Function("f", 10, 95, 3)])}
        limits = {"tokens_per_line": 9, "branches_per_10_lines": 3, "long_percent": None}
        self.assertEqual(
            excesses(forms, limits), ["C++: tokens_per_line is 9.50; allowed: 9 or less"]
        )

    def test_nothing_is_measured_where_there_are_no_sources(self):
        form = Form()
        self.assertEqual(
            (form.tokens_per_line, form.branches_per_10_lines, form.long_percent), (0, 0, 0)
        )


if __name__ == "__main__":
    unittest.main()
