"""vcmm rerun: an evidence pack run again, and whether the numbers are the same."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

JOBS = (["evaluate"], ["uncertainty"], ["routes"])
OPTIONS = (
    "--points", "--values", "--frame", "--tip-centres", "--trials", "--seed", "--engine", "--digits", "--calibrated",
    "--repeats", "--positions", "--standards",
)  # fmt: skip


def rerun_command(pack: Path, *, json: Annotated[bool, Parameter(name="--json")] = False) -> int:
    """Run an evidence pack again (--evidence of evaluate, uncertainty, routes) and compare every number.

    Exit code 1 when a number is not the same.

    Parameters
    ----------
    pack
        The zip that --evidence wrote.
    json
        Print one JSON document.
    """
    from tempfile import TemporaryDirectory

    from vcmm import __version__
    from vcmm.console.documents import document, print_json
    from vcmm.console.evidence import ALIKE, differences, unpacked

    with TemporaryDirectory() as folder:
        said = unpacked(pack, Path(folder))
        found = _run_again(said, Path(folder))
    changed = list(differences(said["document"], found))
    largest = max((c.relative for c in changed), default=0.0)
    same = largest <= ALIKE
    body = {
        "command": said["command"], "same": same, "identical": not changed, "largest_relative_difference": largest,
        "version_then": said["version"], "libraries_then": said["libraries"],
        "differences": [{"key": c.key, "was": c.was, "found": c.found} for c in changed[:100]],
    }  # fmt: skip
    if json:
        print_json(document("vcmm.rerun/1", body, seed=said.get("seed"), files=[pack]))
    else:
        _show(said, body, __version__)
    return int(not same)


def _run_again(said: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The document of the command of a pack, run on its files in `folder`. DataError: it does not run."""
    import contextlib
    import io
    import json

    from vcmm.cli import run
    from vcmm.core.errors import DataError

    files = {one["file"] for one in said["files"]}
    words = [str(folder / w) if w in files else w for w in said["command"]]
    strange = [w for w in said["command"] if w.startswith("-") and w not in OPTIONS]
    if words[:1] not in JOBS or strange:
        raise DataError(
            f"the command of the pack is no job that --evidence writes ({' '.join(said['command'])}); nothing was run"
        )
    caught = io.StringIO()
    with contextlib.redirect_stdout(caught):
        code = run([*words, "--json"])
    if code not in (0, 1):
        raise DataError(
            f"the command of the pack ended with exit code {code}: vcmm {' '.join(said['command'])}"
        )
    found = json.loads(caught.getvalue())
    assert isinstance(found, dict)
    return found


def _show(said: dict[str, Any], body: dict[str, Any], version: str) -> None:
    print(f"vcmm {' '.join(body['command'])}")
    print(
        f"made with vcmm {body['version_then']}, run again with {version}; {len(said['files'])} files, all unchanged"
    )
    if body["identical"]:
        print("every number is the same, to the last bit")
    elif body["same"]:
        print(f"every number is the same within {body['largest_relative_difference']:.1e}")
    else:
        print("the numbers are not the same:")
        for one in body["differences"][:10]:
            print(f"  {one['key']}: {one['was']} then, {one['found']} now")
    covered = [i["influence"] for i in said["influences"] if i["status"] != "not covered"]
    print(f"influences covered: {', '.join(covered)}")
