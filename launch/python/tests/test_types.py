"""Claims about types and help: the stub, `_biped.pyi`, describes the compiled module, and help() says the same as the stub."""

import ast
import inspect
import unittest
from pathlib import Path

from biped import _biped, records

STUB = ast.parse((Path(_biped.__file__).parent / "_biped.pyi").read_text())


def public(names):
    return {name for name in names if not name.startswith("_")}


class Types(unittest.TestCase):
    def described(self, node, what):
        """Checks the documentation of a class or function, and returns its members."""
        if (told := ast.get_docstring(node)) is not None:
            self.assertEqual(inspect.getdoc(what), told, f"{node.name}: renew the one from the other")
        return getattr(node, "body", [])

    def test_the_stub_and_the_module_have_the_same_names_and_help(self):
        nodes = {node.name: node for node in STUB.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(public(nodes), public(dir(_biped)))
        for name, node in nodes.items():
            members = {member.name: member for member in self.described(node, getattr(_biped, name)) if hasattr(member, "name")}
            if isinstance(node, ast.FunctionDef) or not public(members):
                continue
            self.assertEqual(public(members), public(dir(getattr(_biped, name))), name)
            for member in public(members):
                self.described(members[member], getattr(getattr(_biped, name), member))

    def test_arguments_have_the_names_of_the_stub(self):
        for node in (node for node in STUB.body if isinstance(node, ast.ClassDef)):
            for method in (part for part in node.body if isinstance(part, ast.FunctionDef)):
                what = inspect.getattr_static(getattr(_biped, node.name), method.name, None)
                if method.name.startswith("__") or not callable(what) or isinstance(what, staticmethod):
                    continue
                arguments = method.args.args + method.args.kwonlyargs
                self.assertEqual(list(inspect.signature(what).parameters), [argument.arg for argument in arguments], method.name)

    def test_records_have_the_offsets_of_the_wire(self):
        truth = records.dtype("Truth")
        self.assertEqual(truth.itemsize, 1376)
        for name, size, fields in _biped.layout():
            self.assertEqual(records.dtype(name).itemsize, size)
            self.assertTrue(all(meaning for *_, meaning in fields), name)


if __name__ == "__main__":
    unittest.main()
