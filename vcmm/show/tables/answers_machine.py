"""The answers of jobs on machines and programs, in the lines that are shown first: calibration, diagnosis, compensation, NC programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.error_names import words_of
from vcmm.shop.motion.toolpath import Toolpath, clock
from vcmm.show.report.answers import AnswerLine, K, percent, places_of, signed_value, whole_percent

if TYPE_CHECKING:
    from vcmm.compensation.result import CompensatedProgram
    from vcmm.learn.calibration.acceptance import Figure
    from vcmm.learn.calibration.result import Calibration
    from vcmm.learn.diagnosis.result import Answer, Diagnosis
    from vcmm.program.moves import Program
    from vcmm.program.summary import ProgramSummary
    from vcmm.shop.machining.proof import CutProof
    from vcmm.show.tables.loops import LoopRecord

MOST_FIGURES = 3  # errors named beside an axis


def calibration_answers(calibration: Calibration, figures: Sequence[Figure] = ()) -> list[AnswerLine]:
    """Return A, R, E, M of ISO 230-2 per axis where they are known, and its largest errors by name; then the errors that are not identified."""
    rows = {str(f["error"]): f for f in calibration.figures()}
    by_name = {f.name: f for f in figures}
    out = []
    for axis in calibration.machine.axes:
        errors = [name for name in rows if name[-1] == axis and name[0] == "E"]
        if not errors and not any(n.endswith(f" {axis}") for n in by_name):
            continue
        out.append(_axis_line(axis, errors, rows, by_name))
    pairs = [name for name in rows if name[0] != "E"]
    out += [_pair_line(name, rows[name]) for name in pairs]
    return [*out, _identified_line(calibration)]


def _axis_line(
    axis: str, errors: Sequence[str], rows: Mapping[str, Mapping[str, Any]], by_name: dict[str, Figure]
) -> AnswerLine:
    iso = {n: by_name.get(f"{n} {axis}") for n in ("A", "R", "E", "M")}
    phrases = [
        f"{n} = {signed_value(f.value_um, K * (f.u_um or 0.0), 'µm')}"
        for n, f in iso.items()
        if f is not None and f.value_um is not None
    ]
    missing = [n for n, f in iso.items() if f is not None and f.value_um is None]
    ranked = sorted(errors, key=lambda n: -_size(rows[n]))
    worst = [f"{words_of(n)} ({n}) {_error_text(rows[n])}" for n in ranked[:MOST_FIGURES]]
    coverage = f"k = {K:.0f}, ISO 230-2" + (
        f"; {', '.join(missing)} not known: no repeats" if missing else ""
    )
    return AnswerLine(
        f"{axis} axis",
        "; ".join(phrases) or _positioning_text(f"E{axis}{axis}", rows),
        coverage=coverage if phrases else "",
        verdict=f"{len(errors)} errors found",
        kind="good",
        because=", ".join(worst),
        link="Errors by name",
        numbers={"axis": axis, **{n: None if f is None else f.value_um for n, f in iso.items()}},
        labels=("", "largest:", ""),
    )


def _positioning_text(name: str, rows: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the error itself where A, R, E and M are not known."""
    return f"{words_of(name)} {_error_text(rows[name])}" if name in rows else "positioning is not identified"


def _size(row: Mapping[str, Any]) -> float:
    return float(row.get("high", row.get("value", 0.0))) - float(row.get("low", 0.0))


def _error_text(row: Mapping[str, Any]) -> str:
    """Return the text of an error: -1.2 to 3.4 ± 0.5 µm."""
    unit = "µrad" if row["unit"] == "urad" else "µm"
    expanded = K * float(row["u"])
    if "value" in row:
        return signed_value(float(row["value"]), expanded, unit)
    places = places_of(expanded) if expanded > 0 else 2
    low, high = (f"{float(row[n]) + 0.0:.{places}f}".replace("-", "−") for n in ("low", "high"))
    return f"{low} to {high} {unit}, ± {expanded:.{places}f} {unit}"


def _pair_line(name: str, row: Mapping[str, Any]) -> AnswerLine:
    return AnswerLine(
        f"{words_of(name)} ({name})",
        _error_text(row),
        f"k = {K:.0f}",
        link="Errors by name",
        numbers=dict(row),
    )


def _identified_line(calibration: Calibration) -> AnswerLine:
    left = calibration.identified.briefly()
    verdict = "everything is identified" if not left else "not everything is identified"
    rest = f"condition {calibration.identified.condition:.3g}"
    return AnswerLine(
        "Identified",
        f"{len(calibration.identified.names)} errors",
        coverage=rest,
        verdict=verdict,
        kind="good" if not left else "warning",
        because=left[0] if left else "",
        link="Not identified",
        numbers={"identified": len(calibration.identified.names), "not_identified": len(left)},
        labels=("", "", ""),
    )


