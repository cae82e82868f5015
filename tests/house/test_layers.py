"""Architecture rules, tested by reading the source: layers, rings, effects apart, heavy imports late, small pieces.

A rule that must be broken is broken in the open: in one of the tables below, with its reason. An entry that is no
longer needed fails, so the tables only hold what is true.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "vcmm"

# From the ground up. A room imports from itself and from rooms above it in this list, never from below.
ROOMS = (
    "former_paths",
    "core",
    "fit",
    "part",
    "gps",
    "effects",
    "report",
    "charts",
    "nc",
    "nc.iso",
    "nc.sinumerik",
    "nc.heidenhain",
    "nc.okuma",
    "motion",
    "cutting",
    "measuring",
    "response",
    "certified",
    "instruments",
    "evaluation",
    "inference",
    "exchange",
    "routes",
    "placing",
    "machining",
    "files",
    "library",
    "compensating",
    "diagnosis",
    "calibrating",
    "api",
    "tables",
    "console",
    "pages",
    "workbench",
    "papers",
    "papers.echerfaoui2017",
    "papers.gaska2014",
    "papers.marin2004",
    "papers.abbe_milling",
    "cases",
    "cli",
)

# Effects stand alone: any file of effects/ can be deleted. The list in effects/__init__.py is the one meeting place.
EFFECT_TO_EFFECT: dict[tuple[str, str], str] = {}

# Libraries that cost more than 50 ms to import are imported by the function that needs them.
HEAVY = (
    "scipy",
    "numba",
    "trimesh",
    "pyvista",
    "vtk",
    "matplotlib",
    "pydantic",
    "cyclopts",
    "rich",
    "tomlkit",
)
HEAVY_AT_TOP = {
    ("files", "pydantic"): "schemas are classes of pydantic; files are read only after a command has started",
    ("cli", "cyclopts"): "a verb declares its options; verbs are imported when they are called",
}
# Kernels are decorated at module level, so their files import numba; nothing imports those files at module level.
KERNELS = "_kernels"

LONGEST_FUNCTION, LONGEST_MODULE = 60, 400


@dataclass(frozen=True)
class Import:
    """`module` imports `target`; late = inside a function, or for types alone."""

    module: str
    target: str
    line: int
    late: bool


@cache
def sources() -> dict[str, Path]:
    """Module name without "vcmm." -> file; the package itself is ""."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(p for p in parts if p != "__init__")] = path
    return found


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(sources()[module].read_text(encoding="utf-8"))


def imports_of(module: str) -> Iterator[Import]:
    def walk(node: ast.AST, late: bool) -> Iterator[Import]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.Import):
                yield from (Import(module, alias.name, child.lineno, late) for alias in child.names)
            elif isinstance(child, ast.ImportFrom):
                assert child.level == 0, f"{module}:{child.lineno}: write the full name, vcmm...."
                for name in {_target(str(child.module), alias.name) for alias in child.names}:
                    yield Import(module, name, child.lineno, late)
            yield from walk(
                child, late or isinstance(child, ast.FunctionDef | ast.Lambda) or _for_types(child)
            )

    yield from walk(tree(module), False)


