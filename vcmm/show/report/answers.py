"""The answer of a job, one line per characteristic: value, U, limits, decision, largest contributor, what to change.

Every report, sheet, terminal and notebook shows these lines first, from here alone. They hold words and numbers, no measuring.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from vcmm.show.report.text import DASH, MINUS, as_written, escape
from vcmm.show.report.trade_words import contributor, what_to_change

Kind = Literal["good", "warning", "bad", "muted"]
FINE_UNITS = {"mm": ("µm", 1e3), "rad": ("µrad", 1e6)}
STATE: dict[str, Kind] = {"conforms": "good", "undecided": "warning", "does not conform": "bad"}
# of U: drawn ends scatter by about 1 %; a normal law shifted by 5 % of U loses 0.1 % of coverage
ABOUT_ITS_MIDDLE = 0.05
K = 2.0  # of what is stated by a standard error alone
LEAST_U = 5e-4  # µm, µrad: half a nanometre, below which U is printed as zero and owns no contributors
LEAST_SHOWN = 0.005  # of u²: what is less owns nothing worth a word


@dataclass(frozen=True)
class AnswerLine:
    """One answer. result: value with U and unit; coverage: k or p; because: largest contributor; change: what reduces U.

    link: heading of the page with details; numbers: the values shown, as data (JSON); labels: words before limits, because and change.
    """

    name: str
    result: str
    coverage: str = ""
    limits: str = ""
    verdict: str = ""
    kind: Kind = "muted"
    because: str = ""
    change: str = ""
    link: str = ""
    numbers: Mapping[str, Any] = field(default_factory=dict)
    labels: tuple[str, str, str] = ("limits", "mostly", "to improve:")


def places_of(expanded: float) -> int:
    """Return the decimals of two significant digits of U (JCGM 100, 7.2.6): 0.756 -> 2, 12.3 -> 0."""
    return max(0, 1 - int(f"{expanded:.1e}".split("e")[1]))


def signed_value(value: float, expanded: float, unit: str, sign: str = "") -> str:
    """Return -0.37 ± 0.12 µm: two significant digits of U."""
    places = places_of(expanded) if expanded > 0 and math.isfinite(expanded) else 2
    half = f" ± {expanded:.{places}f}" if expanded > 0 and math.isfinite(expanded) else ""
    return f"{value + 0.0:{sign}.{places}f}{half} {unit}".replace("-", MINUS)


def value_and_U(value: float, expanded: float, unit: str, small: bool = False) -> tuple[str, str]:
    """Return value in mm (degrees) and U in µm (µrad): U with two significant digits, the value to the same place.

    29.99998 mm, 0.756 µm -> "29.99998 mm", "0.76 µm"; small: the value too in µm (of a form, which is 0 on the drawing).
    """
    word, scale = FINE_UNITS[unit]
    nothing = math.isfinite(expanded) and expanded * scale < LEAST_U
    if small and math.isfinite(expanded) and not nothing:
        places = places_of(expanded * scale)
        written = f"{value * scale + 0.0:.{places}f} {word}".replace("-", MINUS)
        return written, f"{expanded * scale:.{places}f} {word}"
    if not math.isfinite(expanded) or nothing:
        written = (
            f"{value * scale + 0.0:.3f} {word}"
            if small
            else f"{value:.5f} mm"
            if unit == "mm"
            else f"{math.degrees(value):.6f}°"
        )
        return written.replace("-", MINUS), DASH if not math.isfinite(expanded) else f"0.000 {word}"
    text = f"{expanded * scale:.{places_of(expanded * scale)}f} {word}"
    large = expanded if unit == "mm" else math.degrees(expanded)
    shown = value if unit == "mm" else math.degrees(value)
    return f"{shown + 0.0:.{min(9, places_of(large))}f}{' mm' if unit == 'mm' else '°'}".replace(
        "-", MINUS
    ), text


def answer_of(c: Any) -> AnswerLine:
    """Return the line of a CharacteristicResult."""
    result, coverage = _result_and_coverage(c)
    if math.isfinite(c.stated[0]) and not getattr(c, "coverage_shown", True):
        coverage += ", coverage not demonstrated"  # U beside p reads as a claim
    decided = c.decision
    p = None if decided is None else decided.p_conform
    verdict = "" if decided is None else decided.text
    if p is not None:
        verdict += f", {percent(p)}"
    owner: Any = max(c.budget, key=lambda line: line.u, default=None)
    is_known = owner is not None and c.u * FINE_UNITS[c.unit][1] >= LEAST_U and owner.share > LEAST_SHOWN
    return AnswerLine(
        c.name, result, coverage=coverage, limits=limits_text(c), verdict=verdict, kind=STATE.get(verdict.split(",")[0], "muted"),
        because=f"{contributor(owner)}, {whole_percent(owner.share)} of\u00a0u²" if is_known else "",
        change=_what_helps(c, owner) if is_known else "",
        link=f"{c.name} ({c.type})",
        numbers={
            "name": c.name, f"value_{c.unit}": c.value, f"U_{c.unit}": c.stated[0], "k": c.stated[1], "p": c.p,
            f"interval_{c.unit}": list(c.interval), f"tolerance_{c.unit}": c.tolerance, "decision": decided and decided.text,
            "p_conform": p, "contributor": owner.input if is_known else None, "share": owner.share if is_known else None,
        },
    )  # fmt: skip


def _what_helps(c: Any, owner: Any) -> str:
    """Return what reduces U; where U is not bounded, why; where all of the interval lies outside the limits, that no smaller U helps."""
    outside = how_far_outside(c)
    if outside > 0:
        word, scale = FINE_UNITS[c.unit]
        return f"the value itself, {outside * scale:.3g} {word} outside its limits; no smaller U helps"
    if math.isfinite(c.stated[0]) or not getattr(c, "why_not_shown", ""):
        return what_to_change(owner)
    return str(c.why_not_shown)


def how_far_outside(c: Any) -> float:
    """Return how far the value lies outside its limits where the whole interval does, mm or rad; else 0."""
    low, high = c.tolerance or (-math.inf, math.inf)
    if low <= c.interval[1] and c.interval[0] <= high:
        return 0.0
    return float(max(low - c.value, c.value - high, 0.0))


def whole_percent(share: float) -> str:
    """Return 95 %, with a space that no line breaks at (ISO 80000-1)."""
    return f"{100 * share:.0f}\u00a0%"


def percent(p: float) -> str:
    """Return a probability: "99.9 %", never rounded up to certainty: "> 99.9 %"."""
    if p > 0.9995:
        return ">\u00a099.9\u00a0%"
    return "<\u00a00.1\u00a0%" if p < 0.0005 else f"{100 * p:.1f}\u00a0%"


def _result_and_coverage(c: Any) -> tuple[str, str]:
    """Return value ± U with k, or both of them with p where the interval does not lie about the value."""
    expanded, k = c.stated
    value, interval_text = value_and_U(c.value, expanded, c.unit, small=c.nominal == 0)
    if not math.isfinite(expanded):
        return f"{value}, U unbounded", f"p = {whole_percent(c.p)}"
    if is_about_value(c):
        factor = (
            "known bias in U, "
            if c.bias_in_U
            else f"k = {k:.2f}, "
            if math.isfinite(k) and expanded * FINE_UNITS[c.unit][1] >= LEAST_U
            else ""
        )
        return f"{value} ± {interval_text}", f"{factor}p = {whole_percent(c.p)}"
    word, scale = FINE_UNITS[c.unit]
    digits = places_of(expanded * scale)
    ends = [f"{(x - c.nominal) * scale + 0.0:.{digits}f}".replace("-", MINUS) for x in c.interval]
    from_nominal = "" if c.nominal == 0 else " from nominal"
    return (
        f"{value}, U = {interval_text}",
        f"p = {whole_percent(c.p)}: {ends[0]} … {ends[1]} {word}{from_nominal}",
    )


def is_about_value(c: Any) -> bool:
    """Return whether value ± U is the interval, except for the scatter of simulated ends."""
    middle = sum(c.interval) / 2
    return abs(middle - c.value) <= ABOUT_ITS_MIDDLE * c.stated[0] and c.half_width is None


def limits_text(c: Any) -> str:
    """Return the limits as on the drawing: "29.990 … 30.011 mm", "at most 10 µm"; empty without."""
    if c.tolerance is None:
        return ""
    low, high = c.tolerance
    word, scale = FINE_UNITS[c.unit]
    if c.nominal == 0 and not (math.isfinite(low) and low != 0):
        return f"at most {as_written(high * scale)} {word}"
    turn, name = (1.0, " mm") if c.unit == "mm" else (180.0 / math.pi, "°")
    if not math.isfinite(low):
        return f"at most {as_written(high * turn)}{name}"
    if not math.isfinite(high):
        return f"at least {as_written(low * turn)}{name}"
    both = [f"{round(x * turn, 6) + 0.0:.10g}" for x in (low, high)]
    places = max(len(x.partition(".")[2]) for x in both)
    return f"{low * turn + 0.0:.{places}f} … {high * turn + 0.0:.{places}f}{name}".replace("-", MINUS)


def answers_block(lines: Sequence[AnswerLine], name: str = "Answer") -> str:
    """Return the lines at the top of a page, as a list."""
    if not lines:
        return ""
    return f'<ol class="answers" aria-label="{escape(name)}">{"".join(map(_item, lines))}</ol>'


def _item(line: AnswerLine) -> str:
    data = json.dumps(_finite(line.numbers), separators=(",", ":"), ensure_ascii=False)
    title = f'<a data-to="{escape(line.link)}">{escape(line.name)}</a>' if line.link else escape(line.name)
    pill = f'<span class="badge {line.kind}">{escape(line.verdict)}</span>' if line.verdict else ""
    limits = f"<small>{escape(_labelled_limits(line))}</small>" if line.limits else ""
    because = f"<small>{escape(line.labels[1])}</small> {escape(line.because)}" if line.because else ""
    change = f"<small>{escape(line.labels[2])}</small> {escape(line.change)}" if line.change else ""
    why = "<br>".join(x for x in (because, change) if x)
    return (
        f'<li data-answer="{escape(data)}"><p class="name">{title}</p>'
        f'<p class="value">{escape(line.result)} <small>{escape(line.coverage)}</small></p>'
        f'<p class="verdict">{pill} {limits}</p><p class="why">{why}</p></li>'
    )


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def in_one_line(line: AnswerLine) -> str:
    """Return the line for a repr: value ± U (k), decision (probability)."""
    coverage = f" ({line.coverage})" if line.coverage else ""
    return f"{line.result}{coverage}" + (f", {line.verdict}" if line.verdict else "")


def answer_text(lines: Iterable[AnswerLine]) -> str:
    """Return the lines at the top of a page for the terminal, two text lines each."""
    out = []
    for line in lines:
        limits = f"; {_labelled_limits(line)}" if line.limits else ""
        verdict = f": {line.verdict}" if line.verdict else ""
        out.append(f"{line.name}: {in_one_line(_bare(line))}{limits}{verdict}")
        because = f"{line.labels[1]} {line.because}".strip() if line.because else ""
        change = f"{line.labels[2]} {line.change}".strip() if line.change else ""
        if because or change:
            out.append("    " + "; ".join(x for x in (because, change) if x))
    return "\n".join(out)


def _labelled_limits(line: AnswerLine) -> str:
    """Return limits 29.990 … 30.011 mm; "at most 10 µm" unchanged."""
    return line.limits if line.limits.startswith("at ") else f"{line.labels[0]} {line.limits}".strip()


def _bare(line: AnswerLine) -> AnswerLine:
    return AnswerLine(line.name, line.result, line.coverage)
