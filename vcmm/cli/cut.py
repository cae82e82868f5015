"""vcmm cut: machine the part virtually; deviations of its features, U, decision, who owns the error, cycle time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter


def cut_command(
    scenario: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    engine: Literal["auto", "montecarlo", "exact"] = "auto",
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Machine a part virtually: program, machine, tools and set-up to the deviations of its features.

    Exit code 1 when a characteristic does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) with a [cut] table.
    trials
        Monte Carlo trials (default: the scenario's, else 10^6).
    seed
        Seed of the random streams (default: the scenario's, else 0).
    json
        Print one JSON document.
    engine
        As in `vcmm uncertainty`; exact: transforms multiplied and the deepest of the candidates taken in every trial.
    out
        Folder for report.html, cut.json, surface.csv and, where the set-up states a stock, stock.stl.
    """
    from vcmm.console.common import about, document, output_folder, print_json, progress, sources
    from vcmm.files.cut_scenario import load_cut
    from vcmm.machining.job import cut

    folder = output_folder(out) if out else None
    loaded = load_cut(scenario)
    with progress() as report, about(scenario, "cut"):
        found = cut(loaded, seed=seed, trials=trials, engine=engine, progress=report)
    files = [*sources(scenario), loaded.program]
    content = document(
        "vcmm.cut/1", cut_json(found), seed=found.uncertainty.seed, files=files, warnings=found.warnings
    )
    if folder:
        _write(folder, loaded, found, content)
    if json:
        print_json(content)
    else:
        show(found)
    return (
        1 if any(c.decision and c.decision.text == "does not conform" for c in found.characteristics) else 0
    )


