"""vcmm convert: files of other systems (STEP, QIF, DMIS, DCC) made into vcmm files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def convert_command(
    file: Path,
    *,
    machine: Path | None = None,
    out: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Make vcmm files of a file of another system: a part with plan, a machine with errors, quantities of a certificate.

    STEP (planes, cylinders, cones, spheres, tori; tolerances of AP242; needs vcmm[step]), QIF 3.0 (features, characteristics, measured points, 21 errors of a machine), DMIS (features, tolerances, touches), DCC
    (quantities), values and points that PC-DMIS or CALYPSO exported. What the file does not say is assumed and said; what vcmm has no word for is left out and said.

    Parameters
    ----------
    file
        The file: .step, .stp, .qif, .dmi, .dmis, .xml (DCC), .txt, .asc, .xyz (exports).
    machine
        Machine file (machine/1) of the scenario; without it a machine with a certificate stands in.
    out
        Folder for the files (default: the name of the file without its ending).
    json
        Print one JSON document.
    """
    from vcmm.face.converting import written_files
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import say

    made, read, written = written_files(file, machine, out)
    files = [str(path) for path in written]
    if json:
        body = {
            "kind": made.kind,
            "counts": made.counts,
            "written": files,
            "notes": list(made.notes),
            "problems": read,
        }
        print_json(document("vcmm.convert/1", body, files=[file], warnings=[*made.notes, *read]))
        return 0
    for note in (*made.notes, *read):
        say(f"note: {note}")
    print(f"{made.kind}: " + ", ".join(f"{n} {what}" for what, n in made.counts.items()))
    print(
        f"wrote {', '.join(files)}"
        + (f"\nnext: vcmm check {written[0].parent / made.check}" if made.check else "")
    )
    return 0
