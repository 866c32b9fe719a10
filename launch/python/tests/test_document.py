"""Claim: the programs in docs/PYTHON.md run."""

import contextlib
import io
import re
import unittest
from pathlib import Path

DOCUMENT = Path(__file__).parents[3] / "docs" / "PYTHON.md"


class Document(unittest.TestCase):
    def test_its_programs_run_one_after_another(self):
        programs = re.findall(r"```python\n(.*?)```", DOCUMENT.read_text(), re.DOTALL)
        self.assertEqual(len(programs), 3)
        names = {}
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            for program in programs:
                exec(compile(program, str(DOCUMENT), "exec"), names)
        self.assertRegex(printed.getvalue(), r"3.0 \[.*\] False")


if __name__ == "__main__":
    unittest.main()
