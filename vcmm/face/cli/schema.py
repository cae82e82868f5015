"""vcmm schema: JSON Schema of the file formats, for editors and other programs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

from vcmm.files.own.schemas import json_schema
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say


def schema_command(
    kind: Literal[
        "machine", "scenario", "part", "plan", "recording", "setup", "design", "checks", "scan", "track"
    ] = "scenario",
    *,
    out: Path | None = None,
) -> int:
    """Print the JSON Schema of a file format, or of the document that vcmm track writes.

    Parameters
    ----------
    kind
        Which file format; track: the document vcmm.track/1 (track.json).
    out
        Folder for <kind>.schema.json instead of stdout.
    """
    text = json.dumps(json_schema(kind), indent=1)
    if out:
        path = write_text(output_folder(out) / f"{kind}.schema.json", text + "\n")
        say(f"wrote {path}")
    else:
        print(text)
    return 0
