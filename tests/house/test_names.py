"""A class name stands once in the whole package: whoever searches for it finds one thing."""

from __future__ import annotations

import ast
from collections import defaultdict

from tests.house.test_layers import PACKAGE, sources, tree

# Names that stand more than once, and why.
TWICE: dict[str, str] = {
    "Axis": "diagnosis, which is to be built anew",
    "LineTable": "names of schemas of files, which stand in the published JSON Schema",
    "Part": "diagnosis, which is to be built anew",
    "Shape": "diagnosis, which is to be built anew",
    "StylusTable": "names of schemas of files, which stand in the published JSON Schema",
    "Term": "diagnosis, which is to be built anew",
}


def homes() -> dict[str, list[str]]:
    """Class name -> files (without vcmm/) in which it is defined at the top of a module."""
    out: dict[str, list[str]] = defaultdict(list)
    for module, path in sources().items():
        for node in tree(module).body:
            if isinstance(node, ast.ClassDef):
                out[node.name].append(path.relative_to(PACKAGE).as_posix())
    return out


def test_a_class_name_stands_once():
    several = {name: tuple(files) for name, files in homes().items() if len(files) > 1}
    new = {name: files for name, files in several.items() if name not in TWICE}
    assert not new, f"name the thing by what it is, so that the name stands once: {new}"
    gone = sorted(set(TWICE) - set(several))
    assert not gone, f"no longer twice, take them out of the table: {gone}"


def test_no_class_is_called_look():
    assert "Look" not in homes()
