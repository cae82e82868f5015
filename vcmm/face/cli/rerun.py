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


MOST_SHOWN = 300  # characters of a command in a message
MOST_TRIALS = 10_000_000_000  # some minutes of two cores (docs/scale.md): what is run without being asked for


def rerun_command(
    pack: Path,
    *,
    most_trials: int = MOST_TRIALS,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Run an evidence pack again (--evidence of evaluate, uncertainty, routes) and compare every number.

    Exit code 1 when a number is not the same.

    Parameters
    ----------
    pack
        The zip that --evidence wrote.
    most_trials
        A pack that asks for more Monte Carlo trials is refused before anything is run.
    json
        Print one JSON document.
    """
    from tempfile import TemporaryDirectory

    from vcmm import __version__
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.evidence import TOLERANCE, differences, unpack_evidence

    with TemporaryDirectory() as folder:
        said = unpack_evidence(pack, Path(folder))
        found = _run_again(said, Path(folder), most_trials)
    changed = list(differences(said["document"], found))
    largest = max((c.relative for c in changed), default=0.0)
    same = largest <= TOLERANCE
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


def _run_again(said: dict[str, Any], folder: Path, most_trials: int) -> dict[str, Any]:
    """The document of the command of a pack, run on its files in `folder`, and on no others. DataError: it does not run."""
    import contextlib
    import io
    import json

    from vcmm.core.confinement import confine
    from vcmm.core.errors import DataError
    from vcmm.face.cli import run

    files = {one["file"] for one in said["files"]}
    words = [str(folder / w) if w in files else w for w in said["command"]]
    if words[:1] in JOBS and words[1:2] and not words[1].startswith("-") and said["command"][1] not in files:
        raise DataError("the command of the pack names a scenario outside the given files; nothing was run")
    if not _is_written_here(said["command"], files):
        raise DataError(
            f"the command of the pack is no job that --evidence writes ({_shown(said)}); nothing was run"
        )
    caught = io.StringIO()
    with confine(folder):
        _check_cost(words, most_trials)
        with contextlib.redirect_stdout(caught):
            code = run([*words, "--json"])
    if code not in (0, 1):
        raise DataError(f"the command of the pack ended with exit code {code}: vcmm {_shown(said)}")
    found = json.loads(caught.getvalue())
    assert isinstance(found, dict)
    return found


def _is_written_here(command: list[str], files: set[str]) -> bool:
    """Whether --evidence writes such a command: job, scenario of the pack, then options, each once and none beside them."""
    options = [w for w in command if w.startswith("-")]
    return (
        command[:1] in JOBS
        and command[1:2] != []
        and command[1] in files
        and set(options) <= set(OPTIONS)
        and len(options) == len(set(options))
        and not any(w in files and not command[i].startswith("-") for i, w in enumerate(command[2:], 1))
    )


def _shown(said: dict[str, Any]) -> str:
    """The command of a pack for a message: short."""
    from vcmm.core.text import brief

    return brief(" ".join(said["command"]), MOST_SHOWN)


def _check_cost(words: list[str], most: int) -> None:
    """Say on stderr how many trials a command asks for. DataError: more than `most`, or no number."""
    import sys

    from vcmm.core.errors import DataError, VcmmError
    from vcmm.core.text import brief
    from vcmm.files.own.scenario import load_scenario

    try:
        if "--trials" in words[:-1]:
            trials = int(brief(words[words.index("--trials") + 1]))
        else:
            trials = load_scenario(words[1]).settings.trials
    except (ValueError, IndexError):
        raise DataError("the command of the pack states no number of trials; nothing was run") from None
    except VcmmError:
        return  # the command itself says what is wrong with its files
    if trials > most:
        raise DataError(
            f"the pack asks for {trials:,} trials, and {most:,} are run unless you ask for more with --most-trials; nothing was run"
        )
    print(f"running {' '.join(words[:1])} again: {trials:,} trials at most", file=sys.stderr)


def _show(said: dict[str, Any], body: dict[str, Any], version: str) -> None:
    """What the pack says of itself is somebody else's text: control characters are spelled out."""
    from vcmm.core.text import brief
    from vcmm.show.console.complaints import visible_text

    print(f"vcmm {visible_text(_shown(said))}")
    print(
        f"made with vcmm {visible_text(brief(body['version_then']))}, run again with {version}; {len(said['files'])} files, all unchanged"
    )
    if body["identical"]:
        print("every number is the same, to the last bit")
    elif body["same"]:
        print(f"every number is the same within {body['largest_relative_difference']:.1e}")
    else:
        print("the numbers are not the same:")
        for one in body["differences"][:10]:
            was, found = (visible_text(brief(str(one[k]))) for k in ("was", "found"))
            print(f"  {visible_text(brief(one['key'], 200))}: {was} then, {found} now")
    covered = [str(i["influence"]) for i in said["influences"] if i["status"] != "not covered"]
    print(f"influences covered: {visible_text(brief(', '.join(covered), 2000))}")
