"""Diagnosis: the result as a frozen value, and as the document of `vcmm diagnose --json`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.inputs import Input
from vcmm.core.readable import Readable, Reading
from vcmm.core.views import draw
from vcmm.learn.diagnosis.constants import EVEN_ODDS, SECURE
from vcmm.learn.diagnosis.discrepancy import FittedShape
from vcmm.learn.diagnosis.estimates import Estimate, estimates_json
from vcmm.learn.diagnosis.evidence import Detectable
from vcmm.learn.diagnosis.families import Kin
from vcmm.learn.diagnosis.holdout import HeldOut
from vcmm.learn.diagnosis.locate import Place
from vcmm.learn.diagnosis.log_mistakes import MISTAKE, Mistake
from vcmm.learn.diagnosis.mistakes import is_stale
from vcmm.learn.diagnosis.plain_words import plain_words
from vcmm.learn.diagnosis.result_parts import (
    CrossChecks,
    Failure,
    NextStep,
    Transfer,
    next_step_json,
    second_opinion_json,
    stable_json,
    transfer_json,
)
from vcmm.learn.diagnosis.statement_tests import Pull
from vcmm.learn.diagnosis.thinning import size_loss

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.learn.diagnosis.table_renewal import RenewedTables

STATUS_NOT_MODELLED = "named, not modelled"  # what is missing is known, and no file can hold it
VERDICTS = ("nothing missing", "explained", "partly explained", STATUS_NOT_MODELLED, "unexplained")
HALF = 0.5  # of a size: with a larger standard uncertainty its sign is not known with a coverage of 95 %
ZERO_PERCENT_SHARE, SPAN = 0.005, 100.0  # share that is printed as 0 %; upper over lower end of an interval
UM = 1e3  # mm to um; observations of kind angle are shown in urad


@dataclass(frozen=True, eq=False)
class Answer:
    """One missing effect. share of the excess energy; evidence in nats; fitted, inputs: for improve.improve_machine."""

    effect: str
    where: Mapping[str, str]
    parameters: Mapping[str, Estimate]
    probability: float
    share: float
    cannot_be_told_from: tuple[str, ...]
    evidence: float
    delta: float = 0.0
    implausible: bool = False
    fitted: Effect | None = None
    inputs: tuple[Input, ...] = ()
    remark: str = ""
    contained_in: tuple[
        str, ...
    ] = ()  # freer names that hold the answer as a special case and are improbable beside it
    rival_probability: float = (
        0.0  # of the names in cannot_be_told_from, and of the same name at other places
    )
    alias_probability: float = 0.0  # of the name and of all that repeats it exactly in this recording
    alias_of: str = ""  # the answer that this one repeats exactly, at another place
    withheld_because: str = ""  # why it is not written although it is probable; "" where nothing forbids it
    share_of_rows: float = 0.0  # of the excess energy of the rows as they are
    kin: Kin | None = None  # the family of the name: one physics in shapes of fewer or more numbers
    scanned_parameters: tuple[str, ...] = ()  # parameters that are no size: lags, distances, periods, moments
    impossible_because: str = ""  # why physics does not have its size; "" where it may
    mistake: str = (
        ""  # of a log_mistake: columns_exchanged, labels_exchanged, clock_offset ... (docs/diagnose.md)
    )
    renewed_tables: RenewedTables | None = (
        None  # of a calibration that is stale as a whole: its tables anew, where they predict rows held out
    )
    of_instrument: tuple[
        str, ...
    ] = ()  # errors of the instrument that repeat it exactly, as probable as all of the machine
    was_finding: bool = False  # a finding before the share of a mechanism that no catalogue holds was subtracted (see engine.discount_unknown_mechanism)

    @property
    def family(self) -> str:
        return self.kin.name if self.kin else self.effect

    @property
    def family_probability(self) -> float:
        """Probability of all members of the family together."""
        return max(self.probability, self.kin.probability if self.kin else 0.0)

    @property
    def with_rivals(self) -> float:
        """Probability of the name and of those it cannot be told from together."""
        return min(self.probability + self.rival_probability, 1.0)

    @property
    def improbable(self) -> bool:
        """Whether it is less probable than not, together with all that repeats it exactly, and its family is not secure."""
        if self.was_finding:
            return False
        return max(self.probability, self.alias_probability) < EVEN_ODDS and self.family_probability < SECURE

    def times(self, share: float) -> Answer:
        """Return the answer where only a share of its probability is left to it, and to what it cannot be told from."""
        return replace(
            self,
            probability=self.probability * share,
            rival_probability=self.rival_probability * share,
            alias_probability=self.alias_probability * share,
            kin=None if self.kin is None else self.kin.times(share),
        )

    def against(self, odds: float) -> Answer:
        """Return the answer beside one more hypothesis, which has these odds against it and everything it was compared with: of n hypotheses
        of the weights w a probability w1 / sum w becomes w1 / (sum w (1 + odds))."""
        return self.times(1.0 / (1.0 + odds))

    @property
    def is_undetermined(self) -> bool:
        """Whether its size may be anything: no size is known to better than half of itself, or next to nothing is explained by it and
        the interval spans orders of magnitude.
        """
        if is_stale(self.effect, self.where.get("component")):
            return False
        sizes = [e for name, e in self.parameters.items() if name not in self.scanned_parameters and e.value]
        if sizes and all(e.u > HALF * abs(e.value) for e in sizes):
            return True
        ends = [np.abs(e.interval95) for e in self.parameters.values() if np.prod(np.sign(e.interval95)) > 0]
        return self.share < ZERO_PERCENT_SHARE and any(float(e.max()) > SPAN * float(e.min()) for e in ends)

    @property
    def doubtful(self) -> bool:
        """Whether it is a candidate and not a finding."""
        return (
            self.improbable or self.is_undetermined or bool(self.withheld_because or self.impossible_because)
        )

    @property
    def id(self) -> str:
        inner = ",".join(str(v) for v in self.where.values())
        return f"{self.effect}[{inner}]" if inner else self.effect


@dataclass(frozen=True)
class Unknown:
    """Physics outside the catalogue: a proposal of where and what shape, not a name. rms in mm or rad."""

    covariates: tuple[str, ...]
    description: str
    rms: float
    direction: str = "normal"
    pair: bool = False  # the two first covariates act together
    is_drawable: bool = True  # can its shape be shown over them?
    shape: FittedShape | None = None
    formula: str = ""
    gain: float = 0.0  # nats of the formula on rows never fitted


@dataclass(frozen=True)
class Fit:
    """rms (mm or rad) of all rows as they are, the nuisance refitted: with the machine as it was, and with the machine that
    is written; candidates: with all considered terms. noise: estimated scatter. held_out: folds.
    """

    before: float
    after: float
    noise: float
    held_out: tuple[HeldOut, ...]
    candidates: float = float("nan")


@dataclass(frozen=True, eq=False)
class Diagnosis(Readable):
    """Result of `diagnose_recording`; see contract section 5 for the meaning of every part."""

    verdict: str
    answer: tuple[Answer, ...]
    unknown: Unknown | None
    location: tuple[Place, ...]
    mistake: Mistake | None
    noise_scale: float
    noise_findings: tuple[str, ...]
    fit: Fit
    not_testable: Mapping[str, tuple[str, ...]]
    invisible: tuple[str, ...]
    detectable: tuple[Detectable, ...]
    next_measurement: tuple[NextStep, ...]
    threshold: float
    seed: int
    angle: bool = False
    warnings: tuple[str, ...] = ()
    map: tuple[Place, ...] = ()  # evidence over every covariate, best direction each; p is not computed
    chance: float = 0.0  # the largest score of 99 % of null recordings
    reasons: tuple[str, ...] = ()  # why the verdict is "partly explained" or "unexplained"
    pulls: tuple[Pull, ...] = ()  # of what the machine file states of itself
    search_counts: tuple[int, int] = (0, 0)  # observations in which names were searched, and all of them
    recorded_count: int = (
        0  # observations that the recording held, where `all of them` were chosen from more; else 0
    )
    failures: tuple[Failure, ...] = ()  # steps after the names that did not succeed
    checks: CrossChecks | None = None  # parts of the rows, and a second opinion
    transfer: tuple[Transfer, ...] = ()  # what the file from one recording leaves of the others
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        names = [f"{a.effect} {' '.join(map(str, a.where.values()))}".strip() for a in self.found]
        of = "".join(f", {n} (p = {a.probability:.2f})" for n, a in zip(names[:4], self.found))
        return f"<Diagnosis: {self.verdict}{of}>"

    def plot(self, ax: Any = None) -> Axes:
        """Plot names found and candidates, with their probability."""
        axes: Axes = draw(self, ax)
        return axes

    @property
    def found(self) -> tuple[Answer, ...]:
        """The answers that are more probable than not, their rivals included."""
        return tuple(a for a in self.answer if not a.doubtful)

    @property
    def candidates(self) -> tuple[Answer, ...]:
        """The other answers."""
        return tuple(a for a in self.answer if a.doubtful)


def diagnosis_json(d: Diagnosis) -> dict[str, Any]:
    """Return the body of vcmm.diagnosis/1 (contract section 5); numbers that are not finite become None."""
    micro = 1e6 if d.angle else UM
    body = {
        "schema": "vcmm.diagnosis/1",
        "verdict": d.verdict,
        "verdict_reasons": list(d.reasons),
        "searched": _search_extent(d),
        "answer": [_answer(a) for a in d.answer],
        "unknown": None if d.unknown is None else _unknown(d.unknown, micro),
        "location": [_place(p) for p in d.location],
        "mistake": _mistake(d.mistake) if d.mistake and d.mistake.effect == MISTAKE else None,
        "noise": {"scale_um": d.noise_scale * micro, "findings": list(d.noise_findings)},
        "fit": _fit(d.fit, micro),
        # six digits: the sixteenth goes with where the arrays of a process lie in memory, to which linear algebra by blocks is not blind
        "calibration_pulls": [{"input": p.input, "pull": float(f"{p.pull:.6g}")} for p in d.pulls],
        "not_testable": sorted(d.not_testable),
        "invisible": sorted(d.invisible),
        "detectable": [_detectable(x, micro) for x in d.detectable],
        "next_measurement": [next_step_json(n) for n in d.next_measurement],
        "stable": stable_json(d.checks),
        "second_opinion": second_opinion_json(d.checks),
        "transfer": [transfer_json(t, micro) for t in d.transfer],
        "improved_machine": None,
        "failed": failures_json(d.failures),
    }  # fmt: skip
    finite: dict[str, Any] = _finite(with_urad_keys(body) if d.angle else body)
    return finite


def failures_json(failed: Sequence[Failure]) -> list[dict[str, str]]:
    return [{"step": f.step, "text": f.text} for f in failed]


def _search_extent(d: Diagnosis) -> dict[str, Any]:
    """Return in how many observations names were searched, of how many that were fitted, of how many that were recorded, and the factor by
    which an effect must be larger than with all of them to be found.
    """
    searched, of = d.search_counts
    recorded = d.recorded_count or of
    return {
        "observations": searched,
        "of": of,
        "recorded": recorded,
        "loss": size_loss(searched, recorded) if searched else 1.0,
    }


def with_urad_keys(body: dict[str, Any]) -> dict[str, Any]:
    """Return the document with the unit stated: beside every ..._um of the contract, which holds urad here, the key ..._urad."""

    def add_units(value: Any) -> Any:
        if isinstance(value, list):
            return [add_units(v) for v in value]
        if not isinstance(value, dict):
            return value
        numbers = {k: add_units(v) for k, v in value.items()}
        angles = {f"{k[:-3]}_urad": v for k, v in numbers.items() if k.endswith("_um")}
        return {**numbers, **angles, "unit": "urad"} if angles else numbers

    return {**add_units(body), "unit": "urad"}


def _answer(a: Answer) -> dict[str, Any]:
    return {
        "effect": a.effect,
        "where": dict(a.where),
        "parameters": estimates_json(a.parameters),
        "probability": a.probability,
        "family": a.family,
        "family_probability": a.family_probability,
        "members": _members(a),
        "share": a.share,
        "cannot_be_told_from": list(a.cannot_be_told_from),
        "probability_with_rivals": a.with_rivals,
        "contained_in": list(a.contained_in),
        "evidence_nats": a.evidence,
        "implausibly_large": a.implausible,
        "remark": a.remark,
        "doubtful": a.doubtful,
        "share_of_rows": a.share_of_rows,
        "alias_of": a.alias_of or None,
        "not_written_because": a.withheld_because or a.impossible_because or None,
        "text": plain_words(a.effect, a.where, a.parameters),
    } | ({"mistake": a.mistake} if a.mistake else {})


def _members(a: Answer) -> list[dict[str, Any]]:
    """Return the names of the family that are open, the most probable first; the answer among them."""
    if a.kin is None:
        return [{"effect": a.effect, "where": dict(a.where), "probability": a.probability}]
    return [{"effect": m.effect, "where": dict(m.where), "probability": m.probability} for m in a.kin.members]


def _mistake(m: Mistake) -> dict[str, Any]:
    return {"component": m.component, "what": m.what, "cannot_be_told_from": list(m.rivals)}


def _unknown(x: Unknown, micro: float) -> dict[str, Any]:
    out: dict[str, Any] = {
        "covariates": list(x.covariates),
        "description": x.description,
        "rms_um": x.rms * micro,
        "direction": x.direction,
        "formula": x.formula or None,
        "formula_gain_nats": x.gain if x.formula else None,
        "status": "proposal, not physics",
        "shape": None if x.shape is None else _shape(x.shape, micro),
    }
    return out


def _shape(s: FittedShape, micro: float) -> dict[str, Any]:
    """Return the curve over one covariate, or the map over two: [i][j] at the i-th value of the first and the j-th of the second."""
    grid = {"over": list(s.names), s.names[0]: s.x.tolist()}
    if s.y is not None:
        grid[s.names[1]] = s.y.tolist()
    return {**grid, "value_um": (s.value.T * micro).tolist(), "u_um": (s.u.T * micro).tolist()}


def _place(p: Place) -> dict[str, Any]:
    return {"covariate": p.covariate, "direction": p.direction, "p": p.p, "text": p.text}


def _detectable(x: Detectable, micro: float) -> dict[str, Any]:
    return {"effect": x.effect, "where": x.where, "amplitude_um": x.amplitude * micro}


def _fit(f: Fit, micro: float) -> dict[str, Any]:
    folds = [
        {
            "fold": h.fold,
            "rms_before_um": h.rms_before * micro,
            "rms_after_um": h.rms_after * micro,
            "effect_energy_left": h.effect_energy_left,
            "log_score_gain_nats": h.gain,
        }
        for h in f.held_out
    ]
    return {
        "rms_before_um": f.before * micro,
        "rms_after_um": f.after * micro,
        "candidates_rms_um": f.candidates * micro,
        "noise_um": f.noise * micro,
        "held_out": folds,
    }


def _finite(x: Any) -> Any:
    if isinstance(x, dict):
        return {k: _finite(v) for k, v in x.items()}
    if isinstance(x, list):
        return [_finite(v) for v in x]
    if isinstance(x, float):  # numpy floats are floats
        return float(x) if math.isfinite(x) else None
    return x