def _for_types(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"


def _target(module: str, name: str) -> str:
    """from vcmm.fit import gauss names the module vcmm.fit.gauss only where there is one of that name."""
    return f"{module}.{name}" if f"{module}.{name}".removeprefix("vcmm.") in sources() else module


@cache
def all_imports() -> tuple[Import, ...]:
    return tuple(one for module in sources() for one in imports_of(module))


def inner_imports() -> list[Import]:
    """Imports within the package; the package itself (its version) is no layer."""
    return [
        Import(i.module, i.target.removeprefix("vcmm."), i.line, i.late)
        for i in all_imports()
        if i.target.startswith("vcmm.") and i.module
    ]


def within(module: str, name: str) -> bool:
    return module == name or module.startswith(f"{name}.")


def room(module: str) -> str:
    """The folder of a module; a module beside the folders is a room of its own."""
    folder = module if sources()[module].name == "__init__.py" else module.rpartition(".")[0]
    assert (folder or module) in ROOMS, (
        f"{folder or module} is no room; add it to ROOMS in {Path(__file__).name}"
    )
    return folder or module


def test_the_list_of_rooms_holds_no_others():
    assert {room(module) for module in sources() if module} == set(ROOMS)


def test_rooms_import_upwards_only():
    wrong = [
        f"{i.module}:{i.line} ({room(i.module)}) imports {i.target} ({room(i.target)})"
        for i in inner_imports()
        if ROOMS.index(room(i.target)) > ROOMS.index(room(i.module))
    ]
    assert not wrong, "\n".join(wrong)


def head(name: str) -> list[str]:
    """Paragraphs at the head of a room."""
    said = ast.get_docstring(tree(name)) or ""
    return [" ".join(paragraph.split()) for paragraph in said.split("\n\n")]


def folders() -> list[str]:
    return [name for name in ROOMS if sources()[name].name == "__init__.py"]


def test_every_room_says_what_lives_there_and_what_it_imports():
    for name in folders():
        met = {room(i.target) for i in inner_imports() if room(i.module) == name} - {name}
        listed = ", ".join(r for r in ROOMS if r in met) or "nothing of vcmm outside this room"
        assert head(name)[0].endswith("."), f"vcmm/{name.replace('.', '/')} has no sentence at its head"
        assert head(name)[1] == f"Imports {listed}.", f"vcmm/{name.replace('.', '/')}/__init__.py"


def test_the_design_draws_the_rooms_as_they_are():
    drawn = (ROOT / "DESIGN.md").read_text(encoding="utf-8")
    for name in folders():
        line = next(
            (one for one in drawn.splitlines() if one.strip().startswith(f"{name.split('.')[-1]}/ ")), ""
        )
        assert line.endswith(head(name)[0]), (
            f"DESIGN.md draws vcmm/{name.replace('.', '/')} otherwise: {line}"
        )


def test_there_is_no_import_ring():
    """Late imports count too: a ring is a ring, whenever it closes."""
    graph: dict[str, set[str]] = {module: set() for module in sources()}
    for one in inner_imports():
        graph[one.module].add(one.target)
    assert not rings(graph), "\n".join(" -> ".join(ring) for ring in rings(graph))


def rings(graph: dict[str, set[str]]) -> list[list[str]]:
    """One path module -> ... -> module for every module that reaches itself through the shortest ring."""
    found = []
    for start in graph:
        paths, seen = [[start]], {start}
        while paths:
            path = paths.pop(0)
            if start in graph.get(path[-1], ()):
                found.append([*path, start])
                break
            for following in sorted(graph.get(path[-1], set()) - seen):
                seen.add(following)
                paths.append([*path, following])
    return found


def test_a_ring_is_found():
    assert rings({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert ["a", "b", "c", "a"] in rings({"a": {"b"}, "b": {"c"}, "c": {"a"}})


def test_effects_do_not_import_one_another():
    met = {
        (i.module, i.target)
        for i in inner_imports()
        if within(i.module, "effects") and within(i.target, "effects") and i.module != "effects"
    }
    assert not met - set(EFFECT_TO_EFFECT), (
        f"effects import one another: {sorted(met - set(EFFECT_TO_EFFECT))}"
    )
    assert not set(EFFECT_TO_EFFECT) - met, f"no longer needed: {sorted(set(EFFECT_TO_EFFECT) - met)}"


def heavy_at_top() -> Iterator[tuple[Import, str]]:
    for one in all_imports():
        library = one.target.split(".")[0]
        if library in HEAVY and not one.late:
            yield one, library


def test_heavy_libraries_are_imported_late():
    wrong, used = [], set()
    for one, library in heavy_at_top():
        key = (one.module.split(".")[0], library)
        used.add(key)
        kernel = library == "numba" and one.module.endswith(KERNELS)
        if not kernel and key not in HEAVY_AT_TOP:
            wrong.append(f"{one.module}:{one.line} imports {library} at module level")
    assert not wrong, "\n".join(wrong)
    assert not set(HEAVY_AT_TOP) - used, f"no longer needed: {sorted(set(HEAVY_AT_TOP) - used)}"


def test_kernels_and_numpy_free_modules():
    """Kernel files are imported inside functions; errors and the package itself import no library at all."""
    inner = [i for i in inner_imports() if not i.module.endswith(KERNELS)]  # one kernel may call another
    wrong = [f"{i.module}:{i.line}" for i in inner if i.target.endswith(KERNELS) and not i.late]
    assert not wrong, f"import the kernel inside the calling function: {wrong}"
    for module in (
        "",
        "core.errors",
        "core.units",
        "cli",
        "console.documents",
        "console.files",
        "console.complaints",
        "console.terminal",
        "library",
        "core.error_names",
    ):
        for one in all_imports():
            if one.module == module and not one.late:
                assert one.target.split(".")[0] not in (*HEAVY, "numpy"), f"{module or 'vcmm'}:{one.line}"


def test_commands_load_numpy_late():
    wrong = [
        f"{i.module}:{i.line} imports {i.target}"
        for i in all_imports()
        if within(i.module, "cli") and not i.late
        and (i.target.split(".")[0] == "numpy" or (i.target.startswith("vcmm.") and not i.target.startswith(("vcmm.cli", "vcmm.core.errors"))))
    ]  # fmt: skip
    assert not wrong, "a verb is imported for its --help; import inside the function:\n" + "\n".join(wrong)


def test_functions_are_short():
    long = [
        f"{module}.{node.name}: {length} lines"
        for module in sources()
        for node in ast.walk(tree(module))
        if isinstance(node, ast.FunctionDef)
        and (length := int(node.end_lineno or 0) - node.lineno + 1) > LONGEST_FUNCTION
    ]
    assert not long, "\n".join(long)


def test_modules_are_short():
    lengths = {m: len(p.read_text(encoding="utf-8").splitlines()) for m, p in sources().items()}
    long = [f"{m}: {n} lines" for m, n in lengths.items() if n > LONGEST_MODULE]
    assert not long, "\n".join(long)
