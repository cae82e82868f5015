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
    from vcmm.answer.placing.planfiles import plan_files, plan_json
    from vcmm.answer.placing.planning import optimise_plan
    from vcmm.core.units import quantity
    from vcmm.part.gps import characteristics as gps
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_answers, show_table
    from vcmm.show.tables.answers import plan_answers
    from vcmm.show.tables.plans import curve

    seconds = quantity(budget, "time", "budget", "5 min")
    folder = output_folder(out) if out else None
    with about(source), progress(not json) as bar:
        result = optimise_plan(scenario, seconds, criterion=criterion, seed=seed, progress=callback or bar)
    content = document("vcmm.plan/1", plan_json(scenario, result), seed=seed, files=sources(source))
    if folder:
        from vcmm.show.pages.plan import plan_page

        texts = plan_files(result.plan, scenario.qualifications)
        report = {"report.html": plan_page(scenario, result)}
        write_files(folder, {"plan.json": json_text(content), **report, **texts})
        say(f"wrote {folder}/report.html, plan.json, plan.toml and {len(texts) - 1} files of points")
    if json:
        print_json(content)
    else:
        units = {c.name: gps.unit(c) for c in scenario.part.characteristics}
        show_answers(plan_answers(result, units))
        show_table(curve(scenario, result))
    return 0
