"""vcmm place --machines: which of several machines suits the part, each with the part at its best pose."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def choose(
    scenario: Path, named: list[Path], options: dict[str, Any], json: bool, out: Path | None, *, sharing: Any
) -> int:
    """One document: that of the best machine, and the ranking. Machines that cannot take the part are named."""
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import show_answers
    from vcmm.show.tables.answers_parts import machine_answers
    from vcmm.show.tables.placement import ranking
    from vcmm.show.tables.table import records

    folder = output_folder(out) if out else None
    machines = machines_in(named)
    found = placed_on_all(scenario, machines, options, sharing, not json)
    order = sorted((m for m in found if not found[m]["refused"]), key=lambda m: found[m]["value"])
    best, table = found[order[0]], ranking(order, found)
    documented = [
        record | ({"why": found[record["machine"]]["refused"]} if record["machine"] not in order else {})
        for record in records(table.columns, table.rows)
    ]
    files = [*sources(scenario), *machines]
    content = document(
        "vcmm.place/1", best["content"] | {"machine": order[0], "machines": documented}, seed=best["seed"], files=files, warnings=best["warnings"]
    )  # fmt: skip
    if folder:
        _write(folder, scenario, Path(order[0]), best, content)
    if json:
        print_json(content)
    else:
        show_answers(machine_answers(order, found))
        _show(table, {m: one["refused"] for m, one in found.items() if one["refused"]})
    return 0


def shard_of_machines(
    scenario: Path, named: list[Path], options: dict[str, Any], sharing: Any, json: bool, out: Path | None
) -> int:
    """Every n-th machine, for `vcmm merge`."""
    from vcmm.face.job import put_shard, write_shard

    machines = machines_in(named)
    asked = {"scenario": str(scenario), "machines": [str(m) for m in named], **options}
    shared = write_shard(
        "place", asked, _read(scenario, machines), sharing.share,
        lambda: placed_on_all(scenario, machines, options, sharing, not json),
    )  # fmt: skip
    return put_shard(shared, scenario.stem, json, out)


def machines_in(named: list[Path]) -> list[Path]:
    """Machine files, each once; of a folder all that lie in it and below. Raises UsageError where a folder holds none."""
    from vcmm.core.errors import UsageError
    from vcmm.core.text import read_head

    out: list[Path] = []
    for path in named:
        if not path.is_dir():
            read_head(path)
        inside = sorted(
            p for p in path.rglob("*.toml") if p.is_file() and b"machine/" in p.read_bytes()[:100_000]
        )
        if path.is_dir() and not inside:
            raise UsageError(f'{path} holds no machine: no .toml file there says vcmm = "machine/1"')
        out += inside if path.is_dir() else [path]
    return list(dict.fromkeys(out))


def _read(scenario: Path, machines: list[Path]) -> list[Path]:
    """All files of the job, each once."""
    from vcmm.show.console.documents import sources

    return list(dict.fromkeys(f for p in (scenario, *machines) for f in sources(p)))


def placed_on_all(
    scenario: Path, machines: list[Path], options: dict[str, Any], sharing: Any, shown: bool
) -> dict[str, dict[str, Any]]:
    """Machine file -> what became of it, plain values. Raises UsageError where none can take the part, ShardDone."""
    from vcmm.core.blocks import key_of
    from vcmm.core.errors import UsageError
    from vcmm.show.console.terminal import progress

    loaded = _load_tasks(scenario, machines)
    key = key_of("place", options, _read(scenario, machines))
    with progress(shown) as bar:
        count = len(machines)
        bar(f"0 of {count} machines", 0.0)
        rows = sharing.all_of(
            key, placed_on, options, loaded, lambda s: bar(f"{round(s * count)} of {count} machines", s)
        )
    found = {str(m): row for m, row in zip(machines, rows)}
    if all(row["refused"] for row in rows):
        why = "; ".join(f"{m}: {row['refused']}" for m, row in found.items())
        raise UsageError(f"none of the machines can take the part: {why}")
    return found


def _load_tasks(scenario: Path, machines: list[Path]) -> list[Any]:
    """The task on every machine, or what is wrong with a machine file as text. Raises what the last raises where none can be read."""
    from vcmm.core.errors import VcmmError, first_of
    from vcmm.files.own.scenario import load_scenario

    out: list[Any] = []
    for number, machine in enumerate(machines, 1):
        try:
            out.append(load_scenario(scenario, machine))
        except VcmmError as error:
            out.append(first_of(error))
            if number == len(machines) and all(isinstance(one, str) for one in out):
                raise
    return out


def placed_on(options: dict[str, Any], scenario: Any) -> dict[str, Any]:
    """The part at its best pose on one machine, by any worker; `refused`: why the machine cannot take it, or its file not be read."""
    from vcmm.answer.placing.placement import place
    from vcmm.answer.placing.result import place_json
    from vcmm.answer.placing.words import amount, pose_text
    from vcmm.core.errors import ModelLimit
    from vcmm.show.pages.place import place_page

    if isinstance(scenario, str):
        return {"name": "", "refused": scenario}
    try:
        placed = place(scenario, **{k: v for k, v in options.items() if v is not None})
    except ModelLimit as error:
        return {"name": scenario.machine.name, "refused": str(error)}
    best, near = placed.best, placed.region.convenient
    return {
        "name": scenario.machine.name, "refused": "", "value": best.value, "pose": best.pose.tolist(),
        "convenient": None if near is None else near.tolist(), "words": [pose_text(best.pose), amount(best.value, placed)],
        "content": place_json(placed), "page": place_page(placed), "seed": placed.seed, "warnings": list(placed.warnings),
    }  # fmt: skip


def _write(
    folder: Path, scenario: Path, machine: Path, best: dict[str, Any], content: dict[str, Any]
) -> None:
    import numpy as np

    from vcmm.files.own.placement_writer import placed_text
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say

    near = None if best["convenient"] is None else np.array(best["convenient"])
    texts = {
        "place.json": json_text(content),
        "report.html": best["page"],
        "placed.toml": placed_text(scenario, folder / "placed.toml", np.array(best["pose"]), machine, near),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, place.json, placed.toml for {machine}")


def _show(ranking: Any, refused: dict[str, str]) -> None:
    from vcmm.show.console.terminal import say, show_table

    show_table(ranking)
    for m, why in refused.items():
        say(f"note: {m}: {why}")