def compensation_answers(result: CompensatedProgram, proof: CutProof | None = None) -> list[AnswerLine]:
    """Return whether the tolerance is met: by the cut where one was made, else of the path; and the departures now and before."""
    allowed, after, before = result.tolerance_used, result.after, result.before
    path = AnswerLine(
        "Path of the tool",
        f"at most {after.largest * 1e3:.2f} µm, was {before.largest * 1e3:.2f} µm",
        coverage=f"rms {after.rms * 1e3:.2f} µm, was {before.rms * 1e3:.2f} µm",
        limits=f"at most {allowed * 1e3:g} µm and the rounding of numbers",
        verdict="met" if result.is_met else "not met",
        kind="good" if result.is_met else "bad",
        because=f"line {after.line}" if after.line else "",
        link="Along the program",
        numbers={"largest_um": after.largest * 1e3, "before_um": before.largest * 1e3, "met": result.is_met},
        labels=("", "largest at", ""),
    )
    if proof is None or proof.after is None:
        why = "no part is known that a cut could be inspected on" if proof is None else proof.reason
        return [
            path,
            AnswerLine(
                "Proof by a cut",
                "nothing was inspected",
                verdict="not shown",
                kind="warning",
                because=why,
                labels=("", "", ""),
            ),
        ]
    cut, was = proof.after, proof.before
    first = AnswerLine(
        "The part, cut with the new program",
        f"at most {cut.largest * 1e3:.2f} µm" + (f", was {was.largest * 1e3:.2f} µm" if was else ""),
        coverage=f"mean {cut.mean * 1e3:.2f} µm, {len(cut.off)} points",
        limits=f"at most {proof.limit * 1e3:.2f} µm",
        verdict="met" if proof.is_met else "not met",
        kind="good" if proof.is_met else "bad",
        because=f"feature {cut.worst}",
        numbers={"largest_um": cut.largest * 1e3, "met": proof.is_met},
        labels=("", "largest at", ""),
    )
    return [first, path]


def program_answers(
    program: Program, total: ProgramSummary, path: Toolpath | None = None
) -> list[AnswerLine]:
    """Return time and extents first, then assumptions and unused words."""
    seconds = total.cutting_time + total.dwell_time if path is None else path.seconds
    how = (
        "cutting at the programmed feed and dwells; rapids are not in it"
        if path is None
        else "by the time law of the machine"
    )
    lines = [
        AnswerLine(
            "Time",
            f"{clock(seconds)} ({seconds:.1f} s)",
            coverage=how,
            verdict=f"{len(program.moves)} move{'s' * (len(program.moves) != 1)}",
            numbers={"seconds": seconds, "moves": len(program.moves)},
        )
    ]
    for name, box in (("Extent of the cuts", total.cutting), ("Extent of the tip", total.machine)):
        if box is not None:
            size = " × ".join(f"{b - a:.1f}" for a, b in zip(*box))
            place = ", ".join(f"{axis} {a:.3f} … {b:.3f}" for axis, a, b in zip("XYZ", *box))
            words = f"{place} mm, machine axes"
            lines.append(AnswerLine(name, f"{size} mm", words, numbers={"box": [list(box[0]), list(box[1])]}))
    if program.assumed:
        first = program.assumed[0]
        lines.append(
            AnswerLine(
                "Assumed",
                f"{len(program.assumed)} times" if len(program.assumed) > 1 else "once",
                verdict="to be confirmed",
                kind="warning",
                because=f"{first.what}: {first.value}",
                change="a set-up file (--write-setup)"
                if first.blank
                else "--strict"
                if first.refusal
                else "",
                link="Assumed",
                labels=("", "", "state it in" if first.blank else "refused by"),
            )
        )
    if program.unused:
        lines.append(_unused_words(program))
    return lines


def _unused_words(program: Program) -> AnswerLine:
    """Return how many words of a program move nothing and state nothing, with the first of them."""
    words = list(dict.fromkeys(u.word for u in program.unused))
    return AnswerLine(
        "Words that nothing uses",
        f"{len(program.unused)} times",
        verdict="passed over",
        kind="warning",
        because=", ".join(words[:3]) + (" …" if len(words) > 3 else ""),
        change="--strict",
        labels=("", "", "refused by"),
        numbers={"unused": len(program.unused)},
    )


