"""Candidates: every effect of the catalogue that this recording could show, as columns of the observation.

A family is one answer: an effect at one place (backlash of Y). Its options are the shapes and scanned values it may
have; each option is a group of columns, one per linear parameter element, in units of the typical amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.gaussian import thin_svd
from vcmm.core.declaration import reported_name
from vcmm.core.effect import Effect, parameter, parameter_fields, required, typical
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.constants import EXACT, RARER, UNSEEN
from vcmm.learn.diagnosis.instances import instances, missing_columns, where_of
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.sanity import dead_sensors
from vcmm.learn.diagnosis.scans import is_change, trials
from vcmm.physics import ALL
from vcmm.physics.structure.geometric_change import GeometricChange

PER_LABEL = {"event": "event", "clamp": "clamp"}  # a new draw for every value of this label
MOST_COLUMNS = 120
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Option:
    """columns (m, k) per typical amplitude; unit (k,): the typical amplitudes, canonical units; labels (k,).

    is_reversed: rows near a reversal count as still on the side they came from.
    """

    effect: Effect | None  # None: a shape without physics (localisation)
    columns: Array
    unit: Array
    labels: tuple[str, ...]
    log_prior: float
    is_reversed: bool = False

    @property
    def freedom(self) -> int:
        """Number of free numbers: columns, and scanned parameters."""
        if self.effect is None:
            return self.columns.shape[1]
        scans = sum(len(f.metadata["scan"]) > 1 or is_change(f) for f in parameter_fields(self.effect))
        return self.columns.shape[1] + scans


@dataclass(frozen=True, eq=False)
class Family:
    """One possible answer. `log_prior`: every effect name has the same prior, shared by its places."""

    name: str
    where: Mapping[str, str]
    options: tuple[Option, ...]
    log_prior: float = 0.0
    in_machine: bool = False

    @property
    def id(self) -> str:
        inner = ",".join(self.where.values())
        return f"{self.name}[{inner}]" if inner else self.name


@dataclass(frozen=True)
class Catalogue:
    """families; not_testable: effect name -> the columns that are missing; unseen: names that no row can show."""

    families: tuple[Family, ...]
    not_testable: Mapping[str, tuple[str, ...]]
    invisible: tuple[str, ...] = ()


def build_catalogue(problem: Problem, extra: Sequence[type[Effect]] = ()) -> Catalogue:
    """Return all families of the known effects (and of the caller's own effect classes)."""
    families: list[Family] = []
    absent: dict[str, tuple[str, ...]] = {}
    unseen: list[str] = []
    lost: list[Family] = []
    for kind in (*ALL, *extra):
        if not kind.diagnosis.is_named or not parameter_fields(kind) or not applies(kind, problem):
            continue
        of_kind, missing, still = _families_of_effect(kind, problem)
        lost += still
        for family in of_kind:
            families = _join_family(families, family)
        if not of_kind and missing:
            absent[kind.name] = tuple(sorted(missing))
        elif not of_kind and instances(kind, problem):
            unseen.append(reported_name(kind))
    families += _stale_calibration(problem)
    names = {f.name for f in families}
    absent = {name: columns for name, columns in absent.items() if name not in names}
    places = unseen_places([f for f in lost if f.name in names], families)
    unseen = [n for n in unseen if n not in names and n not in absent]
    return Catalogue(_shared_prior(families, problem), absent, (*unseen, *places))


def unseen_places(lost: Sequence[Family], visible: Sequence[Family]) -> tuple[str, ...]:
    """Return "squareness[B0Z]": axes, pairs, components and directions at which no family of a name is seen, others of it are."""
    places = {(f.name, first_place(f)) for f in visible}
    gone = dict.fromkeys((f.name, first_place(f)) for f in lost)
    return tuple(f"{name}[{place}]" for name, place in gone if place and (name, place) not in places)


def first_place(family: Family) -> str:
    """Return axis, pair, component or direction; not the sensor, which is the place of the cause."""
    return next(iter(family.where.values()), "")


def _stale_calibration(problem: Problem) -> list[Family]:
    """Return the family of a stale calibration, off by more than it claims: its own covariance, widened, as random effects."""
    machine = {item.id for item in problem.machine.inputs}
    stated = [columns for name, columns in problem.stated if name in machine]
    if not stated:
        return []
    left, size = thin_svd(np.concatenate(stated, axis=1))
    columns = (left * size)[:, size > EXACT * size[0]][:, :MOST_COLUMNS]
    k = columns.shape[1]
    option = Option(None, columns, np.ones(k), tuple(f"calibration[{i}]" for i in range(k)), 0.0)
    return [Family(GeometricChange.name, {"component": "all"}, (option,))]


def _join_family(families: list[Family], new: Family) -> list[Family]:
    """Join a second shape of a family at the same place: add its options; each class keeps half the weight."""
    for i, old in enumerate(families):
        if old.name == new.name and dict(old.where) == dict(new.where):
            half = float(np.log(0.5))
            options = [replace(o, log_prior=o.log_prior + half) for o in (*old.options, *new.options)]
            return [*families[:i], replace(old, options=tuple(options)), *families[i + 1 :]]
    return [*families, new]


def _shared_prior(families: Sequence[Family], problem: Problem) -> tuple[Family, ...]:
    """Return the families with equal priors of names; half of it for the whole (all styli) where there are parts, the rest shared by places."""
    out = []
    for family in families:
        same = [f for f in families if f.name == family.name]
        whole = [f for f in same if _is_whole(f)]
        if whole and len(same) > 1:
            prior = 0.5 if _is_whole(family) else 0.5 / (len(same) - 1)
        else:
            prior = 1.0 / len(same)
        if any(o.effect is not None and _is_rare(o.effect, problem) for o in family.options):
            prior *= RARER
        prior *= max(
            (o.effect.diagnosis.prior.share for o in family.options if o.effect is not None), default=1.0
        )
        out.append(replace(family, log_prior=float(np.log(prior))))
    return tuple(out)


def _is_rare(effect: Effect, problem: Problem) -> bool:
    prior, run = effect.diagnosis.prior, problem.run
    lacking = bool(prior.rare_without) and prior.rare_without not in run.labels
    return problem.recording.kind in prior.rare_in or lacking or prior.rare_with in run.columns


def _is_whole(family: Family) -> bool:
    return not family.where or family.where.get("component") == "all"


def _families_of_effect(kind: type[Effect], problem: Problem) -> tuple[list[Family], set[str], list[Family]]:
    """Return the families of one effect class, the columns that kept some from being tested, and places where nothing moves."""
    out: list[Family] = []
    missing: set[str] = set()
    still: list[Family] = []
    dead = dead_sensors(problem.recording)
    name = reported_name(kind)
    ids = {effect.id for effect in problem.machine.effects}
    for effect in instances(kind, problem):
        lacking = (*missing_columns(effect, problem.run), *(c for c in required(effect) if c in dead))
        if lacking:
            missing |= set(lacking)
            continue
        if effect.diagnosis.moves_together and any(f.where == where_of(effect) for f in out):
            continue
        options = [
            o
            for o in _options_at(effect, problem)
            if not effect.diagnosis.moves_together or _are_independent(o.columns)
        ]
        if options:
            out.append(Family(name, where_of(effect), tuple(options), 0.0, effect.id in ids))
        else:
            still.append(Family(name, where_of(effect), ()))
    return out, missing, still


def _are_independent(columns: Array) -> bool:
    """Return whether each of several columns (m, k) is visible and none is a combination of the others."""
    length = np.linalg.norm(columns, axis=0)
    return bool(length.all()) and np.linalg.matrix_rank(columns / length, tol=UNSEEN) == columns.shape[1] > 1


def _options_at(effect: Effect, problem: Problem) -> list[Option]:
    out = []
    rare = float(np.log(effect.diagnosis.prior.share))
    for start, share in _origins(effect, problem):
        for changes, weight in trials(start, problem.run):
            option = make_option(replace(start, **changes), problem, weight + share + rare)
            if option is not None:
                out += _reversal_options(option, start, problem)
    return out


def _reversal_options(option: Option, effect: Effect, problem: Problem) -> list[Option]:
    """Return options for rows near a reversal: a play of some um is taken up within as much travel, so rows nearer than a typical gap are
    still on the
    side they came from, and each of them counts with twice the gap. Both readings of such rows are options.
    """
    near = _near_reversal(effect, problem)
    if not near.any():
        return [option]
    option = replace(option, log_prior=option.log_prior + float(np.log(0.5)))
    return [option, _reverse_option(option, near)]


def _near_reversal(effect: Effect, problem: Problem) -> Mask:
    """Return the observations (m,) nearer to a reversal of the effect's axis than a typical gap; none for effects without one."""
    since = problem.run.columns.get(f"since_reversal_{getattr(effect, 'axis', '')}_mm")
    if not effect.about.gap_parameter or since is None:
        return np.zeros(problem.m, dtype=bool)
    return np.asarray(problem.per_observation(since) < typical(effect, effect.about.gap_parameter))


def _reverse_option(option: Option, near: Mask) -> Option:
    return replace(option, columns=option.columns * np.where(near, -1.0, 1.0)[:, None], is_reversed=True)


def rebuild_option(option: Option, problem: Problem, effect: Effect | None = None) -> Option | None:
    """Return the same option for the observations of `problem`, with another effect of its class where one is given."""
    effect = effect or option.effect
    if effect is None:
        stale = [o for f in _stale_calibration(problem) for o in f.options]
        return stale[0] if stale and option.labels[:1] == stale[0].labels[:1] else None
    made = make_option(effect, problem, option.log_prior)
    return (
        _reverse_option(made, _near_reversal(effect, problem))
        if made is not None and option.is_reversed
        else made
    )


def _origins(effect: Effect, problem: Problem) -> list[tuple[Effect, float]]:
    """Return the effect from the zero of its axes, and from the middle of their travels, where a structure is level."""
    names = {"origin": "axis", "other_origin": "other"}
    has = {f.name for f in fields(effect)}
    middle = {
        k: float(np.mean(problem.machine.axes[getattr(effect, a)].travel))
        for k, a in names.items()
        if k in has
    }
    if not any(middle.values()) or any(getattr(effect, k) for k in middle):
        return [(effect, 0.0)]
    half = float(np.log(0.5))
    return [(effect, half), (replace(effect, **cast(Any, middle)), half)]


def make_option(effect: Effect, problem: Problem, log_prior: float = 0.0) -> Option | None:
    """Return the columns of one effect with its scanned values set; None where it moves nothing or the model ends."""
    names = linear_parameters(effect)
    if not names or not effect.diagnosis.shows_at(effect, problem.run):
        return None
    try:
        columns = problem.columns(effect, names)
    except (ModelLimit, UsageError):
        return None
    labels, unit = _amplitudes(effect, names, columns)
    columns = columns * unit
    label = redraw_label(effect, problem.run)
    if label and not _is_one_cut_part(effect, problem, label):
        columns, labels, unit = _per_value(columns, labels, unit, problem, label)
    if not np.isfinite(columns).all() or not np.any(columns) or columns.shape[1] > MOST_COLUMNS:
        return None
    return Option(effect, columns, unit, labels, log_prior)


def redraw_label(effect: Effect, run: Run) -> str:
    """Return the label of which every value has its own copy of the parameters; "" for one copy."""
    wanted = [PER_LABEL[word] for word in effect.per.split(", ") if word in PER_LABEL]
    return next((label for label in wanted if label in run.labels), "")


def _is_one_cut_part(effect: Effect, problem: Problem, label: str) -> bool:
    """Return whether an effect acts on one part that has been cut, clamped once: it is a number, which the next part has too if it is
    clamped alike."""
    values, _ = problem.run.copies(label)
    return bool(effect.about.on_cut_part) and not problem.recording.measuring and len(values) == 1


def applies(kind: type[Effect], problem: Problem) -> bool:
    """Return whether there is an instrument, a tool, a stylus in this kind of recording."""
    recording = problem.recording
    if "instrument" in kind.per:
        return recording.kind in ("displacement", "length", "angle")
    if "tool" in kind.per.split(", ") or kind.about.needs_cut:
        return not recording.measuring
    if "stylus" in kind.per:
        return recording.kind == "probe"
    return True


def linear_parameters(effect: Effect) -> list[str]:
    """Return the parameters that act linearly here. Where typical sizes are declared, only those (a control's own correction has none)."""
    component = str(getattr(effect, "component", ""))
    chosen = [
        f.name
        for f in parameter_fields(effect)
        if not f.metadata["scan"]
        and not is_change(f)
        and (not f.metadata["only"] or component[:1] in f.metadata["only"])
    ]
    sized = [name for name in chosen if parameter(effect, name).metadata["typical"] is not None]
    return sized or chosen


def _amplitudes(effect: Effect, names: Sequence[str], columns: Array) -> tuple[tuple[str, ...], Array]:
    """Return label and typical amplitude of every column; parameters without one are scaled to 1 um rms over the recording."""
    labels: list[str] = []
    unit: list[float] = []
    for name in names:
        value = np.asarray(getattr(effect, name))
        labels += [name] if value.ndim == 0 else [f"{name}[{i}]" for i in range(value.size)]
        for _ in range(value.size):
            rms = float(np.sqrt(np.mean(columns[:, len(unit)] ** 2)))
            unit.append(_typical_or_scaled(effect, name, rms))
    return tuple(labels), np.array(unit)


def _typical_or_scaled(effect: Effect, name: str, rms: float) -> float:
    try:
        return typical(effect, name)
    except UsageError:
        return 1e-3 / rms if rms > 0 else 1.0


def _per_value(
    columns: Array, labels: tuple[str, ...], unit: Array, problem: Problem, label: str
) -> tuple[Array, tuple[str, ...], Array]:
    """Return one copy of the columns for every value of a label."""
    values, codes = problem.run.copies(label)
    code = codes[problem.recording.row]
    parts = [columns * (code == c)[:, None] for c in range(len(values))]
    names = tuple(f"{name}@{value}" for value in values for name in labels)
    return np.concatenate(parts, axis=1), names, np.tile(unit, len(values))
