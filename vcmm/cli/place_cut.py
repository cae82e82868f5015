"""vcmm place on a cutting scenario: where on the table the part comes out best."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def placed_cut(scenario: Path, options: dict[str, Any], json: bool, folder: Path | None) -> int:
    """Place a cut part and say what was found. Exit code 0."""
    from vcmm.console.common import about, document, print_json, progress, sources
    from vcmm.files.cut_scenario import load_cut
    from vcmm.machining.placement import place_cut

    loaded = load_cut(scenario)
    with progress() as report, about(scenario, "placement"):
        found = place_cut(loaded, progress=report, **options)
    files = [*sources(scenario), loaded.program]
    content = document(
        "vcmm.place/1", _json(found), seed=found.seed, files=files, warnings=found.after.warnings
    )
    if folder:
        _write(folder, scenario, loaded, found, content)
    if json:
        print_json(content)
    else:
        show(found)
    return 0


def _json(found: Any) -> dict[str, Any]:
    from vcmm.gps.characteristics import unit
    from vcmm.placing.result import map_json, named, pose_json

    def at(one: Any) -> dict[str, Any]:
        rows = [
            {"name": c.name, f"deviation_{unit(c)}": float(d)}
            for c, d in zip(found.characteristics, one.deviations)
        ]
        return {"pose": pose_json(one.pose), "value": one.value, "characteristics": rows}

    certificate, flat = found.certificate, found.region
    return {
        "pose": pose_json(found.best.pose),
        "objective": {"kind": {"deviation": 1.0}, "weights": found.weights, **{k: at(found.best)[k] for k in ("value", "characteristics")}},
        "present": at(found.present) | {"gain": found.gain},
        "median": at(found.median),
        "worst": at(found.worst),
        "certificate": {
            "method": certificate.method, "text": certificate.text, "scanned": certificate.scanned,
            "better": certificate.better, "earlier": certificate.earlier, "hidden": certificate.hidden,
            "spacing": certificate.spacing,
        },
        "flat": {"within": flat.within, "share": flat.share, "box": {named(n): list(r) for n, r in flat.box.items()}},
        "conforming": [
            {"name": a.name, "p_present": _p(b), "p_best": _p(a)}
            for a, b in zip(found.after.characteristics, found.before.characteristics)
        ],
        "map": map_json(found.map),
    }  # fmt: skip


def _p(c: Any) -> float | None:
    return None if c.decision is None else c.decision.p_conform


def show(found: Any) -> None:
    """Poses compared, what each characteristic gains, how sure and how flat."""
    from vcmm.console.common import show_table
    from vcmm.console.quantities import deviation_text, percent_text
    from vcmm.gps.characteristics import unit
    from vcmm.placing.tables import poses, region_text

    rows = [
        [name, poses(at.pose)[0], f"{at.value:.4g}", f"{at.value / found.present.value - 1:+.1%}" if found.present.value else "–"]
        for name, at in (
            ("found", found.best), ("present", found.present), ("median of the scan", found.median),
            ("worst of the scan", found.worst),
        )
    ]  # fmt: skip
    show_table(
        "objective: weighted deviations of the cut part as shares of half their tolerance; the smaller the better",
        ["pose", "shift mm", "objective", "against present"], rows, left=(0, 1),
    )  # fmt: skip
    lines = [
        [
            c.name, deviation_text(float(before), unit(c)), deviation_text(float(after), unit(c)),
            "–" if p is None else percent_text(p), "–" if q is None else percent_text(q),
        ]
        for c, before, after, p, q in zip(
            found.characteristics, found.present.deviations, found.best.deviations,
            [_p(c) for c in found.before.characteristics], [_p(c) for c in found.after.characteristics],
        )
    ]  # fmt: skip
    show_table(
        "deviation by the known errors, and probability to conform",
        ["characteristic", "present", "found", "p present", "p found"], lines, left=(0,),
    )  # fmt: skip
    print(f"certificate: {found.certificate.text}\nflatness: {region_text(found)}")


def _write(folder: Path, source: Path, scenario: Any, found: Any, content: dict[str, Any]) -> None:
    import json as _json

    from vcmm.console.common import say, write_files
    from vcmm.files.placed_cut import placed_cut as placed_texts
    from vcmm.pages.place_cut import place_cut_page

    shift = found.best.pose[:3] - found.present.pose[:3]
    texts = {
        "place.json": _json.dumps(content, indent=1, allow_nan=False),
        "report.html": place_cut_page(scenario, found),
        **placed_texts(source, scenario, folder, found.best.pose, shift),
    }
    write_files(folder, texts)
    say(
        f"wrote {folder}/report.html, place.json, placed.toml, placed-setup.toml: part and work offsets moved by "
        f"({', '.join(f'{v:+.3f}' for v in shift)}) mm"
    )
