"""Twins of machining for `vcmm demo --twin`: run, tables, report, JSON."""

from __future__ import annotations

import importlib
import json as _json
from pathlib import Path

MODULES = {  # twin and page
    "abbe_milling": ("vcmm.papers.abbe_milling.twin", "vcmm.papers.abbe_milling.page"),
    "marin2004": ("vcmm.papers.marin2004.twin", "vcmm.papers.marin2004.page"),
    "test_piece": ("vcmm.cases.test_piece_errors", "vcmm.cases.test_piece_page"),
}
DRAWN = ("abbe_milling",)  # twins whose ranges are over drawn machines


def twin_command(name: str, folder: Path, draws: int | None, json: bool, me: str) -> int:
    """Run one twin on its embedded scenario and write report.html and demo.json. me: how the user calls vcmm."""
    from vcmm.console.common import document, output_folder, print_json, progress, say, show_table, write_text
    from vcmm.core.errors import UsageError
    from vcmm.files.cut_scenario import load_cut
    from vcmm.library import companions, path

    if draws is not None and name not in DRAWN:
        raise UsageError(f"--draws is of no use to {name}: it draws one machine; leave it out")
    output_folder(folder)
    twin, page = (importlib.import_module(module) for module in MODULES[name])
    source = path(name)
    scenario = load_cut(source)
    with progress() as report:
        result = twin.run(scenario, **({} if draws is None else {"draws": draws}), progress=report)
    files = [source, *companions(name).values()]
    content = document("vcmm.twin/1", {"twin": name, **twin.figures(result)}, files=files)
    write_text(folder / "demo.json", _json.dumps(content, indent=1, allow_nan=False))
    write_text(folder / "report.html", page.twin_page(scenario, result))
    if json:
        print_json(content)
        return 0
    for shown in page.tables(result):
        show_table(shown.title, shown.columns, shown.rows, left=shown.left, caption=shown.caption)
    say(f"wrote {folder}/report.html, demo.json")
    print(
        f"Next:\n  open {folder}/report.html\n  {me} new {name}\n  {me} cut {name}.toml --out {name}-report"
    )
    return 0
