"""vcmm track: a machine followed in time by all recordings of a folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import CountOption, Seed


def track_command(
    machine: Path, folder: Path, *, at: str | None = None, out: Path | None = None, replay: bool = False, task: Path | None = None,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None, checks: Path | None = None,
    days: CountOption = None, learn_rest: bool = False, parts: Path | None = None,
    alpha: float = 0.05, explain: bool = True, seed: Seed = 0,
    json: Annotated[bool, Parameter(name="--json")] = False,
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
    from vcmm.files.learned.track import track
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import progress

    target = output_folder(out or folder.parent / f"{folder.name}-track")
    with progress(not json) as show_progress:
        found = track(
            machine, folder, at=at, state=target, replay=replay, alpha=alpha, explain=explain, seed=seed,
            progress=show_progress,
        )  # fmt: skip
    doubtful = _doubtful(found, task, parts)
    planned = _plan(found, (None if parts and not limit else task, limit, checks, days))
    given = [p for p in (machine, task, checks, parts) if p is not None]
    rest = _rest(machine, folder) if learn_rest else None
    _put((found, planned, rest, doubtful), [*given, *_recordings(folder)], (machine, target), seed, json)
    return 1 if found.checks[-1].alarm else 0


def _plan(found: Any, asked: tuple[Path | None, list[str] | None, Path | None, int | None]) -> Any:
    """Which check next; None where it was not asked."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.check_list import load_checks
    from vcmm.files.own.scenario import load_scenario
    from vcmm.learn.tracking.next_check import plan_checks
    from vcmm.learn.tracking.task_limits import limits_of

    task, limit, checks, days = asked
    if task is None and not limit and checks is None and days is None:
        return None
    if task is None or not limit or checks is None:
        raise UsageError(
            'which check next takes --task SCENARIO, --limit "CHARACTERISTIC = U" and --checks LIST; one of them is missing'
        )
    limits = limits_of(limit, load_scenario(task), found.dated)
    return limits, *plan_checks(found.followed, found.dated.when, load_checks(checks), limits, days or 30)


def _doubtful(found: Any, task: Path | None, parts: Path | None) -> Any:
    """Parts between a good check and an alarm; nothing where no list was given."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.dated_parts import read_parts
    from vcmm.files.own.scenario import load_scenario
    from vcmm.learn.tracking.doubtful import doubtful_parts
    from vcmm.learn.tracking.task_limits import gains_of

    if parts is None:
        return ()
    if task is None:
        raise UsageError("--parts takes --task SCENARIO as well: the characteristics whose shift is asked")
    return doubtful_parts(found.followed, read_parts(parts), gains_of(load_scenario(task), found.dated))


def _rest(machine: Path, folder: Path) -> Any:
    """The learned residual of all recordings against the machine file."""
    from vcmm.files.learned.track import recordings_by_date
    from vcmm.files.own.machine import load_machine
    from vcmm.learn.tracking.learned_rest import learn_rest

    known = load_machine(machine)
    return learn_rest(known, recordings_by_date(folder, known))


def _recordings(folder: Path) -> list[Path]:
    from vcmm.files.own.recording_files import recordings_in

    return recordings_in(folder)


def _put(
    results: tuple[Any, Any, Any, Any], given: list[Path], places: tuple[Path, Path], seed: int, json: bool
) -> None:
    """Files, and tables or the document. results: track, plan, learned residual, doubtful parts; places: machine file, folder."""
    from vcmm.files.learned.learned_residual import learned_files
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.pages.track import track_page
    from vcmm.show.tables import track as tables
    from vcmm.show.tables.answers_runs import track_answers
    from vcmm.show.tables.table import csv_text

    (found, planned, rest, doubtful), (machine, target) = results, places
    files = list(dict.fromkeys(f for p in given for f in sources(p)))
    body = {**found.to_dict(), "machine": str(target / "machine.toml"), "name": found.to_dict()["machine"]}
    if planned is not None:
        body |= tables.plan_document(planned, found)
    if doubtful:
        body |= {"doubtful": [d.to_dict() for d in doubtful]}
    if rest is not None:
        body |= {"learned": rest.to_dict()}
    content = document("vcmm.track/1", body, seed=seed, files=files, warnings=found.warnings)
    texts = {
        **found.files(target / "machine.toml"),
        **(learned_files(rest, machine, target) if rest is not None else {}),
        "track.json": json_text(content),
        "report.html": track_page(found, planned, doubtful),
        "checks.csv": csv_text(tables.checks(found)),
        "numbers.csv": csv_text(tables.numbers(found, most=len(found.courses))),
    }
    write_files(target, texts)
    if json:
        print_json(content)
    else:
        show_answers(track_answers(found, planned))
        if found.alarms:
            show_table(tables.alarms(found))
        if doubtful:
            show_table(tables.doubtful(doubtful))
        show_table(tables.numbers(found))
        show_table(tables.checks(found))
        if planned is not None:
            show_table(tables.next_checks(planned, found))
            show_table(tables.plan(planned, found))
    if rest is not None:
        say(f"learned residual: {rest.sentence}")
    for warning in found.warnings:
        say(f"note: {warning}")
    say(
        f"{found.added} recordings taken in, {len(found.checks)} in the state; wrote {target}/"
        + ", ".join(texts)
    )