def cut_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document: the characteristics of `uncertainty`, and what belongs to cutting."""
    from vcmm.cli.uncertainty import characteristic_json
    from vcmm.machining.result import expected

    characteristics = []
    for c in found.characteristics:
        body = characteristic_json(c)
        body["deviation_" + c.unit] = expected(c)
        body["groups"] = dict(found.shares[c.name])
        body["u_repeats_" + c.unit] = found.repeats[c.name]
        body["u_scatters_" + c.unit] = found.scatters[c.name]
        characteristics.append(body)
    s = found.surface
    return {
        "trials": found.uncertainty.trials,
        "characteristics": characteristics,
        "surface": {
            "max_um": s.max_um, "rms_um": s.rms_um, "points": s.points, "uncut": s.uncut, "gouges": s.gouges,
            "gouge_depth_um": s.deep_um,
            "recut": None if found.recut is None else {"points": found.recut.points, "largest_um": found.recut.largest * 1e3},
        },
        "time_s": found.seconds,
        "stock": None if found.blank is None else {
            "removed_mm3": found.blank.removed,
            "kept_as": found.blank.kept_as,
            "collisions": [{"line": line, "depth_mm": depth} for line, depth in found.blank.collisions],
            "shanks": [{"line": line, "tool": tool, "depth_mm": depth} for line, tool, depth in found.blank.shanks],
        },
    }  # fmt: skip


def show(found: Any) -> None:
    """Deviations, who owns them, what a batch shares, the surface."""
    from vcmm.console.common import say, show_table
    from vcmm.console.quantities import deviation_text, length_text, percent_text, span_text
    from vcmm.machining.result import expected

    rows = [
        [
            c.name, length_text(c.nominal, c.unit), deviation_text(expected(c), c.unit), deviation_text(c.bias, c.unit),
            deviation_text(c.expanded, c.unit, signed=False), span_text([x - c.nominal for x in c.interval], c.unit),
            "–" if c.decision is None else c.decision.text,
            "–" if c.decision is None else percent_text(c.decision.p_conform),
        ]
        for c in found.characteristics
    ]  # fmt: skip
    first = found.characteristics[0]
    show_table(
        f"the finished part: expected deviation from nominal and its coverage interval for p = {first.p:.0%}",
        ["characteristic", "nominal", "deviation", "known errors", "U", "interval", "decision", "p conform"],
        rows,
        left=(0, 6),
    )
    _show_owners(found)
    s = found.surface
    minutes, seconds = divmod(found.seconds, 60)
    print(
        f"surface: largest departure {s.max_um:.2f} um, rms {s.rms_um:.2f} um over {s.points} points of the nets on all "
        f"features; of these {s.uncut} uncut, {s.gouges} gouged by the program itself (deeper than {s.deep_um:g} um)\n"
        f"{_recut_text(found.recut)}"
        f"cycle time: {minutes:.0f} min {seconds:.1f} s"
    )
    if found.blank is not None:
        print(
            f"stock ({found.blank.kept_as}): {found.blank.removed / 1e3:.1f} cm³ removed, "
            f"{len(found.blank.collisions)} rapids through material"
        )
    for warning in found.warnings:
        say(f"note: {warning}")


def _recut_text(found: Any) -> str:
    if found is None:
        return ""
    return f"cut again with the tools really displaced: {found.points} points differ from the result by {found.largest * 1e3:.3f} um at most\n"


def _show_owners(found: Any) -> None:
    """Whose uncertainty it is, the largest contributions, and what a batch shares."""
    from vcmm.console.common import show_table
    from vcmm.console.quantities import deviation_text, percent_text

    names = list(next(iter(found.shares.values())))
    shares = [
        [c.name, *[percent_text(found.shares[c.name][n]) for n in names]] for c in found.characteristics
    ]
    show_table("share of u² by owner", ["characteristic", *names], shares, left=(0,))
    budget = [
        [
            c.name if i == 0 else "",
            b.input,
            b.redraw,
            deviation_text(b.u, c.unit, signed=False),
            percent_text(b.share),
        ]
        for c in found.characteristics
        for i, b in enumerate(c.budget[:4])
    ]
    show_table(
        "largest contributions", ["characteristic", "input", "redraw", "u_i", "share"], budget, left=(0, 1, 2)
    )
    repeats = [
        [c.name, deviation_text(found.repeats[c.name], c.unit, signed=False), deviation_text(found.scatters[c.name], c.unit, signed=False)]
        for c in found.characteristics
    ]  # fmt: skip
    show_table(
        "in a batch",
        ["characteristic", "u, repeats in every part", "u, scatters from part to part"],
        repeats,
        left=(0,),
    )


def _write(folder: Path, scenario: Any, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files
    from vcmm.pages.cut import cut_page

    texts = {
        "cut.json": _json.dumps(content, indent=1, allow_nan=False),
        "surface.csv": _surface_csv(found),
        "report.html": cut_page(scenario, found),
    }
    write_files(folder, texts)
    if found.blank is not None:
        from vcmm.cutting.solid import write_stl
        from vcmm.machining.turned_blank import TurnedBlank, write_turned_stl

        if isinstance(found.blank, TurnedBlank):
            write_turned_stl(found.blank.after, folder / "stock.stl")
        else:
            write_stl(found.blank.after, folder / "stock.stl")
    say(f"wrote {folder}/report.html, cut.json, surface.csv{', stock.stl' if found.blank else ''}")


def _surface_csv(found: Any) -> str:
    """Every point of the maps: drawing frame, mm; departure in um, empty where nothing was cut."""
    rows = ["feature,x_mm,y_mm,z_mm,nx,ny,nz,deviation_um,program_alone_um"]
    for patch in found.patches:
        for point, normal, height, nominal in zip(
            patch.net.points, patch.net.normals, patch.height, patch.nominal
        ):
            numbers = [f"{v:.6f}" for v in (*point, *normal)]
            heights = ["" if h != h else f"{h * 1e3:.4f}" for h in (height, nominal)]
            rows.append(",".join([patch.net.feature, *numbers, *heights]))
    return "\n".join(rows) + "\n"
