"""Architecture rules, tested by reading the source: layers, rings, effects apart, heavy imports late, small pieces.

A rule that must be broken is broken in the open: in one of the tables below, with its reason. An entry that is no
longer needed fails, so the tables only hold what is true.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "vcmm"

# The whiteboard: the rooms from the ground up, and what each imports. Twins of papers live outside, beside their scenarios.
WHITEBOARD: dict[str, tuple[str, ...]] = {
    "core": (),
    "physics": ("core",),
    "part": ("core",),
    "program": ("core",),
    "task": ("core", "physics", "part", "program"),
    "answer": ("core", "physics", "part", "task"),
    "shop": ("core", "physics", "part", "program", "task", "answer"),
    "compensation": ("core", "program", "task", "shop"),
    "learn": ("core", "physics", "task", "answer"),
    "files": ("core", "physics", "part", "program", "task", "answer", "learn"),
    "show": (
        "core",
        "physics",
        "part",
        "program",
        "task",
        "answer",
        "shop",
        "files",
        "compensation",
        "learn",
    ),
    "face": (
        "core",
        "physics",
        "part",
        "program",
        "task",
        "answer",
        "shop",
        "files",
        "compensation",
        "learn",
        "show",
    ),
}
# Arrows that are never drawn: (room, room that it never imports) -> why.
NEVER: dict[tuple[str, str], str] = {
    (
        "files",
        "shop",
    ): "a file is read without the simulation of what it describes: what it states lies in program and task",
    **{
        (job, edge): "a job computes with values, wherever they were read and however they are shown"
        for job in ("task", "answer", "shop", "compensation", "learn")
        for edge in ("files", "show", "face")
    },
}
# Arrows that are not on the whiteboard and are to go, with the reason why they are still there.
TO_GO: dict[tuple[str, str], str] = {}
# Folders from the ground up: a folder imports from folders above it in this list, never from below.
FOLDERS = (
    "core",
    "physics.structure",
    "physics.catalogue",
    "physics",
    "part.fit",
    "part",
    "part.gps",
    "program",
    "program.iso",
    "program.sinumerik",
    "program.heidenhain",
    "program.okuma",
    "program.fagor",
    "shop.motion",
    "shop.cutting",
    "task",
    "task.measuring",
    "task.response",
    "task.certification",
    "task.instruments",
    "answer",
    "answer.evaluation",
    "answer.inference",
    "answer.routes",
    "answer.placing",
    "shop",
    "shop.machining",
    "learn",
    "learn.diagnosis",
    "learn.calibration",
    "learn.tracking",
    "files",
    "files.foreign",
    "files.own",
    "files.learned",
    "compensation",
    "show.report",
    "show.charts",
    "show.tables",
    "show.console",
    "show.pages",
    "show",
    "face",
    "face.public",
    "face.workbench",
    "face.cli",
)

# Effects stand alone: any file of physics/catalogue/ can be deleted. The list in physics/__init__.py is the one meeting place.
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
    ("face", "cyclopts"): "a verb declares its options; verbs are imported when they are called",
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
    """Module name without "vcmm." -> file; the package itself is ""; `python -m vcmm` is a door, no layer."""
    found = {}
    for path in sorted(set(PACKAGE.rglob("*.py")) - {PACKAGE / "__main__.py"}):
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
    """from vcmm.part.fit import gauss names the module vcmm.part.fit.gauss only where there is one of that name."""
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
    """The folder of a module."""
    folder = module if sources()[module].name == "__init__.py" else module.rpartition(".")[0]
    assert (folder or module) in FOLDERS, (
        f"{folder or module} is no folder of the list; add it to FOLDERS in {Path(__file__).name}"
    )
    return folder or module


def test_the_list_of_folders_holds_no_others():
    assert {room(module) for module in sources() if module} == set(FOLDERS)


def test_folders_import_upwards_only():
    wrong = [
        f"{i.module}:{i.line} ({room(i.module)}) imports {i.target} ({room(i.target)})"
        for i in inner_imports()
        if FOLDERS.index(room(i.target)) > FOLDERS.index(room(i.module))
    ]
    assert not wrong, "\n".join(wrong)


def arrows() -> set[tuple[str, str]]:
    """(room, room that it imports)."""
    pairs = {(i.module.split(".")[0], i.target.split(".")[0]) for i in inner_imports()}
    return {(a, b) for a, b in pairs if a != b}


def test_the_whiteboard_shows_what_each_room_imports():
    real = arrows()
    declared = {(room, other) for room, others in WHITEBOARD.items() for other in others}
    assert real - declared == set(TO_GO), "arrows beside the whiteboard, or entries of TO_GO no longer needed"
    assert declared <= real, f"no longer imported: {sorted(declared - real)}"


def test_what_is_never_imported():
    assert not arrows() & set(NEVER), {pair: NEVER[pair] for pair in arrows() & set(NEVER)}


def head(name: str) -> str:
    """The sentence at the head of a room or folder."""
    return " ".join((ast.get_docstring(tree(name)) or "").split("\n\n")[0].split())


def test_every_room_says_what_lives_there():
    for name in FOLDERS:
        assert head(name).endswith("."), f"vcmm/{name.replace('.', '/')} has no sentence at its head"


def test_the_design_draws_the_rooms_as_they_are():
    lines = (ROOT / "DESIGN.md").read_text(encoding="utf-8").splitlines()
    for name in FOLDERS:
        folder = f"{name.split('.')[-1]}/ "
        assert any(line.strip().startswith(folder) and line.endswith(head(name)) for line in lines), (
            f"DESIGN.md draws vcmm/{name.replace('.', '/')} otherwise"
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
        if within(i.module, "physics") and within(i.target, "physics") and i.module != "physics"
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
        "face.cli",
        "face.job",
        "show.console.documents",
        "show.console.files",
        "show.console.complaints",
        "show.console.terminal",
        "files.own.library",
        "core.error_names",
    ):
        for one in all_imports():
            if one.module == module and not one.late:
                assert one.target.split(".")[0] not in (*HEAVY, "numpy"), f"{module or 'vcmm'}:{one.line}"


FOR_HELP = (
    "face.cli",
    "face.cli.verb_help",
    "face.cli.options",
)  # loaded by `vcmm --help` and `vcmm VERB --help`, or read by them


def test_help_loads_no_room():
    """Verbs are imported when they run, so they import at their heads; help is read from their source (test_startup.py)."""
    wrong = [
        f"{i.module}:{i.line} imports {i.target}"
        for i in all_imports()
        if i.module in FOR_HELP and not i.late
        and (i.target.split(".")[0] == "numpy" or (i.target.startswith("vcmm.") and not i.target.startswith(("vcmm.face.cli", "vcmm.core.errors"))))
    ]  # fmt: skip
    assert not wrong, "loaded for help; import inside the function:\n" + "\n".join(wrong)


def _lines(node: ast.FunctionDef) -> int:
    """Lines of a function, without a docstring that lists its parameters (numpydoc): it grows with them, and is documentation."""
    first = node.body[0]
    listed = "\n    Parameters\n" in f"\n{ast.get_docstring(node, clean=False) or ''}"
    told = int(first.end_lineno or 0) - first.lineno + 1 if listed else 0
    return int(node.end_lineno or 0) - node.lineno + 1 - told


def test_functions_are_short():
    long = [
        f"{module}.{node.name}: {length} lines"
        for module in sources()
        for node in ast.walk(tree(module))
        if isinstance(node, ast.FunctionDef) and (length := _lines(node)) > LONGEST_FUNCTION
    ]
    assert not long, "\n".join(long)


def test_modules_are_short():
    lengths = {m: len(p.read_text(encoding="utf-8").splitlines()) for m, p in sources().items()}
    long = [f"{m}: {n} lines" for m, n in lengths.items() if n > LONGEST_MODULE]
    assert not long, "\n".join(long)


def test_the_package_runs_as_a_module():
    """`python -m vcmm` where the scripts of an environment are not on the path."""
    done = subprocess.run(
        [sys.executable, "-m", "vcmm", "--version"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert done.stdout.startswith("vcmm ")
