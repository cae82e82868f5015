"""vcmm place on a cutting scenario: where on the table the part comes out best."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def placed_cut(scenario: Path, options: dict[str, Any], json: bool, folder: Path | None) -> int:
    """Place a cut part and say what was found. Exit code 0."""
    from vcmm.face.bodies import placed_cut_json
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.shop.machining.placement import place_cut
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import progress

    loaded = load_cut(scenario)
    with progress() as report, about(scenario, "placement"):
        placed = place_cut(loaded, progress=report, **options)
    files = [*sources(scenario), loaded.program]
    content = document(
        "vcmm.place/1", placed_cut_json(placed), seed=placed.seed, files=files, warnings=placed.after.warnings
    )
    if folder:
        _write(folder, scenario, loaded, placed, content)
    if json:
        print_json(content)
    else:
        show(placed)
    return 0


def show(placed: Any) -> None:
    """Poses compared, what each characteristic gains, how sure and how flat."""
    from vcmm.answer.placing.words import region_text
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables.answers import placed_cut_answers
    from vcmm.show.tables.placement import compared_cut_poses, gains

    show_answers(placed_cut_answers(placed))
    for table in (compared_cut_poses(placed), gains(placed)):
        show_table(table)
    print(f"certificate: {placed.certificate.text}\nflatness: {region_text(placed)}")


def _write(folder: Path, source: Path, scenario: Any, placed: Any, content: dict[str, Any]) -> None:
    from vcmm.files.own.placement_writer import placed_cut as placed_texts
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.place_cut import place_cut_page

    shift = placed.best.pose[:3] - placed.present.pose[:3]
    texts = {
        "place.json": json_text(content),
        "report.html": place_cut_page(scenario, placed),
        **placed_texts(source, scenario, folder, placed.best.pose, shift),
    }
    write_files(folder, texts)
    say(
        f"wrote {folder}/report.html, place.json, placed.toml, placed-setup.toml: part and work offsets moved by "
        f"({', '.join(f'{v:+.3f}' for v in shift)}) mm"
    )
