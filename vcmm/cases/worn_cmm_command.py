"""The twin of the diagnosis for `vcmm demo --twin worn_cmm`: run, tables, report, JSON."""

from __future__ import annotations

import json as _json
from pathlib import Path


def worn_command(folder: Path, json: bool, me: str) -> int:
    """Diagnose the embedded recording and lay the answer beside what was concealed. me: how the user calls vcmm."""
    from vcmm.cases import worn_cmm as twin
    from vcmm.cases import worn_cmm_page as page
    from vcmm.console.common import document, output_folder, print_json, progress, say, show_table, write_text
    from vcmm.files.recording import load_recording
    from vcmm.files.scenario import load_scenario
    from vcmm.library import companions, path

    output_folder(folder)
    recording, machine = load_recording(path("worn_cmm"))
    with progress() as report:
        result = twin.run(recording, machine, load_scenario(path("plate")), progress=report)
    files = [path("worn_cmm"), *companions("worn_cmm").values(), path("plate")]
    content = document("vcmm.twin/1", {"twin": "worn_cmm", **twin.figures(result)}, files=files)
    write_text(folder / "demo.json", _json.dumps(content, indent=1, allow_nan=False))
    write_text(folder / "report.html", page.twin_page(result))
    if json:
        print_json(content)
        return 0
    for shown in page.tables(result):
        show_table(shown.title, shown.columns, shown.rows, left=shown.left, caption=shown.caption)
    say(f"wrote {folder}/report.html, demo.json")
    print(
        f"Next:\n  open {folder}/report.html\n  {me} new worn_cmm\n  {me} diagnose worn_cmm.toml --out worn_cmm-report"
    )
    return 0
