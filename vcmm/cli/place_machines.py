"""vcmm place --machines: which of several machines suits the part, each with the part at its best pose."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def choose(
    scenario: Path, machines: list[Path], options: dict[str, Any], json: bool, folder: Path | None
) -> int:
    """One document: that of the best machine, and the ranking. Machines that cannot take the part are named."""
    from vcmm.console.documents import document, print_json, sources
    from vcmm.console.terminal import progress
    from vcmm.files.scenario import load_scenario
    from vcmm.placing.placement import choose_machine
    from vcmm.placing.result import place_json
    from vcmm.tables.placed import ranking
    from vcmm.tables.table import records

    loaded = {str(p): load_scenario(scenario, p) for p in machines}
    with progress() as report:
        chosen = choose_machine(
            loaded, progress=report, **{k: v for k, v in options.items() if v is not None}
        )
    best = chosen.placed[chosen.order[0]]
    table = ranking(loaded, chosen)
    documented = [
        record | ({"why": chosen.refused[record["machine"]]} if record["machine"] in chosen.refused else {})
        for record in records(table.columns, table.rows)
    ]
    files = [*sources(scenario), *machines]
    content = document(
        "vcmm.place/1", place_json(best) | {"machine": chosen.order[0], "machines": documented}, seed=best.seed, files=files, warnings=best.warnings
    )  # fmt: skip
    if folder:
        _write(folder, scenario, chosen, content)
    if json:
        print_json(content)
    else:
        _show(table, chosen)
    return 0


def _write(folder: Path, scenario: Path, chosen: Any, content: dict[str, Any]) -> None:
    from vcmm.console.documents import json_text
    from vcmm.console.files import write_files
    from vcmm.console.terminal import say
    from vcmm.files.placed import placed_text
    from vcmm.pages.place import place_page

    best = chosen.placed[chosen.order[0]]
    texts = {
        "place.json": json_text(content),
        "report.html": place_page(best),
        "placed.toml": placed_text(
            scenario, folder / "placed.toml", best.best.pose, Path(chosen.order[0]), best.region.convenient
        ),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, place.json, placed.toml for {chosen.order[0]}")


def _show(ranking: Any, chosen: Any) -> None:
    from vcmm.console.terminal import say, show_table

    show_table(ranking)
    for m, why in chosen.refused.items():
        say(f"note: {m}: {why}")
