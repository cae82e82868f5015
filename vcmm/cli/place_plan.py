"""vcmm place --plan: points, styli and order under a time budget; the place verb calls `run_plan_option`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any


def run_plan_option(
    scenario: Any,
    source: Path,
    *,
    budget: str,
    criterion: str = "U",
    seed: int = 0,
    json: bool = False,
    out: Path | None = None,
    callback: Callable[[str, float], None] | None = None,
) -> int:
    """Optimise the plan of a loaded scenario at its pose, show the curve, write plan.toml with its points.

    budget: a time with its unit, "5 min". source: the scenario file, for the record of inputs. Exit code 0.
    """
    from vcmm.console.common import (
        about,
        document,
        output_folder,
        print_json,
        progress,
        say,
        sources,
        write_files,
    )
    from vcmm.core.units import quantity
    from vcmm.placing.planfiles import plan_files, plan_json
    from vcmm.placing.planning import optimise_plan

    seconds = quantity(budget, "time", "budget", "5 min")
    folder = output_folder(out) if out else None
    with about(source), progress(not json) as bar:
        found = optimise_plan(scenario, seconds, criterion=criterion, seed=seed, progress=callback or bar)
    content = document("vcmm.measuring.plan/1", plan_json(scenario, found), seed=seed, files=sources(source))
    if folder:
        import json as _json

        from vcmm.pages.plan import plan_page

        texts = plan_files(found.plan, scenario.qualifications)
        report = {"report.html": plan_page(scenario, found)}
        write_files(folder, {"plan.json": _json.dumps(content, indent=1, allow_nan=False), **report, **texts})
        say(f"wrote {folder}/report.html, plan.json, plan.toml and {len(texts) - 1} files of points")
    if json:
        print_json(content)
    else:
        show(scenario, found)
    return 0


def show(scenario: Any, found: Any) -> None:
    """The curve as a table: the present plan, then time, touches, U of every characteristic; the chosen one is marked."""
    from vcmm.console.common import show_table
    from vcmm.console.quantities import deviation_text
    from vcmm.gps import characteristics as gps

    units = {c.name: gps.unit(c) for c in scenario.part.characteristics}
    names = list(found.chosen.u)
    rows = [
        [
            "present" if p is found.present else "chosen" if p is found.chosen else "",
            f"{p.minutes:.2f}",
            ", ".join(f"{f} {n}" for f, n in p.per_feature.items()),
            *(deviation_text(p.expanded[n], units[n]).lstrip("+") for n in names),
        ]
        for p in (found.present, *found.pareto)
    ]
    show_table(
        "U against measuring time, form of the part included",
        ["", "minutes", "points", *(f"U {n}" for n in names)],
        rows,
        left=(0, 2),
        caption=f"styli: {', '.join(f'{f} {s}' for f, s in found.styli.items())}",
    )
