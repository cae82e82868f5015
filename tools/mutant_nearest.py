"""Which tests stand nearest to a function, read off the sources alone: who names it, who names those, and so on to the tests.

A test that names the function has distance 1, one that calls a function which names it has distance 2. A name counts where it is
the function's own: defined in that file or imported from it, also by way of a package that offers it. A method counts wherever
its name follows a dot, since the class of an object is not known here. Fixtures count as their test's own words.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

GUESS = 0.15  # s of computing: of a test that runs every day, on average
SLOW = ("thorough", "count")  # marks of tests that do not run every day
STYLE = "tests/house/"  # asks how the sources are written, not what they compute

Node = tuple[str, str]  # (file, name); ("", method) for a method of an unknown class


@dataclass
class _File:
    """What one source file says: its imports and, for every name at its top, the names that this one uses."""

    path: str
    imports: dict[str, Node] = field(default_factory=dict)
    uses: dict[str, set[Node]] = field(default_factory=dict)
    tests: list[str] = field(default_factory=list)  # such as test_a or TestA::test_b
    slow: set[str] = field(default_factory=set)


class Nearest:
    """Tests by their distance from a function; those of the module's own test file and folder are taken to be nearer."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.seconds: defaultdict[str, float] = defaultdict(lambda: GUESS)
        paths = [p for top in ("vcmm", "tests") for p in sorted((root / top).rglob("*.py"))]
        self.files = {p.relative_to(root).as_posix(): _read(root, p) for p in paths}
        self.users: defaultdict[Node, set[Node]] = defaultdict(set)
        for file in self.files.values():
            for name, used in file.uses.items():
                for node in used:
                    self.users[self._defined(node)].add((file.path, name))

    def noticing(self, file: str, owner: str) -> list[str]:
        """Tests that can notice a change in `owner` of `file`, the nearest first; then the rest of the folder of tests."""
        inside = Path(file).relative_to("vcmm")
        stem, folder = inside.stem.strip("_").removesuffix("_kernels"), self._folder(inside)
        ranks: dict[str, tuple[float, str]] = {}
        for (path, name), distance in self._distances(file, owner).items():
            if path.startswith("tests/") and name in self.files[path].tests:
                own = 2.0 * (stem in Path(path).stem) + 1.0 * path.startswith(folder)
                ranks[f"{path}::{name}"] = (distance - own, path)
        for path, one in self.files.items():
            if path.startswith(folder):
                for name in one.tests:
                    ranks.setdefault(f"{path}::{name}", (100.0 - 2.0 * (stem in Path(path).stem), path))
        every = sorted(ranks, key=lambda test: ranks[test])
        return [t for t in every if not t.startswith(STYLE)]

    def _folder(self, inside: Path) -> str:
        folder = self.root / "tests" / inside.parent
        while not folder.is_dir():
            folder = folder.parent
        return folder.relative_to(self.root).as_posix() + "/"

    def _distances(self, file: str, owner: str) -> dict[Node, int]:
        """How many steps lead from the function to whatever uses it."""
        name = owner.split(".<locals>")[0]
        start = {(file, name)} if name else {(file, n) for n in self.files[file].uses}
        out: dict[Node, int] = dict.fromkeys(start, 0)
        level, distance = start, 0
        while level:
            distance += 1
            following = {user for node in level for also in _answers_to(node) for user in self.users[also]}
            level = following - out.keys()
            out |= dict.fromkeys(level, distance)
        return out

    def _defined(self, node: Node) -> Node:
        """Where a name is defined that packages only pass on."""
        seen = set()
        while node not in seen and node[0] in self.files and node[1] in self.files[node[0]].imports:
            seen.add(node)
            node = self.files[node[0]].imports[node[1]]
        return node


def _answers_to(node: Node) -> Iterator[Node]:
    """What the users of a node may write: a method is called by its name after a dot, or with its class."""
    file, name = node
    yield node
    if "." in name:
        owner, method = name.split(".", 1)
        if method.startswith("__"):
            yield file, owner
        else:
            yield "", method


def _read(root: Path, path: Path) -> _File:
    out = _File(path.relative_to(root).as_posix())
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                out.imports[alias.asname or alias.name] = _target(root, node.module, alias.name)
        elif isinstance(node, ast.Import):
            for alias in node.names:
                out.imports[alias.asname or alias.name] = (_file(root, alias.name), "")
    everyday = not any(f"mark.{mark}" in _marks(tree.body) for mark in SLOW)
    for name, part in _named(tree.body):
        out.uses.setdefault(name, set()).update(_used(root, out, part))
        test = name.replace(".", "::")
        slow = isinstance(part, ast.FunctionDef) and any(
            f"mark.{mark}" in ast.unparse(d) for d in part.decorator_list for mark in SLOW
        )
        if test.split("::")[-1].startswith("test_") and everyday and not slow and "test_" in path.stem:
            out.tests.append(test)
            out.uses[test] = out.uses[name]
    return out


def _marks(body: list[ast.stmt]) -> str:
    return " ".join(
        ast.unparse(s)
        for s in body
        if isinstance(s, ast.Assign) and "pytestmark" in ast.unparse(s.targets[0])
    )


def _named(body: list[ast.stmt]) -> Iterator[tuple[str, ast.stmt]]:
    """Functions, methods and constants at the top of a file, by their name."""
    for part in body:
        if isinstance(part, ast.FunctionDef):
            yield part.name, part
        elif isinstance(part, ast.ClassDef):
            yield part.name, ast.Expr(ast.Tuple([*part.bases, *part.decorator_list]))
            for name, inner in _named(part.body):
                yield f"{part.name}.{name}", inner
        elif isinstance(part, ast.Assign | ast.AnnAssign):
            targets = part.targets if isinstance(part, ast.Assign) else [part.target]
            for target in targets:
                if isinstance(target, ast.Name):
                    yield target.id, part


def _used(root: Path, file: _File, part: ast.stmt) -> set[Node]:
    """Names that a part uses, each with the file that it comes from."""
    out: set[Node] = set()
    for node in ast.walk(part):
        if isinstance(node, ast.Name):
            out.add(file.imports.get(node.id, (file.path, node.id)))
        elif isinstance(node, ast.Attribute):
            out.add(("", node.attr))
            if isinstance(node.value, ast.Name) and file.imports.get(node.value.id, ("", "x"))[1] == "":
                out.add((file.imports[node.value.id][0], node.attr))
        elif isinstance(node, ast.arg) and file.path.startswith("tests/"):
            out.add((file.path, node.arg))
            out |= {((p / "conftest.py").as_posix(), node.arg) for p in Path(file.path).parents}
    return out


def _target(root: Path, module: str, name: str) -> Node:
    """What an import names: a module, or a name within one."""
    inner = _file(root, f"{module}.{name}")
    return (inner, "") if inner else (_file(root, module), name)


def _file(root: Path, module: str) -> str:
    stem = module.replace(".", "/")
    for path in (f"{stem}.py", f"{stem}/__init__.py"):
        if module.split(".")[0] in ("vcmm", "tests") and (root / path).is_file():
            return path
    return ""
