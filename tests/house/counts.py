"""How large the house is, as figures that can be compared from one year to the next.

python -m tests.house.counts                       the figures of DESIGN.md, exact
python -m tests.house.counts --table               the rows "Size" of DESIGN.md
python -m tests.house.counts --journeys            the rows "Journeys" of DESIGN.md
python -m tests.house.counts vcmm uncertainty ...  files of vcmm through which one command passes
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from tests.house.test_layers import PACKAGE, WHITEBOARD, arrows, inner_imports, sources, tree, within
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
    "learn.diagnosis.result": (
        ("fitted", "found"),
        "`Diagnosis.found` and `Answer.fitted`, which docs/diagnose.md and the notebooks take of what `vcmm.diagnose` returns",
    ),
    "files.own.track_document": (
        ("added", "changed", "foretold", "kept", "passed", "said"),
        "keys of the JSON document vcmm.track/1",
    ),
    "program.moves": (("assumed", "unused"), "what the program of `vcmm.nc` offers, and keys of `nc --json`"),
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
BARE = frozenset(  # as the whole name of a constant: most of what, near to what, and in which unit?
    """most least far near close same still small large tiny nothing enough room long short few many wide narrow flat fine coarse rough
    smooth deep plain free along around across beside beyond above below ahead behind down apart before after later largest smallest
    longest shortest fewest deepest widest finest steepest lowest highest""".upper().split()
)
KEPT_FIELDS = {  # module, or room -> field of a class that stays though its name is in UNCLEAR, and why
    "core.declaration": (
        "seen",
        "`Words(seen=...)` of the declaration of an effect, offered to effects of users",
    ),
    "core.effect": ("own", "declared by effects of users"),
    "physics": ("own", "declared by effects, as those of users declare it"),
    "task.response.recording": ("known", "field of `vcmm.Recording`"),
    "answer.inference.audit": ("own", "key of tools/audit_counts.json"),
}
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
        kept = kept_fields(module)
        for node in ast.walk(tree(module)):
            is_stored = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id in UNCLEAR
            if (is_stored and node not in kept) or (isinstance(node, ast.arg) and node.arg in UNCLEAR):
                out[module.split(".")[0]] += 1
    return dict(out)


def bare_constants() -> dict[str, list[str]]:
    """Room -> "NAME at module:line" of every constant at the top of a module whose whole name is one of BARE."""
    out: dict[str, list[str]] = {}
    for module in sources():
        for node in tree(module).body:
            targets = (
                node.targets
                if isinstance(node, ast.Assign)
                else [node.target]
                if isinstance(node, ast.AnnAssign)
                else []
            )
            for name in (n for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)):
                if name.id.strip("_") in BARE:
                    out.setdefault(module.split(".")[0], []).append(f"{name.id} at {module}:{node.lineno}")
    return out


def kept_fields(module: str) -> list[ast.expr]:
    """Names of fields of classes in this module that KEPT_FIELDS lists."""
    names = [KEPT_FIELDS[where][0] for where in (module, module.split(".")[0]) if where in KEPT_FIELDS]
    statements = [n for c in ast.walk(tree(module)) if isinstance(c, ast.ClassDef) for n in c.body]
    targets = [
        t
        for n in statements
        if isinstance(n, ast.AnnAssign | ast.Assign)
        for t in (n.targets if isinstance(n, ast.Assign) else [n.target])
    ]
    return [t for t in targets if isinstance(t, ast.Name) and t.id in names]


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


ROWS = (  # row of DESIGN.md, figure of `figures`, before the twelve rooms, rounded to
    ("rooms", "rooms", 35, 1),
    ("arrows between rooms, all of them on the whiteboard of `tests/house/test_layers.py`", "arrows between rooms", 247, 1),
    ("public members of an effect: nine to declare, `where` and `id` follow", "public members of Effect", 51, 1),
    (
        "definitions whose whole name is a past participle that is no term (`TERMS` of `tests/house/counts.py`)",
        "definitions that are bare participles",
        985,
        1,
    ),
    (
        "variables and parameters named " + ", ".join(f"`{name}`" for name in sorted(UNCLEAR)),
        "variables of unclear names",
        2063,
        1,
    ),
    ("modules", "modules", 823, 10),
    ("lines", "lines", 121854, 1000),
    ("public names at the top of modules", "public names", 3419, 100),
    (f"modules under {SHORT} lines with one importer", f"modules under {SHORT} lines with one importer", 39, 1),
    ("`Any` in the command line", "Any in face/cli", 341, 10),
    ("import lines inside functions of the command line", "import lines inside functions of face/cli", 688, 10),
    ("jobs of the command line, declared as `Job`", "jobs of the command line", 0, 1),
)  # fmt: skip
JOURNEYS = (  # what goes through the house, and the command in scenarios/, after `measure plate.toml --seed 3 --out measured`
    ("an error of the machine to the budget", "uncertainty ring_gauge.toml"),
    ("a measured point to the decision", "evaluate plate.toml --points measured/points.csv"),
    ("a line of a program to its deviation", "compensate pallet_block.toml"),
    ("a row of a recording to a name", "diagnose ballbar.toml"),
    ("a seed to a trial", "measure plate.toml --seed 3"),
)


def thousands(n: int) -> str:
    return f"{n:,}".replace(",", " ")


def table() -> list[str]:
    """Return the rows "Size" of DESIGN.md; what changes with every addition is rounded."""
    now = figures()
    return [
        f"| {label} | {thousands(before)} | {thousands(step * round(now[key] / step))} |"
        for label, key, before, step in ROWS
    ]


def journey(command: str) -> Counter[str]:
    """Return room -> files whose code runs in a command, which runs in a process of its own, in a copy of the scenarios."""
    with tempfile.TemporaryDirectory() as folder:
        scenarios = Path(folder) / "scenarios"
        shutil.copytree(PACKAGE.parent / "scenarios", scenarios)
        prepare = [sys.executable, "-m", "vcmm", "measure", "plate.toml", "--seed", "3", "--out", "measured"]
        follow = [sys.executable, "-m", "tests.house.counts", "vcmm", *command.split()]
        environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
        if "measured/" in command:
            subprocess.run(prepare, cwd=scenarios, env=environment, capture_output=True, check=True)
        done = subprocess.run(
            follow, cwd=scenarios, env=environment, capture_output=True, text=True, check=True
        )
    files = re.split(r"\n\d+ files\n", done.stdout)[-1].split()
    return Counter(name.split("/")[0] for name in files)


def journeys() -> list[str]:
    """Return the rows "Journeys" of DESIGN.md."""
    rows = []
    for label, command in JOURNEYS:
        count = journey(command)
        by_room = ", ".join(f"{r} {count[r]}" for r in WHITEBOARD if count[r])
        rows.append(f"| {label} | `{command}` | {sum(count.values())} | {by_room} |")
    return rows


def main() -> None:
    """Print the figures, a table, or the files of a journey."""
    if sys.argv[1:] in (["--table"], ["--journeys"]):
        print("\n".join(table() if sys.argv[1] == "--table" else journeys()))
        return
    if len(sys.argv) > 1:
        files = passed_through(sys.argv[1:])
        print(f"\n{len(files)} files\n" + "\n".join(files))
        return
    for name, figure in figures().items():
        print(f"{figure:8d}  {name}")


if __name__ == "__main__":
    main()
