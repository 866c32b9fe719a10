"""Claims about Python 3.10, which the package promises: no file that users get needs a later one, unless it says so."""

import ast
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import program

ROOT = Path(__file__).parents[3]
OLDEST = (3, 10)
NEW = {"tomllib"}  # modules of the standard library that came later


def imports(node):
    """Names of the modules that a file imports whichever Python runs it: not in an `if` or a `try`."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            yield from (name.name.split(".")[0] for name in child.names)
        elif isinstance(child, ast.ImportFrom):
            yield (child.module or "").split(".")[0]
        elif not isinstance(child, (ast.If, ast.Try)):
            yield from imports(child)


class Versions(unittest.TestCase):
    def check(self, files):
        files = list(files)
        self.assertTrue(files)
        for file in files:
            tree = ast.parse(file.read_text(), str(file), feature_version=OLDEST)
            self.assertEqual(NEW & set(imports(tree)), set(), file)

    def test_an_unguarded_import_is_found_and_a_guarded_one_is_not(self):
        guarded = "import sys\nif sys.version_info >= (3, 11):\n    import tomllib\nelse:\n    import tomli as tomllib\n"
        self.assertEqual(set(imports(ast.parse(guarded))), {"sys"})
        for text in ["import tomllib", "from tomllib import loads", "def read():\n    import tomllib"]:
            self.assertEqual(set(imports(ast.parse(text))), {"tomllib"})
        with self.assertRaises(SyntaxError):  # of Python 3.11
            ast.parse("try:\n    pass\nexcept* OSError:\n    pass", feature_version=OLDEST)

    def test_the_package_and_all_controllers_and_plants_run_on_the_oldest_python(self):
        self.assertIn('requires-python = ">=3.10"', (ROOT / "pyproject.toml").read_text())
        self.check((ROOT / "launch" / "python" / "biped").rglob("*.py"))
        self.check((ROOT / "launch" / "python" / "examples").rglob("*.py"))
        self.check((ROOT / "controller" / "foreign" / "python").rglob("*.py"))
        self.check((ROOT / "plant" / "foreign").rglob("*.py"))

    def test_what_new_writes_runs_on_it_or_says_that_it_needs_a_later_one(self):
        with tempfile.TemporaryDirectory() as folder:
            for what in ["controller", "plant"]:
                program.run("new", what, f"{folder}/{what}")
                self.check(Path(folder, what).rglob("*.py"))
            program.run("new", "peers", f"{folder}/peers")
            run = Path(folder, "peers", "run.py")
            old = f"import runpy, sys; sys.version_info = {OLDEST}; runpy.run_path({str(run)!r})"
            refused = subprocess.run([sys.executable, "-c", old], capture_output=True, text=True)
            self.assertEqual((refused.returncode, refused.stderr.count("\n")), (1, 1), refused.stderr)
            self.assertIn("needs Python 3.11 or later", refused.stderr)


if __name__ == "__main__":
    unittest.main()
