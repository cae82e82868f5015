"""Track: process all recordings of a folder in the order of their dates into one state of the machine that is kept and continued."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm.core.blocks import Progress
from vcmm.core.errors import UsageError, VcmmError, first_of
from vcmm.core.machine import Machine
from vcmm.core.own_files import check_replacing
from vcmm.files.learned.track_result import Track
from vcmm.files.learned.track_state import (
    NUMBERS,
    TEXT,
    KnownFile,
    hash_of,
    read_state,
    recording_hash,
    write_state,
)
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_data import recordings_in
from vcmm.files.toml import read_toml
from vcmm.learn.diagnosis.plain_words import cause_and_cure
from vcmm.learn.tracking.alarms import ALPHA
from vcmm.learn.tracking.compress import see_recording
from vcmm.learn.tracking.dates import moment
from vcmm.learn.tracking.follow import FollowedMachine, follow_one, start_following
from vcmm.learn.tracking.machine_at import as_machine, machine_on
from vcmm.learn.tracking.quantities import TrackedMachine, tracked_machine
from vcmm.task.response.recording import Recording

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.result import Answer

OWN = (
    TEXT,
    NUMBERS,
    "machine.toml",
    "machine_errors.csv",
    "machine_state.csv",
    "machine_since.csv",
    "machine_learned.toml",
    "learned_residual.csv",
)

MOST_LOGGED_SIZES = 3  # sizes of an answer that the log of an alarm states


@dataclass(frozen=True)
class TrackRequest:
    """machine: its file; folder: of the recordings; state: folder of the state, None: nothing is kept. replay: compute everything anew."""

    machine: Path
    folder: Path
    state: Path | None
    replay: bool = False
    alpha: float = ALPHA
    explain: bool = True
    seed: int = 0


def track(
    machine: str | Path,
    folder: str | Path,
    *,
    at: str | None = None,
    state: str | Path | None = None,
    replay: bool = False,
    alpha: float = ALPHA,
    explain: bool = True,
    seed: int = 0,
    progress: Progress = lambda text, share: None,
) -> Track:
    """Return the knowledge about a machine on a day from all recordings of a folder.

    Parameters
    ----------
    machine
        Path of the machine file.
    folder
        Path of the folder of its recordings.
    at
        The day, ISO 8601; None: that of the last recording.
    state
        Folder where the state is kept and taken up again; None keeps nothing.
    replay
        Work everything out anew.
    alpha
        Chance of any false alarm, over all recordings.
    explain
        Run `diagnose` where there is an alarm.
    seed
        Of the draws of `diagnose`.
    progress
        Called with the name of each recording and the share that is done.

    Returns
    -------
    Track
        The machine as known on that day, with its alarms.

    Raises
    ------
    UsageError, DataError
        Recordings without a date, older than the state, or changed since; files that cannot be read.
    """
    request = TrackRequest(
        Path(machine),
        Path(folder),
        None if state is None else Path(state),
        replay=replay,
        alpha=alpha,
        explain=explain,
        seed=seed,
    )
    _check_alpha(alpha)
    _take_state_folder(request)
    followed, files, added = _take_in(request, progress)
    when = _day_of(at, followed.recordings[-1].when, files[-1])
    return Track(
        followed, machine_on(followed, when), at or files[-1].date, added, request.machine, request.folder
    )


def _take_in(request: TrackRequest, progress: Progress) -> tuple[FollowedMachine, tuple[KnownFile, ...], int]:
    """Return the machine after all recordings of the folder, their files, and the number of new ones; the state is kept."""
    machine = load_machine(request.machine)
    tracked, of_machine = tracked_machine(machine), hash_of(request.machine)
    in_time = _in_time(request.folder)
    followed, files, is_kept = _state_before(request, tracked, of_machine)
    new = _new_files(in_time, files, request)
    for i, file in enumerate(new):
        progress(file.name, i / len(new))
        followed = _follow_file(request, machine, followed, file)
        files = (*files, file)
    if not followed.recordings:
        raise UsageError(f"{request.folder} holds no recording")
    if request.state is not None and (new or not is_kept):
        write_state(request.state, followed, of_machine, files)
    return followed, files, len(new)


def _state_before(
    request: TrackRequest, tracked: TrackedMachine, of_machine: str
) -> tuple[FollowedMachine, tuple[KnownFile, ...], bool]:
    """Return the state to continue from, its files, and whether it was kept. Raises UsageError where it was begun with another alpha."""
    kept = None if request.replay or request.state is None else read_state(request.state, tracked, of_machine)
    if kept is None:
        return start_following(tracked, request.alpha), (), False
    if kept[0].alpha != request.alpha:
        raise UsageError(
            f"the state was begun with alpha = {kept[0].alpha:g}, which holds for all its recordings; say --alpha {kept[0].alpha:g}, or --replay"
        )
    return *kept, True


def _day_of(at: str | None, last: float, file: KnownFile) -> float:
    """Return the day of `at`, None: that of the last recording. Raises UsageError for a day before it."""
    when = last if at is None else moment(at)
    if when < last:
        raise UsageError(
            f"--at {at} is before the last recording ({file.date}), which the state knows; a state looks ahead, "
            "so name a later day, or follow a folder that ends before it"
        )
    return when


def _take_state_folder(request: TrackRequest) -> None:
    """Claim the files of the state for the command. Raises UsageError for a place among the recordings."""
    if request.state is None:
        return
    if request.state.resolve().is_relative_to(request.folder.resolve()):
        raise UsageError(
            f"{request.state} lies among the recordings of {request.folder}; name a folder beside it for the state"
        )
    if request.machine.resolve().parent == request.state.resolve():
        raise UsageError(
            f"{request.machine} lies in {request.state}, where the machine file of the day is written; keep the file that it starts from elsewhere"
        )
    check_replacing(
        [request.state / name for name in OWN]
    )  # a task may name the machine file of the day before


def _check_alpha(alpha: float) -> None:
    if not 0 < alpha < 1:
        raise UsageError(f"alpha = {alpha:g} is no chance of a false alarm; write for example 0.05")


def _in_time(folder: Path) -> list[KnownFile]:
    """Return all recordings of a folder by date, then by name. Raises UsageError naming those without a date."""
    if not folder.is_dir():
        raise UsageError(f"{folder} is no folder; give the folder that holds the recordings")
    out, without = [], []
    for path in recordings_in(folder):
        content, name = read_toml(path).data, path.relative_to(folder).as_posix()
        date = str(content.get("date", ""))
        if not date:
            without.append(name)
            continue
        out.append(KnownFile(name, date, recording_hash(path, content)))
    if without:
        raise UsageError(
            f"{folder}: {', '.join(without[:5])}{' and others' if len(without) > 5 else ''}: no date, so that nothing can be put in order; "
            'add for example date = "2026-11-22" to the recording file'
        )
    return sorted(out, key=lambda f: (moment(f.date), f.name))


def recordings_by_date(folder: Path, machine: Machine) -> list[tuple[str, Recording]]:
    """Return (name, recording) of a folder in the order of their dates."""
    return [(f.name, load_recording(folder / f.name, machine, gaps=True)[0]) for f in _in_time(folder)]


def _new_files(
    files: Sequence[KnownFile], earlier: Sequence[KnownFile], request: TrackRequest
) -> list[KnownFile]:
    """Return the files that the state does not hold yet. Raises UsageError where one is older than the state, changed since, or gone."""
    have = {f.name: f for f in earlier}
    for f in files:
        if f.name in have and f != have[f.name]:
            raise UsageError(
                f"{request.folder / f.name} was changed since the state took it in; --replay works everything out anew"
            )
    gone = sorted(have.keys() - {f.name for f in files})
    if gone:
        raise UsageError(
            f"{request.folder} no longer holds {gone[0]}, which the state ({request.state}/{TEXT}) knows; put it back, or --replay"
        )
    new = [f for f in files if f.name not in have]
    if earlier and new and _order(new[0]) < _order(earlier[-1]):
        raise UsageError(
            f"{request.folder / new[0].name} of {new[0].date} is older than the state, which ends on {earlier[-1].date}; --replay "
            "works everything out anew in the order of the dates"
        )
    return new


def _order(file: KnownFile) -> tuple[float, str]:
    return moment(file.date), file.name


def _follow_file(
    request: TrackRequest, machine: Machine, before: FollowedMachine, file: KnownFile
) -> FollowedMachine:
    """Process one more recording; `diagnose` explains an alarm against the knowledge before it."""
    recording, _ = load_recording(request.folder / file.name, machine, gaps=True)
    compressed = see_recording(before.tracked, recording, file.name, moment(file.date))
    after = follow_one(before, compressed, file.date)
    last = after.checks[-1]
    if not (last.alarm and request.explain):
        return after
    answer = _explain(before, recording, compressed.when, request.seed)
    return replace(after, checks=(*after.checks[:-1], replace(last, answer=answer)))


def _explain(before: FollowedMachine, recording: Recording, when: float, seed: int) -> str:
    """Return the diagnosis of a recording against the machine as it was expected that day."""
    from vcmm.learn.diagnosis.job import diagnose  # large, and seldom needed

    try:
        diagnosis = diagnose(recording, as_machine(machine_on(before, when)), seed=seed)
    except VcmmError as error:
        return f"no diagnosis: {first_of(error)}"
    return (
        f"{diagnosis.verdict}: {'; '.join(map(_in_words, diagnosis.answer))}"
        if diagnosis.answer
        else diagnosis.verdict
    )


def _in_words(answer: Answer) -> str:
    """Return an answer in words: squareness C0Y, angle +38.4 ± 2.3 urad (a collision, or ...): its departure from the expected value."""
    name = " ".join([answer.effect, *(str(v) for v in answer.where.values())])
    sizes = [f"{k} {e.value:+.3g} ± {e.u:.2g} {e.unit}" for k, e in answer.parameters.items()]
    cause, _ = cause_and_cure(answer.effect, answer.where, answer.parameters)
    return f"{', '.join([name, *sizes[:MOST_LOGGED_SIZES]])}{f' ({cause})' if cause else ''}"
