"""Claims: the programs in docs/PYTHON.md and README.md run."""

import contextlib
import io
import re
import unittest
from pathlib import Path

ROOT = Path(__file__).parents[3]


def run(document: Path, names: dict) -> tuple[int, str]:
    """Runs the programs of a document one after another. Returns their number and what they print."""
    programs = re.findall(r"```python\n(.*?)```", document.read_text(), re.DOTALL)
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        for program in programs:
            exec(compile(program, str(document), "exec"), names)
    return len(programs), printed.getvalue()


class Documents(unittest.TestCase):
    def test_the_programs_of_the_page_on_python_run_one_after_another(self):
        count, printed = run(ROOT / "docs" / "PYTHON.md", {})
        self.assertEqual(count, 3)
        self.assertRegex(printed, r"3.0 \[.*\] False")

    def test_the_controller_of_the_readme_stands(self):
        count, printed = run(ROOT / "README.md", {})
        self.assertEqual((count, printed), (1, "10.0 False\n"))


if __name__ == "__main__":
    unittest.main()
