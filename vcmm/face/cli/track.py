"""vcmm track: follow a machine in time by all recordings of a folder."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import CountOption, InputFile, InputPath, Json, Seed
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.learned.track import recordings_by_date, track
from vcmm.files.learned.track_result import DAYS, Track
from vcmm.files.own.machine import load_machine
from vcmm.show.console.documents import sources_of_all
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.pages.track import track_page
from vcmm.show.tables import track as tables
from vcmm.show.tables.answers_runs import track_answers
from vcmm.show.tables.table import csv_text

if TYPE_CHECKING:
    from vcmm.learn.tracking.doubtful import DoubtfulParts
    from vcmm.learn.tracking.learned_rest import LearnedRest


def track_command(
    machine: InputFile, folder: InputPath, *, at: str | None = None, out: Path | None = None, replay: bool = False, task: InputFile | None = None,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None, checks: InputFile | None = None,
    days: CountOption = None, learn_rest: bool = False, parts: InputFile | None = None,
    alpha: float = 0.05, explain: bool = True, seed: Seed = 0,
    json: Json = False,
) -> int:  # fmt: skip
    """Follow a machine through all recordings of a folder: its numbers today with their uncertainty, what changed and since when.

    Exit code 1: the last recording is not as it was predicted (an alarm).

    Parameters
    ----------
    machine
        Machine file, valid at the date of the first recording: what calibrate or diagnose wrote, or with stated uncertainties.
    folder
        Folder of recordings (recording/1), each with its date; taken in the order of the dates.
    at
        Day for which machine.toml is written, such as 2026-12-01; default: the day of the last recording.
    out
        Folder for the state (track.toml, track.npz), machine.toml with its tables, report.html, track.json, checks.csv and numbers.csv; default: FOLDER-track beside the folder. A state that lies there is taken up.
    replay
        Work everything out anew, in the order of the dates, whatever state lies there.
    task
        Scenario (scenario/1) measured on this machine, whose U is to stay below --limit.
    limit
        Characteristic and largest U = 2 u, such as "bore to front = 2 um"; may be repeated.
    checks
        The checks that the shop has, with their cost (checks/1); with --task: which one next, when, and a plan.
    days
        Days that the plan covers from --at on (default 30).
    learn_rest
        Learn what is missing and has no name: where the earlier recordings foretell it in the later ones, machine_learned.toml is the machine file with the term (effect learned_residual), learned_residual.csv its rows.
    parts
        Parts that were measured or cut, with their dates (part,date); with --task: which are doubtful after each alarm, and by how much their characteristics may be shifted.
    alpha
        Chance of any false alarm, over all recordings that will ever come.
    explain
        Run diagnose on a recording that raises an alarm, against the machine as it was predicted; --no-explain leaves it out.
    seed
        Seed of the null recordings of the diagnosis.
    json
        Print one JSON document.
    """
    target = out or folder.parent / f"{folder.name}-track"
    following = FollowingOptions(at, replay, alpha, explain, seed)
    questions = Questions(task, tuple(limit or ()), checks, days, parts, learn_rest)
    return run_job(TrackJob(machine, folder, target, following, questions), Flags(json, target))


class FollowingOptions(NamedTuple):
    """Options of the tracking of recordings, passed to `vcmm.files.learned.track.track`."""

    at: str | None
    replay: bool
    alpha: float
    explain: bool
    seed: int


class Questions(NamedTuple):
    """Further questions: the next check (task, limits, checks, days), doubtful parts, missing effects without a name."""

    task: Path | None
    limits: tuple[str, ...]
    checks: Path | None
    days: int | None
    parts: Path | None
    rest: bool


class TrackAnswers(NamedTuple):
    """The machine followed; plan: which check next; rest: missing effects without a name; doubtful: parts. None and empty where not requested."""

    track: Track
    plan: tables.Planned | None
    rest: LearnedRest | None
    doubtful: Sequence[DoubtfulParts]


@dataclass(frozen=True)
class TrackJob(Job[Path, TrackAnswers]):
    """A machine followed by the recordings of a folder; they are read one after another while it is followed. target: of --out."""

    machine: Path
    folder: Path
    target: Path
    following: FollowingOptions
    questions: Questions
    schema, names_files_last = "vcmm.track/1", True

    def load(self) -> Path:
        return self.folder

    def run(self, loaded: Path, report: Progress) -> TrackAnswers:
        """Follow the machine; the state is in the folder --out afterwards, for any further questions."""
        followed = track(self.machine, loaded, state=self.target, progress=report, **self.following._asdict())
        doubtful = self._doubtful(followed)
        planned = self._plan(followed)
        return TrackAnswers(followed, planned, self._rest() if self.questions.rest else None, doubtful)

    def _plan(self, followed: Track) -> tables.Planned | None:
        """Return which check is next; None where it was not requested."""
        _, limits, checks, days, parts, _ = self.questions
        task = None if parts and not limits else self.questions.task
        if task is None and not limits and checks is None and days is None:
            return None
        if task is None or not limits or checks is None:
            raise UsageError(
                'which check next takes --task SCENARIO, --limit "CHARACTERISTIC = U" and --checks LIST; one of them is missing'
            )
        return followed.next_checks(task, limits, checks, days or DAYS)

    def _doubtful(self, followed: Track) -> Sequence[DoubtfulParts]:
        """Return the parts between a good check and an alarm; nothing where no list was given."""
        if self.questions.parts is None:
            return ()
        if self.questions.task is None:
            raise UsageError(
                "--parts takes --task SCENARIO as well: the characteristics whose shift is wanted"
            )
        return followed.doubtful_parts(self.questions.task, self.questions.parts)

    def _rest(self) -> LearnedRest:
        """Return the learned residual of all recordings against the machine file."""
        from vcmm.learn.tracking.learned_rest import learn_rest

        machine = load_machine(self.machine)
        return learn_rest(machine, recordings_by_date(self.folder, machine))

    def record(self, loaded: Path, result: TrackAnswers) -> Record:
        followed, planned, rest, doubtful = result
        named = (self.machine, self.questions.task, self.questions.checks, self.questions.parts)
        recordings = sorted(
            loaded / c.name for c in followed.checks
        )  # all of the folder: each was read to follow it
        given = [*(p for p in named if p is not None), *recordings]
        track_body = followed.to_dict()
        body = {**track_body, "machine": str(self.target / "machine.toml"), "name": track_body["machine"]}
        if planned is not None:
            body |= tables.plan_document(planned, followed)
        if doubtful:
            body |= {"doubtful": [d.to_dict() for d in doubtful]}
        if rest is not None:
            body |= {"learned": rest.to_dict()}
        files = sources_of_all(given)
        return Record(body, files, self.following.seed, followed.warnings)

    def texts(self, loaded: Path, result: TrackAnswers, content: str, folder: Path) -> dict[str, str]:
        followed, planned, rest, doubtful = result
        return {
            **followed.files(folder / "machine.toml"),
            **(self._learned(rest, folder) if rest is not None else {}),
            "track.json": content,
            "report.html": track_page(followed, planned, doubtful),
            "checks.csv": csv_text(tables.checks(followed)),
            "numbers.csv": csv_text(tables.numbers(followed, most=len(followed.courses))),
        }

    def _learned(self, rest: LearnedRest, folder: Path) -> dict[str, str]:
        from vcmm.files.learned.learned_residual import learned_files

        return learned_files(rest, self.machine, folder)

    def files_sentence(self, loaded: Path, result: TrackAnswers, folder: Path, names: Sequence[str]) -> str:
        followed = result.track
        return (
            f"{followed.new_recordings} recordings taken in, {len(followed.checks)} in the state; wrote {folder}/"
            + ", ".join(names)
        )

    def notes(self, loaded: Path, result: TrackAnswers) -> Iterator[str]:
        followed, rest = result.track, result.rest
        if rest is not None:
            yield f"learned residual: {rest.sentence}; {rest.REFERENCE}"
        for warning in followed.warnings:
            yield f"note: {warning}"

    def exit_code(self, loaded: Path, result: TrackAnswers) -> int:
        return 1 if result.track.checks[-1].alarm else 0

    def show(self, loaded: Path, result: TrackAnswers) -> None:
        followed, planned, _, doubtful = result
        show_answers(track_answers(followed, planned))
        if followed.alarms:
            show_table(tables.alarms(followed))
        if doubtful:
            show_table(tables.doubtful(doubtful))
        show_table(tables.numbers(followed))
        show_table(tables.checks(followed))
        if planned is not None:
            show_table(tables.next_checks(planned, followed))
            show_table(tables.plan(planned, followed))
