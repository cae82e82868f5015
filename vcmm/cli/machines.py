"""vcmm place --machines: which of several machines suits the part, each with the part at its best pose."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def choose(
    scenario: Path, machines: list[Path], options: dict[str, Any], json: bool, folder: Path | None
) -> int:
    """One document: that of the best machine, and the ranking. Machines that cannot take the part are named."""
    from vcmm.console.common import document, print_json, progress, sources
    from vcmm.files.scenario import load_scenario
    from vcmm.placing.placement import choose_machine
    from vcmm.placing.result import place_json

    loaded = {str(p): load_scenario(scenario, p) for p in machines}
    with progress() as report:
        chosen = choose_machine(
            loaded, progress=report, **{k: v for k, v in options.items() if v is not None}
        )
    best = chosen.placed[chosen.order[0]]
    ranking = [
        {"machine": m, "name": loaded[m].machine.name, "value": chosen.placed[m].best.value}
        for m in chosen.order
    ] + [
        {"machine": m, "name": loaded[m].machine.name, "value": None, "why": why}
        for m, why in chosen.refused.items()
    ]
    files = [*sources(scenario), *machines]
    content = document(
        "vcmm.place/1", place_json(best) | {"machine": chosen.order[0], "machines": ranking}, seed=best.seed, files=files, warnings=best.warnings
    )  # fmt: skip
    if folder:
        _write(folder, scenario, chosen, content)
    if json:
        print_json(content)
    else:
        _show(loaded, chosen)
    return 0


def _write(folder: Path, scenario: Path, chosen: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files
    from vcmm.files.placed import placed_text
    from vcmm.pages.place import place_page

    best = chosen.placed[chosen.order[0]]
    texts = {
        "place.json": _json.dumps(content, indent=1, allow_nan=False),
        "report.html": place_page(best),
        "placed.toml": placed_text(
            scenario, folder / "placed.toml", best.best.pose, Path(chosen.order[0]), best.region.convenient
        ),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, place.json, placed.toml for {chosen.order[0]}")


def _show(loaded: Any, chosen: Any) -> None:
    from vcmm.console.common import say, show_table
    from vcmm.placing.tables import amount, pose_text

    first = chosen.placed[chosen.order[0]].best.value
    rows = [
        [
            loaded[m].machine.name,
            m,
            pose_text(f.best.pose),
            amount(f.best.value, f),
            f"{f.best.value / first - 1:+.1%}",
        ]
        for m, f in ((m, chosen.placed[m]) for m in chosen.order)
    ]
    rows += [[loaded[m].machine.name, m, "cannot take the part", "–", "–"] for m in chosen.refused]
    show_table(
        "machines, the part at the best pose found on each", ["machine", "file", "pose", "objective", "against the first"], rows, left=(0, 1, 2)
    )  # fmt: skip
    for m, why in chosen.refused.items():
        say(f"note: {m}: {why}")
