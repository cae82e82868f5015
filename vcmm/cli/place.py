"""vcmm place: the pose that serves best."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def place_command(
    scenario: Path,
    *,
    plan: Annotated[bool, Parameter(name="--plan", show=False)] = False,
    machines: Annotated[list[Path] | None, Parameter(consume_multiple=True)] = None,
    seed: int | None = None,
    evaluations: int = 5000,
    scan: int = 4096,
    trials: int | None = None,
    draws: int = 200,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """The pose, among those that the fixture allows, with the smallest objective: gain, map, flatness, certificate.

    [placement] of the scenario says what may move and what is minimised; without it the part slides on the table, turns
    about the vertical, and U/T of all characteristics counts. `vcmm place gaska2014` runs the twin of a published study.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    machines
        Machine files to choose from; each takes the place of the scenario's machine.
    seed
        Seed of the search, the scan and the trials (default: the scenario's, else 0).
    evaluations
        Evaluations of the objective that the search may use.
    scan
        Further poses for the certificate, the median and the worst pose.
    trials
        Monte Carlo trials of the full evaluation at the present and the best pose.
    draws
        Machines consistent with the published figures (for gaska2014 only).
    json
        Print one JSON document.
    out
        Folder for report.html, place.json and placed.toml, the scenario with the new pose.
    """
    from vcmm.cli.common import about, document, output_folder, print_json, progress, sources
    from vcmm.errors import UsageError

    if plan:
        raise UsageError("--plan is not built yet; without it the points stay as they are planned")
    folder = output_folder(out) if out else None
    if str(scenario) == "gaska2014" and not scenario.exists():
        return _gaska(folder, draws, seed, json)
    if machines:
        return _choice(
            scenario,
            machines,
            {"seed": seed, "evaluations": evaluations, "scanned": scan, "trials": trials},
            json,
            folder,
        )
    from vcmm.files.scenario import load_scenario
    from vcmm.placing.job import place

    loaded = load_scenario(scenario)
    with progress() as report, about(scenario):
        found = place(
            loaded, seed=seed, evaluations=evaluations, scanned=scan, trials=trials, progress=report
        )
    content = document(
        "vcmm.place/1", place_json(found), seed=found.seed, files=sources(scenario), warnings=found.warnings
    )
    if folder:
        _write(folder, scenario, found, content)
    if json:
        print_json(content)
    else:
        show(found)
    return 0


def place_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document."""
    objective, certificate, flat = found.objective, found.certificate, found.region
    sure = found.confirmation
    return {
        "pose": pose_json(found.best.pose),
        "choice": found.label,
        "objective": {
            "kind": dict(objective.goal.mixture), "unit": objective.unit, "weights": dict(objective.goal.weights),
            "costs": dict(objective.goal.costs), "value": found.best.value, "characteristics": _spread(found, found.best),
        },
        "present": None if found.present is None else at_json(found, found.present) | {"gain": found.gain},
        "problems": [{"name": p.name, "constraint": p.constraint, "point": p.point, "amount_mm": p.amount} for p in found.problems],
        "median": at_json(found, found.median),
        "worst": at_json(found, found.worst),
        "certificate": {
            "method": certificate.method, "text": certificate.text, "scanned": certificate.scanned, "better": certificate.better,
            "hidden": certificate.hidden, "floor": certificate.floor, "spacing": certificate.spacing,
        },
        "search": {
            "evaluations": found.evaluations, "feasible_share": found.feasible_share,
            "minima": [{"value": v, "pose": pose_json(p)} for v, p in found.minima],
        },
        "confirmation": None if sure is None else {
            "seed": sure.seed, "trials": sure.trials, "present": sure.present, "best": sure.best, "gain": sure.gain,
            "u_gain": sure.u_gain, "confirmed": sure.confirmed,
        },
        "flat": {
            "within": flat.within, "share": flat.share, "box": {named(n): list(r) for n, r in flat.box.items()}, "checked": flat.checked,
            "convenient": None if flat.convenient is None else {"pose": pose_json(flat.convenient), "value": flat.convenient_value},
        },
        "why": why_json(found),
        "map": map_json(found.map),
    }  # fmt: skip


def named(freedom: str) -> str:
    """Key of a degree of freedom with its unit."""
    return f"{freedom}_rad" if freedom.startswith("turn") else f"{freedom}_mm"


def pose_json(six: Any) -> dict[str, Any]:
    """A pose; shift after turns about the fixed x, then y, then z."""
    import numpy as np

    return {
        "shift_mm": [float(v) for v in six[:3]],
        "turn_rad": [float(v) for v in six[3:]],
        "turn_deg": [float(v) for v in np.degrees(six[3:])],
    }


def at_json(found: Any, at: Any) -> dict[str, Any]:
    return {"pose": pose_json(at.pose), "value": at.value, "characteristics": _spread(found, at)}


def _spread(found: Any, at: Any) -> list[dict[str, Any]]:
    """u and U of the characteristics that count, as the search saw them."""
    from vcmm.gps.characteristics import unit

    out = []
    for i, c in enumerate(found.objective.characteristics):
        if found.objective.weights[c.name]:
            out.append(
                {"name": c.name, f"u_{unit(c)}": float(at.u[i]), f"U_{unit(c)}": float(at.expanded[i])}
            )
    return out


def why_json(found: Any) -> list[dict[str, Any]]:
    """Contributions of the influences at the present and the best pose, by the full evaluation."""
    out = []
    for k, after in enumerate(found.after.characteristics):
        before = found.before.characteristics[k] if found.before else None
        old = {b.input: b.u for b in before.budget} if before else {}
        unit = after.unit
        budget = [
            {"input": b.input, f"u_present_{unit}": old.get(b.input), f"u_best_{unit}": b.u}
            for b in after.budget
        ]
        row = {
            "name": after.name,
            f"U_present_{unit}": before.expanded if before else None,
            f"U_best_{unit}": after.expanded,
        }
        out.append(row | {"budget": budget})
    return out


def map_json(chart: Any) -> dict[str, Any]:
    """The map; null where the fixture or a constraint does not allow a pose."""
    import numpy as np

    values = [[float(v) if np.isfinite(v) else None for v in row] for row in chart.values]
    names = [named(n) for n in chart.names]
    axes = {n: [float(v) for v in a] for n, a in zip(names, (chart.x, chart.y))}
    return {"over": names, **axes, "objective": values}


def show(found: Any) -> None:
    """Poses compared, why, certificate and flatness."""
    from vcmm.cli.common import say, show_table
    from vcmm.placing.words import change, goal_text, pose_text, poses_rows, region_text, why_rows

    show_table(
        f"objective: {goal_text(found.objective.goal)}; the smaller the better",
        ["pose", "shift mm", "turn deg", "objective", "against present"], poses_rows(found), left=(0, 1, 2),
    )  # fmt: skip
    show_table(
        "why: contributions u_i, present and best pose (up to four largest changes each)",
        ["characteristic", "influence", "present", "best", "change of u²"], why_rows(found), left=(0, 1),
    )  # fmt: skip
    lines = [["certificate", found.certificate.text], ["flatness", region_text(found)]]
    if found.confirmation is not None:
        sure = found.confirmation
        lines.insert(
            0,
            [
                "gain, out of sample",
                f"{change(sure.gain, sure.present)} ± {sure.u_gain / sure.present:.2%} (standard error), {sure.trials:,} paired trials",
            ],
        )
    show_table("how sure, how flat", ["", ""], lines, left=(0, 1))
    if found.region.convenient is not None:
        print(f"convenient pose within 2 %: {pose_text(found.region.convenient)}")
    for warning in found.warnings:
        say(f"note: {warning}")


def _write(folder: Path, source: Path, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.cli.common import say, write_files
    from vcmm.files.placed import placed_text
    from vcmm.pages.place import place_page

    texts = {
        "place.json": _json.dumps(content, indent=1, allow_nan=False),
        "report.html": place_page(found),
        "placed.toml": placed_text(source, folder / "placed.toml", found.best.pose),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, place.json, placed.toml")


def _choice(
    scenario: Path, machines: list[Path], options: dict[str, Any], json: bool, folder: Path | None
) -> int:
    from vcmm.cli.machines import choose

    return choose(scenario, machines, options, json, folder)


def _gaska(folder: Path | None, draws: int, seed: int | None, json: bool) -> int:
    from vcmm.cli.gaska_placement import show_placement

    return show_placement(folder, draws, seed, json)
