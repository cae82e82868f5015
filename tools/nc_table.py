"""What `vcmm nc` does with a collection of programs, by the folder that each lies in, as Markdown for docs/nc.md.

python tools/nc_table.py FOLDER [subfolder ...]
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from vcmm.face.cli.nc_folder import programs_in, row_of
from vcmm.program.setup import Setup
from vcmm.show.tables.program import FolderRow, outcome, reason_kind

KINDS = ("read", "read with assumptions", "no motion", "refused")


def rows_of(folder: Path, wanted: list[str]) -> list[FolderRow]:
    files = [p for p in programs_in(folder) if not wanted or p.relative_to(folder).parts[0] in wanted]
    return [row_of(p, folder, None, Setup(strict=False)) for p in files]


def main(folder: Path, wanted: list[str]) -> None:
    rows = rows_of(folder, wanted)
    counted = Counter((Path(row.file).parts[0], outcome(row)) for row in rows)
    print(f"| control | programs | {' | '.join(KINDS)} |\n|---|{'---|' * (len(KINDS) + 1)}")
    for name in [*sorted({n for n, _ in counted}), "all"]:
        cells = [
            sum(v for (n, k), v in counted.items() if k == kind and name in (n, "all")) for kind in KINDS
        ]
        print(f"| {name} | {sum(cells)} | {' | '.join(map(str, cells))} |")
    reasons: dict[str, list[str]] = {}
    for row in rows:
        if row.reason:
            reasons.setdefault(reason_kind(row.reason), []).append(row.file)
    print("\n| refused | reason | for example |\n|---|---|---|")
    for reason, files in sorted(reasons.items(), key=lambda item: (-len(item[1]), item[0])):
        print(f"| {len(files)} | {reason} | {files[0]} |")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