def diagnosis_answers(d: Diagnosis) -> list[AnswerLine]:
    """Return the effects missing from the machine model, ranked by the variance of each; or that none is missing, or has no name."""
    from vcmm.show.tables.diagnosis import micro_text  # a program that is rewritten loads no diagnosis

    ranked = sorted(d.found, key=lambda a: -a.share)
    lines = [_fault_line(k, a) for k, a in enumerate(ranked, 1)]
    if d.unknown is not None:
        lines.append(
            AnswerLine(
                "Not in the catalogue",
                f"rms {micro_text(d, d.unknown.rms)}",
                verdict="no name is claimed",
                kind="warning",
                because=f"over {', '.join(d.unknown.covariates)}",
                link="What is not in the catalogue",
                numbers={"rms": d.unknown.rms},
            )
        )
    fit = d.fit
    micro = lambda v: micro_text(d, v)  # noqa: E731
    kind = {"nothing missing": "good", "explained": "good"}.get(d.verdict, "warning")
    residual = AnswerLine(
        "Residual of the recording",
        f"rms {micro(fit.after)}, was {micro(fit.before)}",
        coverage=f"noise {micro(fit.noise)}",
        verdict=d.verdict,
        kind=kind,  # type: ignore[arg-type]
        because="" if lines else "no departure exceeds the noise",
        link="Residual before and after",
        numbers={"verdict": d.verdict, "rms_before": fit.before, "rms_after": fit.after},
    )
    return [*lines, residual]


def _unit(name: str) -> str:
    """Convert um/m -> µm/m, as people write it; nothing for a pure number."""
    return "" if name == "1" else f"µ{name[1:]}" if name[:2] in ("um", "ur") else name


def _fault_line(rank: int, a: Answer) -> AnswerLine:
    """Return one answer; where its family is more probable than the name itself, the family first, and which members are open."""
    # a program that is rewritten loads no diagnosis
    from vcmm.learn.diagnosis.plain_words import cause_and_cure
    from vcmm.show.tables.diagnosis import open_members

    where = ", ".join(str(v) for v in a.where.values())
    name = f"{a.effect.replace('_', ' ')} {where}".strip()
    cause, confirm = cause_and_cure(a.effect, a.where, a.parameters)
    sizes = [
        f"{n} = {signed_value(float(e.value), K * float(e.u), _unit(e.unit))}"
        for n, e in a.parameters.items()
        if np.ndim(e.value) == 0
    ]
    opened = open_members(a)
    foreign = [n for n in a.cannot_be_told_from if n.split("[")[0] not in {m.effect for m in opened}]
    rivals = (
        f"or {', '.join(n.replace('_', ' ') for n in foreign)}, {percent(a.with_rivals)} together"
        if foreign
        else ""
    )
    sure = a.family_probability if opened else a.probability
    shapes = ", ".join(f"{m.effect.replace('_', ' ')} {percent(m.probability)}" for m in opened)
    return AnswerLine(
        f"{rank}. {f'{a.family} {where}'.strip() + f', written as {name}' if opened else name}",
        ", ".join(sizes) or "size not stated",
        coverage=f"k = {K:.0f}; its own variance is {whole_percent(a.share)} of the excess",
        limits=rivals,
        verdict=f"probability {percent(sure)}" + (f"; open is its shape: {shapes}" if opened else ""),
        kind="good" if sure >= 0.95 else "warning",
        because=cause,
        change=confirm,
        link="Effects missing from the machine model",
        numbers={"effect": a.effect, "share": a.share, "probability": a.probability}
        | ({"family": a.family, "family_probability": sure} if opened else {}),
        labels=("", "usually", "confirm by:"),
    )


def loop_answers(loop: LoopRecord) -> list[AnswerLine]:
    """Return whether the next part is within the allowed departure; and the effects missing from the machine model."""
    now, proof = np.abs(loop.cut.off) * 1e3, loop.proof
    was = f"this part {now.max():.2f} µm ({len(now)} measured points)"
    allowed = f"at most {proof.limit * 1e3:.2f} µm"
    if loop.refusal or proof.after is None:
        first = AnswerLine(
            "The next part", f"no program is written; {was}", limits=allowed, verdict="refused", kind="bad", because=loop.refusal,
            numbers={"met": False, "now_um": float(now.max())}, labels=("limits", "", ""),
        )  # fmt: skip
    else:
        open_words = loop.open_words or loop.setting
        verdict, kind = ("met", "good") if loop.is_met else ("not met", "bad")
        if proof.is_met and not loop.is_met:
            verdict, kind = "met by the cut, the real part open", "warning"
        first = AnswerLine(
            "The next part",
            f"at most {proof.after.largest * 1e3:.2f} µm; {was}",
            coverage=f"cut by {loop.program}, at {proof.after.worst}",
            limits=allowed,
            verdict=verdict,
            kind=kind,  # type: ignore[arg-type]
            because=open_words,
            numbers={"met": loop.is_met, "next_um": proof.after.largest * 1e3, "now_um": float(now.max())},
            labels=("limits", "open:", ""),
        )
    return [first, *diagnosis_answers(loop.diagnosis)]
