"""How large the house is, as figures that can be compared from one year to the next.

python -m tests.house.counts                       the table of DESIGN.md
python -m tests.house.counts vcmm uncertainty ...  files of vcmm through which one command passes
"""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from pathlib import Path

from tests.house.test_layers import WHITEBOARD, arrows, inner_imports, sources, tree, within
from vcmm.core.effect import Effect

# Bare participles that stood as names of functions and classes: a reader must guess whether `told(...)` reports or tests.
PARTICIPLES = {
    "told",
    "drawn",
    "placed",
    "said",
    "seen",
    "held",
    "judged",
    "foretold",
    "found",
    "known",
    "given",
    "shown",
    "kept",
    "stated",
    "written",
    "read",
    "taken",
}
SHORT = 60


def public_names() -> int:
    """Functions and classes at the top of modules whose name has no underscore."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    return sum(isinstance(n, kinds) and not n.name.startswith("_") for m in sources() for n in tree(m).body)


def participles() -> int:
    """Definitions, methods included, whose whole name is one of PARTICIPLES."""
    names = [
        n.name.strip("_")
        for m in sources()
        for n in ast.walk(tree(m))
        if isinstance(n, ast.FunctionDef | ast.ClassDef)
    ]
    return sum(name in PARTICIPLES for name in names)


def lines(module: str) -> int:
    return len(sources()[module].read_text(encoding="utf-8").splitlines())


def importers() -> Counter[str]:
    """Module -> how many others import it."""
    return Counter(target for _, target in {(i.module, i.target) for i in inner_imports()})


def short_with_one_importer() -> list[str]:
    """Modules of fewer than SHORT lines that one other imports: to be merged, or to have a reason."""
    count = importers()
    return sorted(
        m for m in sources()
        if count[m] == 1 and lines(m) < SHORT and sources()[m].name != "__init__.py" and not within(m, "physics")
    )  # fmt: skip


def of_command_line() -> dict[str, Path]:
    return {m: path for m, path in sources().items() if within(m, "face.cli")}


def untyped() -> int:
    """How often the command line says `Any`, its imports included."""
    return sum(len(re.findall(r"\bAny\b", p.read_text(encoding="utf-8"))) for p in of_command_line().values())


def late_imports() -> int:
    """Import lines of the command line that stand inside a function."""
    kinds = (ast.Import, ast.ImportFrom)
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    late = {
        (m, n.lineno)
        for m in of_command_line()
        for f in ast.walk(tree(m))
        if isinstance(f, functions)
        for n in ast.walk(f)
        if isinstance(n, kinds)
    }
    return len(late)


def jobs() -> int:
    """Classes of the command line that are a `Job`."""
    return sum(
        isinstance(n, ast.ClassDef) and any("Job" in ast.unparse(b) for b in n.bases)
        for m in of_command_line()
        for n in tree(m).body
    )


def figures() -> dict[str, int]:
    """What the table holds."""
    modules = [m for m in sources() if m]
    return {
        "lines": sum(map(lines, sources())),
        "modules": len(modules),
        "rooms": len(WHITEBOARD),
        "arrows between rooms": len(arrows()),
        "public names": public_names(),
        "public members of Effect": len([n for n in dir(Effect) if not n.startswith("_")]),
        "definitions that are bare participles": participles(),
        f"modules under {SHORT} lines with one importer": len(short_with_one_importer()),
        "jobs of the command line": jobs(),
        "Any in face/cli": untyped(),
        "import lines inside functions of face/cli": late_imports(),
    }


def passed_through(words: list[str]) -> list[str]:
    """Files of vcmm, without vcmm/, of which a function is called by one command."""
    import vcmm.face.cli as cli

    seen: set[str] = set()

    def note(frame: object, event: str, _: object) -> None:
        code = getattr(frame, "f_code", None)
        if event == "call" and code is not None and code.co_name != "<module>":
            seen.add(code.co_filename)

    sys.argv = words
    sys.setprofile(note)
    try:
        cli.main()
    except SystemExit:
        pass
    finally:
        sys.setprofile(None)
    return sorted(
        m[1]
        for f in seen
        if (
            m := re.search(
                r"/vcmm/((?:core|physics|part|program|task|answer|shop|files|compensation|learn|show|face)/.*\.py)$",
                f,
            )
        )
    )


def main() -> None:
    """Print the table, or the files of a journey."""
    if len(sys.argv) > 1:
        files = passed_through(sys.argv[1:])
        print(f"\n{len(files)} files\n" + "\n".join(files))
        return
    for name, figure in figures().items():
        print(f"{figure:8d}  {name}")


if __name__ == "__main__":
    main()
