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

# Past participles that do not end in -ed; as the whole of a name a reader must guess whether `told(...)` reports or tests.
IRREGULAR = frozenset(
    [
        "told",
        "drawn",
        "found",
        "said",
        "seen",
        "held",
        "known",
        "given",
        "shown",
        "kept",
        "written",
        "taken",
        "left",
        "met",
        "made",
        "stated",
        "foretold",
        "built",
        "sent",
        "bent",
        "cut",
        "lost",
        "won",
        "sought",
        "caught",
        "brought",
        "bought",
        "thought",
        "understood",
        "spent",
        "meant",
        "felt",
        "dealt",
        "laid",
        "paid",
        "struck",
        "swept",
        "torn",
        "worn",
        "gone",
        "done",
        "begun",
        "borne",
        "broken",
        "chosen",
        "driven",
        "fallen",
        "frozen",
        "grown",
        "hidden",
        "ridden",
        "risen",
        "spoken",
        "thrown",
        "withdrawn",
        "undone",
        "sunk",
        "become",
        "got",
        "lent",
        "learnt",
        "sold",
        "slid",
    ]
)
NO_PARTICIPLE = frozenset(
    ["speed", "feed", "seed", "bed", "need", "red", "embed", "cut"]
)  # nouns and verbs of that form
TERMS = {  # participles that are the adjective of a term, or a key of files and of `import vcmm`: they stay
    "expanded": "expanded uncertainty (GUM)",
    "indicated": "indicated value (VIM)",
    "measured": "measured value (VIM), and a key of files",
    "corrected": "corrected value (VIM), and a parameter of effects",
    "calibrated": "calibrated value (VIM)",
    "compensated": "a key of files",
    "projected": "projected tolerance zone (ISO 1101), a key of files",
    "filtered": "filtered profile (ISO 16610)",
    "simulated": "of values that were drawn and not read",
    "stated": "as a result states U and k; offered by `import vcmm`",
    "observed": "a key of recordings",
    "known": "a key of recordings, and of their table",
    "trained": "a parameter of effects",
    "learned": "a parameter of effects",
    "tracked": "a key of machine files",
    "driven": "a key of set-up files",
    "seen": "`Words(seen=...)` of the declaration of an effect",
    "signed": "`Words(signed=...)` of the declaration of an effect",
    "fixed": "a column with so many decimals, offered by `vcmm.tables`",
    "required": "which columns an effect needs, offered to effects of users",
    "closed": "closed form, closed curve",
    "dashed": "of a line of a chart",
}
KEPT = {  # module -> names that stay though they are bare participles, and why
    "answer.inference.audit": (("attained", "claimed"), "keys of the rows that workers and shards hand back"),
    "answer.inference.audit_by_points": (("claimed",), "key of the rows that workers and shards hand back"),
    "files.own.track_document": (
        ("added", "changed", "foretold", "kept", "passed", "said"),
        "keys of the JSON document vcmm.track/1",
    ),
    "learn.calibration.result": (
        ("identified",),
        "field of what `vcmm.calibrate` returns, in docs/calibrate.md",
    ),
    "learn.tracking.next_check": (("kept",), "field of what `vcmm.track` returns, in a notebook"),
    "files.learned.track_result": (
        ("dated", "followed"),
        "what `vcmm.track` offers, named as in vcmm.learn.tracking",
    ),
}
UNCLEAR = frozenset(
    ["found", "one", "known", "own", "said", "told", "seen", "held", "asked"]
)  # names of variables
SHORT = 60


def public_names() -> int:
    """Functions and classes at the top of modules whose name has no underscore."""
    kinds = (ast.FunctionDef, ast.ClassDef)
    return sum(isinstance(n, kinds) and not n.name.startswith("_") for m in sources() for n in tree(m).body)


def is_participle(name: str) -> bool:
    """Whether the whole name is a past participle that is no term."""
    word = name.strip("_")
    ends = word.islower() and "_" not in word and (word.endswith("ed") or word in IRREGULAR)
    return ends and word not in NO_PARTICIPLE and word not in TERMS


def defined_names(module: str) -> list[tuple[str, int]]:
    """(name, line) of functions, methods, properties, classes and fields of classes, inner ones included; of the module itself at 0."""
    out = [(module.rsplit(".")[-1], 0)]
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            out.append((node.name, node.lineno))
        if isinstance(node, ast.ClassDef):
            fields = (n for n in node.body if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name))
            out += [(n.target.id, n.lineno) for n in fields if isinstance(n.target, ast.Name)]
    return out


def participles() -> dict[str, list[str]]:
    """Room -> "name at module:line" of every definition that is a bare participle."""
    out: dict[str, list[str]] = {}
    for module in sources():
        for name, line in defined_names(module):
            if is_participle(name) and name not in KEPT.get(module, ((), ""))[0]:
                out.setdefault(module.split(".")[0], []).append(f"{name} at {module}:{line}")
    return out


def unclear_variables() -> dict[str, int]:
    """Room -> how often a variable or a parameter is named by one of UNCLEAR."""
    out: Counter[str] = Counter()
    for module in sources():
        for node in ast.walk(tree(module)):
            is_stored = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in UNCLEAR
            if is_stored or (isinstance(node, ast.arg) and node.arg in UNCLEAR):
                out[module.split(".")[0]] += 1
    return dict(out)


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
        "definitions that are bare participles": sum(map(len, participles().values())),
        "variables of unclear names": sum(unclear_variables().values()),
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
