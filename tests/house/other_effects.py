"""The package with other effects than it has, without a copy on the disk: a file of the catalogue gone with its lines, or one added.

    python -m tests.house.other_effects       imports everything else, once without each file of physics/catalogue/

A finder answers for `vcmm.physics` with another text and refuses, or adds, files of its catalogue. It is to be put in place before
vcmm.physics is imported, so every change has a process of its own (a fork of one that has the libraries loaded).
"""

from __future__ import annotations

import ast
import gc
import importlib
import importlib.abc
import importlib.machinery
import os
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from tempfile import TemporaryDirectory
from types import ModuleType

from tests.house.test_layers import PACKAGE, inner_imports, sources, within

EFFECTS = PACKAGE / "physics"
CATALOGUE, ROOM = EFFECTS / "catalogue", "vcmm.physics.catalogue"
LIBRARIES = ("numpy", "numba", "pydantic", "cyclopts", "rich", "scipy.spatial", "scipy.interpolate")


class OtherEffects(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """texts: module name -> source, for `vcmm.physics` and what is added to it; gone: module names that are no more."""

    def __init__(self, texts: Mapping[str, str], gone: Sequence[str] = ()) -> None:
        self.texts, self.gone = texts, gone

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname in self.gone:
            raise ModuleNotFoundError(f"{fullname} was deleted", name=fullname)
        if fullname not in self.texts:
            return None
        spec = importlib.machinery.ModuleSpec(fullname, self, is_package=fullname == "vcmm.physics")
        if spec.submodule_search_locations is not None:
            spec.submodule_search_locations.append(str(EFFECTS))
        return spec

    def exec_module(self, module: ModuleType) -> None:
        exec(compile(self.texts[module.__name__], module.__name__, "exec"), module.__dict__)

    def install(self) -> None:
        assert "vcmm.physics" not in sys.modules
        sys.meta_path.insert(0, self)


def files() -> list[str]:
    """Names of the files of the catalogue: each can be deleted."""
    return sorted(p.stem for p in CATALOGUE.glob("*.py") if p.stem != "__init__")


def classes_of(stem: str) -> list[str]:
    """The classes of one file that stand in ALL."""
    tree = ast.parse((EFFECTS / "__init__.py").read_text(encoding="utf-8"))
    lines = [n for n in tree.body if isinstance(n, ast.ImportFrom) and n.module == f"{ROOM}.{stem}"]
    return [alias.name for line in lines for alias in line.names]


def names_of(stem: str) -> list[str]:
    """The names of the effects that one file declares."""
    tree = ast.parse((CATALOGUE / f"{stem}.py").read_text(encoding="utf-8"))
    inner = [n for c in tree.body if isinstance(c, ast.ClassDef) for n in c.body if isinstance(n, ast.Assign)]
    return [str(ast.literal_eval(n.value)) for n in inner if ast.unparse(n.targets[0]) == "name"]


def without(stem: str) -> OtherEffects:
    """A file deleted, its import and its lines in ALL with it."""
    text = (EFFECTS / "__init__.py").read_text(encoding="utf-8")
    gone = classes_of(stem)
    assert gone, f"vcmm/physics/catalogue/{stem}.py has no line in vcmm/physics/__init__.py"
    node = next(n for n in ast.parse(text).body if getattr(n, "module", "") == f"{ROOM}.{stem}")
    lines = text.splitlines()
    rest = [*lines[: node.lineno - 1], *lines[node.end_lineno or node.lineno :]]
    kept = [line for line in rest if line.strip() not in {f"{name}," for name in gone}]
    assert len(kept) == len(rest) - len(gone)
    return OtherEffects({"vcmm.physics": "\n".join(kept)}, (f"{ROOM}.{stem}",))


def with_file(stem: str, source: str, name: str) -> OtherEffects:
    """A file added, with one line in ALL for the class `name` (and the import that it takes)."""
    text = (EFFECTS / "__init__.py").read_text(encoding="utf-8")
    head, tail = text.split("\nALL: tuple[type[Effect], ...] = (\n", 1)
    listed = (
        f"{head}\nfrom {ROOM}.{stem} import {name}\nALL: tuple[type[Effect], ...] = (\n    {name},\n{tail}"
    )
    return OtherEffects({"vcmm.physics": listed, f"{ROOM}.{stem}": source})


def modules() -> list[str]:
    """All modules of the package but the files of the catalogue."""
    return [f"vcmm.{m}".rstrip(".") for m in sources() if not m.startswith("physics.catalogue.")]


def apart_from_effects() -> list[str]:
    """The modules that load nothing of physics/ when they are imported."""
    graph = {
        m: {m.rpartition(".")[0]} if m else set() for m in sources()
    }  # a package is loaded before what is in it
    for one in inner_imports():
        if not one.late:
            graph[one.module].add(one.target)

    def loaded(start: str) -> set[str]:
        seen, open_ = {start}, [start]
        while open_:
            new = graph.get(open_.pop(), set()) - seen
            seen |= new
            open_ += new
        return seen

    return [f"vcmm.{m}" for m in graph if m and not any(within(x, "physics") for x in loaded(m))]


def import_all_without(stem: str) -> None:
    """Import every module of the package without one file of the catalogue."""
    gc.disable()
    without(stem).install()
    for module in modules():
        try:
            importlib.import_module(module)
        except ModuleNotFoundError as error:
            raise RuntimeError(f"{module} cannot be imported: {error}") from error
    from vcmm.physics import ALL

    assert not {kind.name for kind in ALL} & set(names_of(stem))


def in_a_child(job: Callable[[], None]) -> str:
    """Run a job in a fork of this process; what it raised, "" for nothing."""
    back, out = os.pipe()
    child = os.fork()
    if child == 0:
        status = 0
        try:
            job()
        except BaseException:
            os.write(out, traceback.format_exc()[-3000:].encode())
            status = 1
        os._exit(status)
    os.close(out)
    with os.fdopen(back, encoding="utf-8") as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    return said or ("" if status == 0 else f"the process ended with {status}")


def each_without(job: Callable[[str], None]) -> dict[str, str]:
    """File of the catalogue -> what the job raised without it, "" for nothing; in forks of this process, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        return dict(zip(files(), pool.map(lambda stem: in_a_child(lambda: job(stem)), files())))


def main() -> int:
    for name in (*LIBRARIES, *apart_from_effects()):
        importlib.import_module(name)
    with TemporaryDirectory() as folder:  # the first child compiles for the others
        sys.dont_write_bytecode, sys.pycache_prefix = False, folder
        failed = {stem: said for stem, said in each_without(import_all_without).items() if said}
    for stem, said in failed.items():
        print(f"without vcmm/physics/catalogue/{stem}.py:\n{said}")
    print(
        f"{len(files())} files of vcmm/physics/catalogue/ deleted one at a time, {len(modules())} modules imported each time"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
