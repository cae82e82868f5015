"""Findings that the loop uses: the comparison, the diagnosis, and only those names that predict passes that they were not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.face.cli.cut_measured import CameBack, came_back, machine_file
from vcmm.face.cli.diagnose_written import improved_files, read_back
from vcmm.face.job import Progress
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.recording import load_recording, machine_of
from vcmm.files.toml_edits import editable, move_names, with_value_for_table
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.result import Answer, Diagnosis
from vcmm.learn.diagnosis.result_parts import Attempt
from vcmm.learn.diagnosis.verdict import doubt_remarks
from vcmm.learn.diagnosis.written_machine import answers_to_write
from vcmm.shop.machining.held_out import HeldOutProof, held_out_proof
from vcmm.shop.machining.measured_part import MeasuredCut, rest_of
from vcmm.show.console.complaints import about

SURE = 0.95  # probability of a name from which on what the part cannot show of it is corrected too
SHARED = "the next part is corrected by what they share"
OPEN = f"which of them it is remains open ({{}}); {SHARED}"
WITHOUT = {"explained": "unexplained", "partly explained": "unexplained"}


@dataclass(frozen=True, eq=False)
class LoopFindings:
    """The comparison, the diagnosis and the machine file to go on with; rest (n,) mm: residual of the measured points under that file; held_out: its
    proof, None where nothing was found to write."""

    cut: CameBack
    diagnosis: Diagnosis
    machine: Path
    is_improved: bool
    output_files: tuple[str, ...]
    rest: Array
    held_out: HeldOutProof | None


@dataclass(frozen=True)
class _Part:
    """The measured part: scenario file, points with u of one or None, whether they are in the frame of the machine; seed; folder to write into."""

    scenario: Path
    points_and_u: tuple[GivenPoints, float | None]
    in_machine: bool
    seed: int
    folder: Path


def diagnose_cut(
    scenario: Path, given: tuple[GivenPoints, float | None], in_machine: bool, seed: int, folder: Path, report: Progress
) -> LoopFindings:  # fmt: skip
    """Cut, compare and diagnose; the recording and the improved machine file are written."""
    named, why = machine_file(scenario)
    if named is None:
        raise UsageError(f"{scenario}: {why}; the loop writes what it finds into a machine file")
    back = came_back(
        scenario, load_cut(scenario), given, in_machine=in_machine, seed=None, folder=folder, report=report
    )
    written = back.recording
    assert written is not None
    recording, machine = load_recording(written, None)
    with about(written):
        diagnosis = diagnose(recording, machine, seed=seed, progress=report)
    part = _Part(scenario, given, in_machine, seed, folder)
    return _what_holds(part, back, written, diagnosis, machine)


def _what_holds(
    part: _Part, back: CameBack, recording: Path, diagnosis: Diagnosis, machine: Machine
) -> LoopFindings:
    """Return as much of the findings as holds in passes held out: all of it, else without the last name, and so on, else nothing."""
    proof = None
    diagnosis = _with_open_names(diagnosis)
    while True:
        tried, improved = _write_and_read_again(part, recording, diagnosis, machine)
        if not improved:
            named = machine_of(recording)[0]
            assert named is not None
            return LoopFindings(
                back, tried, named, is_improved=False, output_files=(recording.name,), rest=back.cut.observed.rest, held_out=proof
            )  # fmt: skip
        rest, proof = _proof(part, back.cut)
        if _is_open(proof, answers_to_write(tried.answer)):
            _leave_out_shift(part.folder / "machine.toml", proof.shift)
            rest, proof = _proof(part, back.cut)
        why = _why_not(proof, answers_to_write(tried.answer))
        if not why:
            names = (recording.name, *improved, "next.toml")
            return LoopFindings(
                back, tried, part.folder / "machine.toml", is_improved=True, output_files=names, rest=rest, held_out=proof
            )  # fmt: skip
        for name in (*improved, "next.toml"):
            (part.folder / name).unlink(missing_ok=True)
        diagnosis = _without_last(diagnosis, why)


def _write_and_read_again(
    part: _Part, recording: Path, diagnosis: Diagnosis, machine: Machine
) -> tuple[Diagnosis, dict[str, str]]:
    """Write the machine file and the scenario of the next part, and read them again; no texts where there is nothing to write."""
    attempt = Attempt.none()
    improved = improved_files(part.folder, recording, None, machine, diagnosis)
    again, improved = read_back(part.folder, improved, [recording], diagnosis, attempt)
    again = replace(again, failures=(*again.failures, *attempt.failures))
    if improved:
        text = _next_scenario(part.scenario, part.folder)
        (part.folder / "next.toml").write_text(text, encoding="utf-8")
    return again, improved


def _proof(part: _Part, cut: MeasuredCut) -> tuple[Array, HeldOutProof]:
    """Return the residual of the measured points under the written machine file, and the significance of the difference in passes held out."""
    rest = rest_of(load_cut(part.folder / "next.toml"), part.points_and_u[0], part.in_machine)
    shape = cut.observed.rest - rest
    return rest, held_out_proof(cut.observed, shape, cut.scatter, not part.in_machine, part.seed)


def _why_not(proof: HeldOutProof, answers: Sequence[Answer]) -> str:
    """Return why the findings are not to be written; "" where they are."""
    if not proof.holds:
        return (
            f"its evidence is {proof.evidence:.1f} nats, where scatter alone reaches {proof.threshold:.1f}, and passes that it is not fitted to gain {proof.gain:.1f} nats by it: "
            "cut and measure another part, or one with more passes under these conditions"
        )
    if _is_open(proof, answers) and proof.rigid_square > proof.visible_square:
        return (
            f"most of what it moves is a shift or turn of the whole part (up to {proof.largest * 1e3:.2f} µm), which points in the drawing frame cannot show, and its name is "
            "open; measure in the frame of the machine (--frame machine), or the same part from its zero"
        )
    return ""


def _with_open_names(diagnosis: Diagnosis) -> Diagnosis:
    """Return the diagnosis with names to write that are open between some with the same effect on this part, where it is certain that it is one of
    them: the next part is corrected by their common effect."""
    if answers_to_write(diagnosis.answer):
        return diagnosis
    answer = tuple(
        replace(
            a,
            alias_probability=a.with_rivals,
            remark="; ".join(filter(None, (a.remark, OPEN.format(", ".join(a.cannot_be_told_from))))),
        )
        if a.improbable and a.cannot_be_told_from and a.with_rivals >= SURE
        else a
        for a in diagnosis.answer
    )
    if not answers_to_write(answer):
        return diagnosis
    verdict = {"unexplained": "partly explained"}.get(diagnosis.verdict, diagnosis.verdict)
    return replace(diagnosis, answer=answer, verdict=verdict)


def _is_open(proof: HeldOutProof, answers: Sequence[Answer]) -> bool:
    """Return whether what the part cannot show rests on a name that is not sure."""
    sure = min((_certainty(a) for a in answers), default=SURE)
    return bool(sure < SURE and proof.rigid_square > 0.0)


def _certainty(a: Answer) -> float:
    """Return the probability that it is this name, its family, or one that repeats it exactly; of names that are left open that of the name alone."""
    shared = SHARED in a.remark
    elsewhere = any(other.startswith(f"{a.family}[") for other in a.cannot_be_told_from)
    family = 0.0 if elsewhere else a.family_probability
    return float(max(a.probability, family, 0.0 if shared or elsewhere else a.alias_probability))


def _leave_out_shift(machine: Path, shift: tuple[float, float, float]) -> None:
    """Subtract in the machine file the shift of the whole part by the name: the points, aligned to themselves, do not show it."""
    text = machine.read_text(encoding="utf-8")
    for direction, amount in zip("xyz", shift):
        text += (
            "\n# a shift of the whole part, which the measured points cannot show, is left out of what was found\n"
            f'[[effects]]\neffect = "work_offset"\ndirection = "{direction}"\nshift = "{-amount * 1e3:.4f} um"\n'
        )
    machine.write_text(text, encoding="utf-8")


def _without_last(diagnosis: Diagnosis, why: str) -> Diagnosis:
    """Return the diagnosis with the last of the names to write withheld; without any, a mistake of the table is left alone too."""
    written = [id(a) for a in answers_to_write(diagnosis.answer)]
    kept = [
        a
        for a in diagnosis.answer
        if id(a) in written or (a.renewed_tables is not None and not a.withheld_because)
    ]
    if not kept:
        return replace(diagnosis, mistake=None, verdict=WITHOUT.get(diagnosis.verdict, diagnosis.verdict))
    answer = tuple(replace(a, withheld_because=why) if a is kept[-1] else a for a in diagnosis.answer)
    left = len(kept) > 1 or diagnosis.mistake is not None
    verdict = diagnosis.verdict if left else WITHOUT.get(diagnosis.verdict, diagnosis.verdict)
    if left and verdict == "explained":
        verdict = "partly explained"
    reasons = tuple(dict.fromkeys((*diagnosis.reasons, *doubt_remarks(answer))))
    return replace(diagnosis, answer=answer, verdict=verdict, reasons=reasons)


def _next_scenario(scenario: Path, folder: Path) -> str:
    """Return the text of the scenario with the new machine file, its other files seen from the folder."""
    edited = editable(scenario)
    move_names(edited, scenario.parent, folder)
    with_value_for_table(edited, "machine", "machine.toml")
    return str(edited.as_string())
