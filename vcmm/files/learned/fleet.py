"""Diagnose many recordings: the findings of each by place and time, and their changes on a machine.

A recording that cannot be read or diagnosed becomes a row that says why; the others are diagnosed all the same. Rows are plain values
that depend on the files and the seed alone, so that workers, order and interruptions
do not matter.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from vcmm.core.blocks import Sharing
from vcmm.core.errors import VcmmError, first_of
from vcmm.core.run import Run
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.toml import read_toml
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.result import Answer, diagnosis_json
from vcmm.learn.diagnosis.trend import ALWAYS, STEADY, Trend, presence, trend

COMMON_KEYS = ("verdict", "answer", "unknown", "fit", "searched", "warnings")  # of every diagnosis
NO_TREND = Trend("")
UM_PER_M = 1e-3  # of g1: um/m times mm is 1e-3 um
Record = dict[str, Any]


@dataclass(frozen=True)
class FolderJob:
    """Options for every recording. machine: a file that is used instead of the one that each names."""

    folder: Path
    seed: int
    machine: Path | None = None


@dataclass(frozen=True)
class Change:
    """A number of a name that was found on a machine at least twice, or found once and once not.

    first, last: file and date; value, u in `unit`; None where the name was not found then. occurrences: in how many of
    `recordings_total`. trend, presence: course of the number in time, and when it was found; their ends are numbers of
    `recordings`, file and date of all recordings of the machine.
    """

    machine: str
    name: str
    parameter: str
    unit: str
    first: tuple[str, str]
    last: tuple[str, str]
    before: tuple[float, float] | None
    after: tuple[float, float] | None
    occurrences: int
    recordings_total: int
    trend: Trend = NO_TREND
    presence: tuple[str, int | None, int | None] = (ALWAYS, None, None)
    recordings: tuple[tuple[str, str], ...] = ()

    def at(self, number: int | None) -> str | None:
        """Return the date of a recording, its file where it has none."""
        return None if number is None else self.recordings[number][1] or self.recordings[number][0]

    @property
    def steady(self) -> bool:
        """Whether it was found in all recordings, and its values are consistent with one number."""
        return self.trend.kind in ("", STEADY) and self.presence[0] == ALWAYS

    @property
    def change(self) -> float | None:
        """Last less first, where both are known."""
        return self.after[0] - self.before[0] if self.before and self.after else None

    @property
    def deviations(self) -> float | None:
        """The change over its standard uncertainty, the two recordings independent."""
        if self.change is None or self.before is None or self.after is None:
            return None
        u = float((self.before[1] ** 2 + self.after[1] ** 2) ** 0.5)
        return self.change / u if u > 0 else None


def diagnosed_folder(
    job: FolderJob, files: Sequence[Path], key: str, sharing: Sharing, progress: Callable[[float], None]
) -> list[Record]:
    """Return a record of every file, in their order. Raises ShardDone where a share is wanted, DataError where a shard lacks some."""
    return sharing.map_items(key, record_of, job, [str(file) for file in files], progress)


def record_of(job: FolderJob, file: str) -> Record:
    """Return one recording as plain values: the kept part of its diagnosis, or `problem`, why there is none."""
    path = Path(file)
    record: Record = {"file": path.relative_to(job.folder).as_posix(), "machine": "", "date": ""}
    try:
        record["date"] = str(read_toml(path).data.get("date", ""))
        recording, machine = load_recording(
            path, load_machine(job.machine) if job.machine else None, gaps=True
        )
        record["machine"] = machine.name
        diagnosed = diagnose(recording, machine, seed=job.seed)
        as_json = diagnosis_json(diagnosed)
        for entry, a in zip(as_json["answer"], diagnosed.answer):
            entry["family_size"] = family_size(a, recording.run)
    except VcmmError as error:
        return {**record, "problem": first_of(error).replace(str(job.folder) + "/", ""), "ours": False}
    except (
        Exception
    ) as error:  # an internal error in one of thousands is reported and does not end the others
        return {
            **record,
            "problem": f"internal error ({type(error).__name__}: {error}); please report it",
            "ours": True,
        }
    kept = {k: as_json[k] for k in COMMON_KEYS if k in as_json}
    if kept["unknown"]:  # its curve or map is long, and is in the document of the recording itself
        kept["unknown"] = {k: v for k, v in kept["unknown"].items() if k != "shape"}
    return {**record, "problem": None, "ours": False, **kept}


def family_size(a: Answer, run: Run) -> Record | None:
    """Return, of a play that is constant or grows along its axis, the play in the middle of the rows: one number whichever of the two is named.

    gap(q) = g0 + g1 q at q in the middle of the range; u(g0) + |q| u(g1) is the most that its u can be (Cauchy and Schwarz).
    """
    effect = a.fitted
    if effect is None or not effect.about.gap_parameter:
        return None
    sizes = [a.parameters[n] for n in (effect.about.gap_parameter, "g1") if n in a.parameters]
    axis = str(a.where.get("axis", ""))
    if not sizes or set(a.parameters) - {effect.about.gap_parameter, "g1", "rms"} or axis not in run.position:
        return None
    q = run.position[axis]
    arm = (1.0, 0.5 * float(q.min() + q.max()) * UM_PER_M)[: len(sizes)]
    value = sum(k * e.value for k, e in zip(arm, sizes))
    return {"value": value, "u": sum(abs(k) * e.u for k, e in zip(arm, sizes)), "unit": sizes[0].unit}


def in_time(records: Sequence[Record]) -> list[Record]:
    """Sort the records machine by machine, by date, then by file."""
    return sorted(records, key=lambda r: (r["machine"], r["date"], r["file"]))


def changes(records: Sequence[Record]) -> list[Change]:
    """Return first and last value of every number that was found, machine by machine."""
    out: list[Change] = []
    good = [r for r in in_time(records) if r["problem"] is None]
    for machine in dict.fromkeys(r["machine"] for r in good):
        of_machine = [r for r in good if r["machine"] == machine]
        mixed = _mixed_families(of_machine)
        numbers = [_numbers(r, mixed) for r in of_machine]
        for key in dict.fromkeys(k for n in numbers for k in n) if len(of_machine) > 1 else ():
            out.append(_change(machine, key, of_machine, [n.get(key) for n in numbers]))
    return out


def _change(
    machine: str,
    key: tuple[str, str, str],
    records: Sequence[Record],
    values: Sequence[tuple[float, float] | None],
) -> Change:
    name, parameter, unit = key
    when = tuple((r["file"], r["date"]) for r in records)
    return Change(
        machine, name, parameter, unit, first=when[0], last=when[-1], before=values[0], after=values[-1],
        occurrences=sum(s is not None for s in values), recordings_total=len(records),
        trend=trend([_moment(date) for _, date in when], values), presence=presence(values), recordings=when,
    )  # fmt: skip


def _moment(date: str) -> float | None:
    """Return a date in s, from a fixed origin; None of a text that is no date."""
    try:
        return datetime.fromisoformat(date).replace(tzinfo=None).timestamp()
    except ValueError:
        return None


def _stood(record: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [a for a in record["answer"] if not a["doubtful"] and not a["alias_of"]]


def _family_of(answer: Mapping[str, Any]) -> str:
    """Return the family of an answer, such as 'play Y'."""
    return " ".join((answer.get("family") or answer["effect"], *(str(v) for v in answer["where"].values())))


def _mixed_families(records: Sequence[Record]) -> set[str]:
    """Return the families at a place of which the recordings name more than one member, each with a size of the family: they are one course."""
    named: dict[str, set[str]] = {}
    for a in (a for r in records for a in _stood(r)):
        named.setdefault(_family_of(a), set()).add(a["effect"] if a.get("family_size") else "")
    return {family for family, of in named.items() if len(of) > 1 and "" not in of}


def _numbers(
    record: Mapping[str, Any], mixed: Collection[str] = ()
) -> dict[tuple[str, str, str], tuple[float, float]]:
    """Return (name, parameter, unit) -> value and u of what was found in a recording; of a family in `mixed` its size."""
    out = {}
    for a in _stood(record):
        if _family_of(a) in mixed:
            e = a["family_size"]
            out[_family_of(a), "size in the middle", e["unit"]] = (e["value"], e["u"])
            continue
        for parameter, e in a["parameters"].items():
            out[name_of(a), parameter, e["unit"]] = (e["value"], e["u"])
    return out


def name_of(answer: Mapping[str, Any]) -> str:
    """Return the name of an answer, such as 'backlash Y'."""
    return " ".join((answer["effect"].replace("_", " "), *(str(v) for v in answer["where"].values())))
