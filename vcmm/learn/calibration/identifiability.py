"""Find the errors that recordings identify, and the combinations of errors that change no reading, in words.

The test uses a prior that knows next to nothing (every error 5 times its usual size), so that
smoothness does not answer in place of readings. An error is identified where the readings bring its standard uncertainty
below a fifth of that prior, at every node; a squareness or location that only the prior of the other errors determines is not (its u
grows with that prior, and is large in the fit). Unidentified combinations are searched among the few shapes that people have words for: slope, bow
and S of every curve, and squareness.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.axes import axis_of, is_location, is_rotary, unit_vector
from vcmm.core.run import Array
from vcmm.learn.calibration.evidence import NormalEquations, append_identity
from vcmm.learn.calibration.model import Curve, ErrorModel
from vcmm.learn.calibration.prior import BROAD, FAR_TIMES_USUAL, prior, scale_factor, usual
from vcmm.learn.calibration.solve import condition_on_prior, conditioned_factor

WORSE = 0.2  # u after over u before: below, an error is identified
WIDER = 4.0  # times: the u of an angle that readings tell follows a prior so much wider less than half
OPEN = 0.25  # variance after over before, of a combination that is not identified
SHAPES, ANGLE_SHAPE, FINER = ("slope", "bow", "S shape"), "angle", "finer shape"
HARMONICS, LEFT = (
    ("once-per-turn", "twice-per-turn"),
    0.1,
)  # rms of a wave that the convention nearly takes away
LEAST_SHARE = 0.12  # share of a member of a combination, of its largest
MOST_DIRECTIONS, BRIEF = 12, 3


@dataclass(frozen=True)
class Combination:
    """members: error name -> shape and share of it in one change that no reading shows; text: the same in words."""

    members: tuple[tuple[str, str, float], ...]
    text: str

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(name for name, _, _ in self.members))

    @property
    def brief(self) -> str:
        """The text without amounts, four members at most."""
        parts = [n if s == ANGLE_SHAPE else f"{s} of {n}" for n, s, _ in self.members]
        more = f" and {len(parts) - 4} more" if len(parts) > 4 else ""
        return f"{', '.join(parts[:4])}{more}: cannot be told apart; {hint(self.names[0])}"


@dataclass(frozen=True, eq=False)
class Identifiability:
    """names that are identified; combinations that are not; ratio: name -> u after over u before; condition number."""

    names: tuple[str, ...]
    combinations: tuple[Combination, ...]
    ratio: dict[str, float]
    condition: float

    def briefly(self) -> list[str]:
        """Return the errors that are not identified in a few lines: errors by themselves in one, then combinations, one of slopes and one
        of angles first."""
        single = [c for c in self.combinations if len(c.names) == 1]
        coarse = [c.names[0] for c in single if c.members[0][1] == FINER]
        alone = [c.names[0] for c in single if c.names[0] not in coarse]
        several = sorted((c for c in self.combinations if len(c.names) > 1), key=lambda c: len(c.names))
        for shape in (ANGLE_SHAPE, SHAPES[0]):
            first = [c for c in several if shape in {s for _, s, _ in c.members[:3]}][:1]
            several = first + [c for c in several if c not in first]
        out = (
            [f"{', '.join(alone)}: no reading depends on {'it' if len(alone) == 1 else 'them'}"]
            if alone
            else []
        )
        if coarse:
            out.append(
                f"{', '.join(coarse)}: known in the coarse shape only; read more positions along the axis"
            )
        out += [c.brief for c in several[:BRIEF]]
        return out + ([f"and {len(several) - BRIEF} more such combinations"] if len(several) > BRIEF else [])

    def document(self) -> list[dict[str, object]]:
        """Return the errors that are not identified, for JSON documents."""
        return [{"combination": list(c.names), "text": c.text} for c in self.combinations]


def identify(reduced: NormalEquations, covariance: Array | None = None) -> Identifiability:
    """See the head of this file; reduced: the readings with the weights of the covariance. covariance (size, size): of the fit."""
    model = reduced.model
    factor = broad_factor(model)
    _, after = condition_on_prior(reduced, append_identity(factor, len(reduced.b)))
    after = after[: model.size, : model.size]
    before = factor @ factor.T
    ratio = {
        name: float(np.sqrt((np.diag(after)[part] / np.diag(before)[part]).max()))
        for name, part in model.slices.items()
    }
    guessed = [] if covariance is None else _by_the_prior(reduced, factor, ratio, covariance)
    names = tuple(n for n in model.names if ratio[n] < WORSE and n not in guessed)
    doubtful = [n for n in model.names if n not in names and n not in guessed]
    groups = combinations(model, before, after, doubtful)
    names_told = {n for c in groups for n in c.names}
    untold = [*guessed, *(n for n in doubtful if n in model.pairs and n not in names_told)]
    groups = (*groups, *_beside(model, before, after, untold))
    return Identifiability(names, groups, ratio, _condition(reduced, factor, names))


def _by_the_prior(
    reduced: NormalEquations, factor: Array, ratio: Mapping[str, float], covariance: Array
) -> list[str]:
    """Return squareness and location errors that only the prior of the other errors determines: their u grows as that does, and in the fit, where
    the readings chose the sizes of the other errors, it is as large as that of errors that are not identified.
    """
    model = reduced.model
    rows = {p: model.slices[p].start for p in model.pairs}
    had = (factor**2).sum(axis=1)
    near = [p for p, i in rows.items() if ratio[p] < WORSE and covariance[i, i] > WORSE**2 * had[i]]
    if not near:
        return []
    wide = WIDER * factor
    _, half = conditioned_factor(reduced, append_identity(wide, len(reduced.b)))
    after = (half**2).sum(axis=1)
    return [p for p in near if np.sqrt(after[rows[p]] / had[rows[p]]) / WIDER > ratio[p] / 2]


def _beside(model: ErrorModel, before: Array, after: Array, names: Sequence[str]) -> list[Combination]:
    """Return for each name the remaining combination: errors that change with it and show in no reading."""
    shapes, labels = _shapes(model, model.names)
    look = np.linalg.pinv(shapes)
    had = np.sqrt(np.diag(look @ before @ look.T))
    out = []
    for name in names:
        row = model.slices[name].start
        amount = look @ after[:, row] / np.sqrt(after[row, row])
        share = np.abs(amount) / had
        at = labels.index((name, ANGLE_SHAPE))
        order = [at, *(int(i) for i in np.argsort(-share) if i != at)]
        members = [
            (*labels[i], float(amount[i])) for i in order if i == at or share[i] > LEAST_SHARE * share[at]
        ]
        out.append(Combination(tuple(members), _several(members)))
    return out


def broad_factor(model: ErrorModel, share: float = 0.35) -> Array:
    """Factor of the prior that knows next to nothing; share: correlation length in parts of the travel.

    It is smooth whatever runs between the nodes: what readings identify is no question of the interpolation.
    """
    model = ErrorModel(tuple(replace(c, kind="spline") for c in model.curves), model.pairs)
    lengths = {c.component: share * float(c.nodes[-1] - c.nodes[0]) for c in model.curves}
    out = scale_factor(prior(model, lengths), BROAD * usual(model))
    for pair in model.pairs:
        out[model.slices[pair]] *= BROAD / FAR_TIMES_USUAL
    return out


def _condition(reduced: NormalEquations, factor: Array, names: Sequence[str]) -> float:
    """Return the ratio of the best to the worst determined number among the identified ones, in units of the broad prior."""
    rows = np.concatenate(
        [np.arange(reduced.model.size)[reduced.model.slices[n]] for n in names] or [np.zeros(0, int)]
    )
    if not len(rows):
        return float("inf")
    _, after = condition_on_prior(reduced, append_identity(factor, len(reduced.b)))
    before = (factor @ factor.T)[np.ix_(rows, rows)]
    size, ways = np.linalg.eigh(before)
    kept = size > 1e-6 * size[-1]
    half = ways[:, kept] / np.sqrt(size[kept])
    left = np.linalg.eigvalsh(half.T @ after[np.ix_(rows, rows)] @ half)
    return float(np.sqrt(left[-1] / max(left[0], 1e-300)))


def combinations(
    model: ErrorModel, before: Array, after: Array, doubtful: Sequence[str]
) -> tuple[Combination, ...]:
    """Return the changes that no reading shows, each with as few errors as can be; only errors that are not identified."""
    shapes, labels = _shapes(model, doubtful)
    if not labels:
        return ()
    look = np.linalg.pinv(shapes)
    had, left = look @ before @ look.T, look @ after @ look.T
    lower = np.linalg.cholesky(had + 1e-12 * np.trace(had) * np.eye(len(had)))
    inner = np.linalg.solve(lower, np.linalg.solve(lower, left).T)
    size, ways = np.linalg.eigh((inner + inner.T) / 2)
    free = ways[:, size > OPEN]
    groups = [_members(vector, labels, lower) for vector in _sparse(free)]
    return tuple(_combinations(groups, doubtful))


def _shapes(model: ErrorModel, names: Sequence[str]) -> tuple[Array, list[tuple[str, str]]]:
    """Return slope, bow and S of each curve as far as the convention leaves them, of unit rms, (size, k); squareness."""
    columns, labels = [], []
    for curve in model.curves:
        if curve.component in names:
            for shape, column in zip(*_curve_shapes(curve)):
                full = np.zeros(model.size)
                full[model.slices[curve.component]] = column
                columns.append(full)
                labels.append((curve.component, shape))
    for pair in model.pairs:
        if pair in names:
            full = np.zeros(model.size)
            full[model.slices[pair]] = 1.0
            columns.append(full)
            labels.append((pair, ANGLE_SHAPE))
    return (np.stack(columns, axis=1) if columns else np.zeros((model.size, 0))), labels


def _curve_shapes(curve: Curve) -> tuple[list[str], list[Array]]:
    if curve.rotary:
        return _turning_shapes(curve)
    x = (curve.nodes - curve.nodes.mean()) / (curve.nodes[-1] - curve.nodes[0]) * 2
    powers = np.linalg.qr(np.vander(x, 4, increasing=True))[0][:, 1:]
    powers = powers * np.sqrt(len(x)) * np.sign(powers[-1])
    if curve.reversal:
        return ["level", *SHAPES[:2]], [np.ones(len(x)), powers[:, 0], powers[:, 1]]
    first = 1 if curve.straightness else 0
    last = min(3, powers.shape[1])  # a line of two nodes has its slope alone
    return list(SHAPES[first:last]), [curve.projector @ powers[:, i] for i in range(first, last)]


def _turning_shapes(curve: Curve) -> tuple[list[str], list[Array]]:
    """Return cosine and sine of the first harmonics, as far as the convention leaves them."""
    names, columns = [], []
    for order, word in enumerate(HARMONICS, start=1):
        for part, wave in (("cosine", np.cos), ("sine", np.sin)):
            column = curve.projector @ wave(order * curve.nodes)
            size = float(np.sqrt((column**2).mean()))
            if size > LEFT:
                names.append(f"{word} {part}")
                columns.append(column / size)
    return names, columns


def _sparse(free: Array) -> list[Array]:
    """Return vectors that span the same space (k, d), each around the freest of the remaining numbers."""
    out, rest = [], free @ free.T
    for _ in range(free.shape[1]):
        pivot = int(np.diag(rest).argmax())
        vector = rest[:, pivot] / np.sqrt(max(rest[pivot, pivot], 1e-300))
        out.append(vector)
        rest = rest - np.outer(vector, vector)
    return out


def _members(vector: Array, labels: Sequence[tuple[str, str]], lower: Array) -> list[tuple[str, str, float]]:
    """Return (error, shape, amount in mm or rad) of the members that matter, largest share of its prior first."""
    amount = lower @ vector
    share = amount / np.sqrt((lower**2).sum(axis=1))
    order = np.argsort(-np.abs(share))
    top = float(np.abs(share).max())
    return [(*labels[i], float(amount[i])) for i in order if abs(share[i]) > LEAST_SHARE * top]


def _combinations(
    groups: Sequence[list[tuple[str, str, float]]], doubtful: Sequence[str]
) -> list[Combination]:
    """Return one entry per error that is alone (all its free shapes), one per combination of several; the rest in one word."""
    alone: dict[str, list[tuple[str, str, float]]] = {}
    several: list[Combination] = []
    for members in groups:
        if len({name for name, _, _ in members}) == 1:
            alone.setdefault(members[0][0], []).extend(members)
        else:
            several.append(Combination(tuple(members), _several(members)))
    out = [Combination(tuple(m), _alone(name, m)) for name, m in alone.items()]
    names = {n for c in [*out, *several] for n in c.names}
    silent = [n for n in doubtful if n not in names and n[1] != "0"]  # curves
    out += [
        Combination(
            ((n, FINER, 1.0),),
            f"{n}: known in its coarse shape only; finer shapes are not resolved by the positions that were read",
        )
        for n in silent
    ]
    return out + several[:MOST_DIRECTIONS]


def _alone(name: str, members: Sequence[tuple[str, str, float]]) -> str:
    shapes = sorted({shape for _, shape, _ in members})
    what = "" if len(shapes) >= 2 or shapes == [ANGLE_SHAPE] else f" ({shapes[0]})"
    return f"{name}{what}: no reading depends on it; {hint(name)}"


def _several(members: Sequence[tuple[str, str, float]]) -> str:
    parts = [_member(*row) for row in members]
    more = "" if len(parts) <= 6 else f" and {len(parts) - 6} more"
    names = dict.fromkeys(name for name, _, _ in members)
    return (
        f"{', '.join(parts[:6])}{more}, all at once: no reading changes, so these cannot be told apart; "
        f"{hint(next(iter(names)))}"
    )


def _member(name: str, shape: str, value: float) -> str:
    """Return one member of a combination in words."""
    if shape != ANGLE_SHAPE:
        return f"{_amount(name, value)} of the {shape} of {name}"
    if is_location(name):
        return f"{_amount(name, value)} of location {name}"
    return f"{_amount(name, value)} of squareness {name}"


def _amount(name: str, value: float) -> str:
    return f"{value * 1e6:+.2g} urad" if is_angle(name) else f"{value * 1e3:+.2g} um"


def is_angle(name: str) -> bool:
    """Return whether an error is in rad: EAX, C0Y, A0C. (BX, a lost motion, and X0C, an offset, are in mm.)."""
    if name[1] == "0":
        return name[0] in "ABC"
    return name[0] == "E" and name[1] in "ABC"


def hint(name: str) -> str:
    """Return which measurement determines an error, as an instruction."""
    if is_rotary(axis_of(name)):
        return _rotary_hint(name, axis_of(name))
    axis = name[-1]
    if name[0] == "B" and len(name) == 2:
        return f"approach places along {axis} from both sides, with the column sense_{axis}"
    if name[0] != "E":
        both = {"C0Y": "X and Y", "B0Z": "X and Z", "A0Z": "Y and Z"}[name]
        return f"measure the angle between {both}: a square, a plate turned by 90 degrees, or diagonals in both senses"
    if name[1] == axis:
        return f"measure lengths along {axis}: laser linear, step gauge"
    if name[1] in "XYZ":
        return f"measure straightness of {axis} in {name[1]}: laser straightness, straightedge with reversal"
    if "ABC".index(name[1]) == "XYZ".index(axis):
        return f"measure the roll of {axis}: a level, or straightness of {axis} along two lines apart in the third axis"
    return f"measure the angle along {axis}: laser angle or autocollimator, or lengths along two lines apart"


def _rotary_hint(name: str, axis: str) -> str:
    """Return the same for errors of a rotary axis."""
    along = "XYZ"[int(unit_vector(axis).argmax())]
    across = " and ".join(c for c in "XYZ" if c != along)
    if (name[1] == "0" and name[0] in "XYZ") or (name[0] == "E" and name[1] in "XYZ"):
        return f"R-test: a ball held while {axis} turns, read in X, Y and Z (a shifted head is one with the place of the nest)"
    if name[0] == "E" and "ABC".index(name[1]) == "XYZ".index(along):
        return f"measure the angle of {axis}: an indexing table with autocollimator or encoder, or an R-test with the ball off the axis"
    return f"R-test with the ball at two heights along {along}, or off the axis, so that tilts about {across} show"
