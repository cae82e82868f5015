"""vcmm rerun: run an evidence pack again, and compare the numbers."""

from __future__ import annotations

import contextlib
import io
import json as json_module
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from vcmm import __version__
from vcmm.core.confinement import confine
from vcmm.core.errors import DataError, VcmmError
from vcmm.core.text import brief
from vcmm.face.cli import run
from vcmm.face.cli.options import InputFile, Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.complaints import visible_text
from vcmm.show.console.evidence import TOLERANCE, ComparedNumber, differences, unpack_evidence

JOBS = (["evaluate"], ["uncertainty"], ["routes"])
OPTIONS = (
    "--points", "--values", "--frame", "--tip-centres", "--trials", "--seed", "--engine", "--digits", "--calibrated",
    "--repeats", "--positions", "--standards",
)  # fmt: skip


MOST_SHOWN = 300  # characters of a command in a message
MOST_TRIALS = 10_000_000_000  # some minutes of two cores (docs/scale.md): what is run without being asked for


def rerun_command(
    pack: InputFile,
    *,
    most_trials: int = MOST_TRIALS,
    json: Json = False,
    out: Path | None = None,
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
    out
        Folder for rerun.json.
    """
    return run_job(RerunJob(pack, most_trials), Flags(json, out))


class Rerun(NamedTuple):
    """Content of the pack, and the numbers that differ now."""

    record: dict[str, Any]
    differences: list[ComparedNumber]

    @property
    def largest(self) -> float:
        """Largest relative difference."""
        return max((c.relative for c in self.differences), default=0.0)

    @property
    def is_same(self) -> bool:
        return self.largest <= TOLERANCE


@dataclass(frozen=True)
class RerunJob(Job[Path, Rerun]):
    """The command of a pack run again, on the files of the pack, in a folder of its own."""

    evidence: Path
    most_trials: int
    schema = "vcmm.rerun/1"

    def load(self) -> Path:
        return self.evidence

    def run(self, loaded: Path, report: Progress) -> Rerun:
        with TemporaryDirectory() as folder:
            record = unpack_evidence(loaded, Path(folder))
            now = _run_again(record, Path(folder), self.most_trials)
        return Rerun(record, list(differences(record["document"], now)))

    def record(self, loaded: Path, result: Rerun) -> Record:
        record = result.record
        body = {
            "command": record["command"], "same": result.is_same, "identical": not result.differences,
            "largest_relative_difference": result.largest,
            "version_then": record["version"], "libraries_then": record["libraries"],
            "differences": [{"key": c.key, "was": c.was, "found": c.now} for c in result.differences[:100]],
        }  # fmt: skip
        return Record(body, [loaded], record.get("seed"))

    def texts(self, loaded: Path, result: Rerun, content: str, folder: Path) -> dict[str, str]:
        return {"rerun.json": content}

    def exit_code(self, loaded: Path, result: Rerun) -> int:
        return int(not result.is_same)

    def show(self, loaded: Path, result: Rerun) -> None:
        """Show the result; texts of the pack come from others, so control characters are spelled out."""
        record = result.record
        print(f"vcmm {visible_text(_command_of(record))}")
        print(
            f"made with vcmm {visible_text(brief(record['version']))}, run again with {__version__}; {len(record['files'])} files, all unchanged"
        )
        if not result.differences:
            print("every number is the same, to the last bit")
        elif result.is_same:
            print(f"every number is the same within {result.largest:.1e}")
        else:
            print("the numbers are not the same:")
            for difference in result.differences[:10]:
                was, now = (visible_text(brief(str(v))) for v in (difference.was, difference.now))
                print(f"  {visible_text(brief(difference.key, 200))}: {was} then, {now} now")
        covered = [str(i["influence"]) for i in record["influences"] if i["status"] != "not covered"]
        print(f"influences covered: {visible_text(brief(', '.join(covered), 2000))}")


def _run_again(record: dict[str, Any], folder: Path, most_trials: int) -> dict[str, Any]:
    """Return the document of the command of a pack, run on its files in `folder`, and on no others. DataError: it does not run."""
    files = {entry["file"] for entry in record["files"]}
    words = [str(folder / w) if w in files else w for w in record["command"]]
    if (
        words[:1] in JOBS
        and words[1:2]
        and not words[1].startswith("-")
        and record["command"][1] not in files
    ):
        raise DataError("the command of the pack names a scenario outside the given files; nothing was run")
    if not _is_written_here(record["command"], files):
        raise DataError(
            f"the command of the pack is no job that --evidence writes ({_command_of(record)}); nothing was run"
        )
    caught = io.StringIO()
    with confine(folder):
        _check_cost(words, most_trials)
        with contextlib.redirect_stdout(caught):
            code = run([*words, "--json"])
    if code not in (0, 1):
        raise DataError(f"the command of the pack ended with exit code {code}: vcmm {_command_of(record)}")
    document = json_module.loads(caught.getvalue())
    assert isinstance(document, dict)
    return document


def _is_written_here(command: list[str], files: set[str]) -> bool:
    """Return whether --evidence writes such a command: job, scenario of the pack, then options, each once and none beside them."""
    options = [w for w in command if w.startswith("-")]
    return (
        command[:1] in JOBS
        and command[1:2] != []
        and command[1] in files
        and set(options) <= set(OPTIONS)
        and len(options) == len(set(options))
        and not any(w in files and not command[i].startswith("-") for i, w in enumerate(command[2:], 1))
    )


def _command_of(record: dict[str, Any]) -> str:
    """Return the command of a pack for a message, shortened."""
    return brief(" ".join(record["command"]), MOST_SHOWN)


def _check_cost(words: list[str], most: int) -> None:
    """Say on stderr how many trials a command asks for. DataError: more than `most`, or no number."""
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
