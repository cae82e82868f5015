"""Numbers written into vcmm/learn/diagnosis: which decide an answer, and which merely stand there.

    python tools/count_numbers.py            # how many, by file
    python tools/count_numbers.py --places   # every one with its place
    python tools/count_numbers.py --kinds    # what those outside the table are for, by file, in Markdown
    python tools/count_numbers.py --table    # the table of vcmm/learn/diagnosis/constants.py as it stands in docs/diagnose.md

Counted are numeric literals other than 0, 1, -1, 2, 0.5, conversions of units (1e3, 1e6, 60, 3600, 100 per cent), numbers of array
columns, and digits in texts. tests/house/test_numbers.py holds both counts to a ceiling.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOM = Path(__file__).resolve().parent.parent / "vcmm" / "learn" / "diagnosis"
TABLE = "constants.py"
PLAIN = (0, 1, 2, 0.5)
UNITS = (1e3, 1e6, 60, 3600, 100)


KINDS = {  # what the numbers of a file are for
    "which recording can be read, and in which unit": "sanity machine_match units_and_signs result",
    "which shapes are tried: periods that rows can show, polynomials, bumps, lengths, wrong units": (
        "periods scans neighbourhoods kernels locate discrepancy field unknown_shapes candidates mistakes log_mistakes improve"
    ),
    "how finely scanned values are searched": "refine sharpen select evidence table_renewal",
    "how many recordings are simulated, and of how many rows": (
        "engine estimates comparison accepted_terms noise search thinning null_recordings problem statement_tests several"
    ),
    "which measurements are proposed, and how long they take": "next_measurement addons job",
}


@dataclass(frozen=True)
class Number:
    """One literal: file, line, value, the line itself."""

    file: str
    line: int
    value: float
    text: str


def numbers(room: Path = ROOM) -> Iterator[Number]:
    """All counted literals of a room, file by file."""
    for path in sorted(room.glob("*.py")):
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for node in _outside_columns(ast.parse(text)):
            value = getattr(node, "value", None)
            if isinstance(value, (int, float)) and not isinstance(value, bool) and value not in PLAIN + UNITS:
                line = node.lineno  # type: ignore[attr-defined]
                yield Number(path.name, line, float(value), lines[line - 1].strip())


def _outside_columns(node: ast.AST) -> Iterator[ast.AST]:
    """The constants below a node, but those that number the columns of an array."""
    for child in ast.iter_child_nodes(node):
        if isinstance(node, ast.Subscript) and child is node.slice and _only_numbers(child):
            continue
        if isinstance(child, ast.Constant):
            yield child
        elif not isinstance(child, ast.JoinedStr):
            yield from _outside_columns(child)


def _only_numbers(index: ast.AST) -> bool:
    """Is an index made of nothing but numbers and colons?"""
    kinds = (ast.Slice, ast.Tuple, ast.Constant, ast.UnaryOp, ast.USub, ast.Load)
    return all(isinstance(n, kinds) for n in ast.walk(index))


@dataclass(frozen=True)
class Row:
    """One constant of the table: name, value, reason."""

    name: str
    value: float
    reason: str


def table() -> list[Row]:
    """The table of constants with the reasons that stand beside them."""
    text = (ROOM / TABLE).read_text(encoding="utf-8")
    values: dict[str, object] = {}
    exec(compile(text, TABLE, "exec"), values)
    lines = text.splitlines()
    out = []
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            name, reason = node.targets[0].id, lines[node.lineno - 1].partition("# ")[2]
            out.append(Row(name, float(values[name]), reason))  # type: ignore[arg-type]
    return out


def markdown() -> str:
    rows = [f"| `{r.name}` | {r.value:.4g} | {r.reason} |" for r in table()]
    return "\n".join(["| constant | value | what it decides, and why so much |", "|---|---|---|", *rows])


def kinds(found: Sequence[Number]) -> dict[str, int]:
    """How many numbers outside the table are of each kind. Raises KeyError for a file that has none."""
    of_file = {f"{f}.py": kind for kind, files in KINDS.items() for f in files.split()}
    count = Counter(of_file[n.file] for n in found if n.file != TABLE)
    return {kind: count[kind] for kind in KINDS}


def kinds_markdown(found: Sequence[Number]) -> str:
    rows = [f"| {kind} | {count} | {KINDS[kind]} |" for kind, count in kinds(found).items()]
    return "\n".join(["| what for | numbers | modules |", "|---|---|---|", *rows])


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--places", action="store_true", help="every number with its place")
    parser.add_argument("--table", action="store_true", help="the table of constants in Markdown")
    parser.add_argument("--kinds", action="store_true", help="what the others are for, in Markdown")
    args = parser.parse_args()
    if args.table:
        print(markdown())
        return 0
    found = list(numbers())
    if args.kinds:
        print(kinds_markdown(found))
        return 0
    if args.places:
        for n in found:
            print(f"{n.file}:{n.line}  {n.value:g}  {n.text[:100]}")
    files = Counter(n.file for n in found)
    for file, count in files.most_common():
        print(f"{count:4d}  {file}")
    print(f"{files[TABLE]} decide, in {TABLE}; {len(found) - files[TABLE]} elsewhere")
    return 0


if __name__ == "__main__":
    sys.exit(main())
