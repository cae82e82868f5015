"""Interpolation of an error between the positions that were read: several methods behind one interface.

    spline              natural cubic splines of a smooth process, as few nodes as the evidence allows (default)
    gaussian process    Matern process of order 5/2 on the finest nodes
    polynomial          Legendre polynomials of degree 2 to 11 by the evidence, carried by a spline on the finest nodes
    table               linear between nodes where readings were made; a node has no prior but its readings
    i-(2i+1)-o ...      feed-forward nets, one per axis for all its errors, learnt from draws of the table

All take the same readings, and all leave nodes, values and a joint covariance, which are written as one table.

What nodes leave of a curve between them, where a spline runs through them and the curve need not.

Readings at just the nodes would not tell, but means and lines over the travel, and users of the file between the nodes, need it. A band
u that ignores a departure r u is too narrow by sqrt(1 + r^2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.evidence import SPAN
from vcmm.learn.calibration.model import LINEAR, Curve, ErrorModel, gauge
from vcmm.learn.calibration.net import train_net
from vcmm.learn.calibration.prior import KERNELS, smooth, unit_factor
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.solve import Before, ErrorPosterior, columns_of, project
from vcmm.task.response.recording import Recording

NETS: Mapping[str, str] = {  # name -> layout of vcmm.learn.calibration.net
    "i-(i+1)-o": "i, i+1, o",
    "i-(2i+1)-o": "i, 2i+1, o",
    "i-(i+1)-(2i+1)-o": "i, i+1, 2i+1, o",
    "i-(2i+1)-(3i+1)-o": "i, 2i+1, 3i+1, o",
}
INTERPOLATIONS = (*KERNELS, *NETS)
SHORT = {
    "splines": "spline", "gp": "gaussian process", "gaussian-process": "gaussian process", "net": "i-(2i+1)-o",
}  # fmt: skip
LINEAR_AXES = ("X", "Y", "Z")
SAME_POSITION_MM = 1e-3  # mm: positions nearer than this are one
LARGEST_GAP = 3.0  # u of both together, of curves from the same readings; of 216 that did not swing none was further apart
MEMBERS = 24  # nets of an ensemble
MOST_TABLE_NODES = 33  # nodes of a table


def interpolation_of(word: str) -> str:
    """Return the interpolation of a name or short name (gp, net). Raises UsageError for another word."""
    name = SHORT.get(word.lower(), word.lower())
    if name not in INTERPOLATIONS:
        raise UsageError(f'unknown interpolation "{word}".{choose_from(word, [*INTERPOLATIONS, *SHORT])}')
    return name


def as_kind(model: ErrorModel, kind: str, recordings: Sequence[Recording]) -> ErrorModel:
    """Return the model with curves of linear axes of that kind; a table has its nodes where lines were read."""
    curves, at = [], {}
    for curve in model.curves:
        if curve.reversal or curve.axis not in LINEAR_AXES:
            curves.append(curve)
            continue
        if kind == LINEAR and curve.axis not in at:
            at[curve.axis] = read_positions(recordings, curve)
        curves.append(replace(curve, kind=kind, nodes=at.get(curve.axis, curve.nodes)))
    return ErrorModel(tuple(curves), model.pairs)


def read_positions(recordings: Sequence[Recording], curve: Curve) -> Array:
    """Return the positions (k,) mm at which lines along the axis of a curve were read, with its ends; its own nodes where there are none
    or too many."""
    moved = [r.run.q(curve.axis)[r.row] for r in recordings if moving(r) == [curve.axis]]
    every = np.unique(
        np.round(np.concatenate([curve.nodes[[0, -1]], *moved]) / SAME_POSITION_MM) * SAME_POSITION_MM
    )
    every = np.clip(every, curve.nodes[0], curve.nodes[-1])
    apart = every[np.concatenate([[True], np.diff(every) > 2 * SAME_POSITION_MM])]
    if len(apart) < 3 or len(apart) > MOST_TABLE_NODES:
        return curve.nodes
    apart[-1] = curve.nodes[-1]
    return np.asarray(apart)


def moving(recording: Recording) -> list[str]:
    """Return the axes that move in a recording."""
    return [
        a for a, q in recording.run.position.items() if float(np.ptp(q[recording.row])) > SAME_POSITION_MM
    ]


def swings(post: ErrorPosterior, beside: ErrorPosterior) -> list[str]:
    """Return the curves that run far from another interpolation of the same readings, in words. Same nodes; both have seen the same
    noise, so that the u of their difference is smaller than the two together.
    """
    out = []
    for curve in post.model.curves:
        here = post.model.slices[curve.component]
        away = np.abs(post.theta[here] - beside.theta[here])
        u = np.sqrt(np.diag(post.covariance)[here] + np.diag(beside.covariance)[here])
        k = int((away / u).argmax())
        if away[k] > LARGEST_GAP * u[k]:
            size = f"{away[k] * 1e6:.2g} urad" if curve.turns else f"{away[k] * 1e3:.2g} um"
            out.append(
                f"{curve.component}: {curve.kind} and spline differ by {size} at {curve.axis} = {curve.nodes[k]:.4g} mm, {away[k] / u[k]:.2g} "
                "times what either allows: it swings between the positions that were read; take splines, or read more positions"
            )
    return out


def net_posterior(
    table: ErrorPosterior, carrier: ErrorPosterior, parts: Sequence[Readings], machine: Machine, name: str
) -> ErrorPosterior:
    """Return the posterior of an ensemble of nets at the nodes of `carrier`.

    Each net learns, for one axis, all errors as one draw of the table has them, from its own start. Their mean and covariance are
    taken, and what the mean does not reproduce of the table is added as a smooth process: a net too small for its curves
    says so. parts: the readings by the model of `carrier`.
    """
    rng = np.random.default_rng(0)
    factor = _factor(table.covariance)
    draws = table.theta + rng.standard_normal((MEMBERS, factor.shape[1])) @ factor.T
    lifted = np.array(
        [_net_through_draw(draw, table.model, carrier.model, NETS[name], rng) for draw in draws]
    )
    lifted = lifted @ gauge(carrier.model, machine).T
    theta, away = lifted.mean(axis=0), lifted - lifted.mean(axis=0)
    covariance = away.T @ away / (MEMBERS - 1) + _net_misfit(theta, table, carrier.model)
    columns, _ = columns_of(parts, Before.nothing(carrier.model))
    whole = np.concatenate([theta, carrier.instrument_errors])
    left = [
        project(p, c, 1 / (n.scale * p.u) ** 2).residual(whole)
        for p, c, n in zip(parts, columns, carrier.noise)
    ]
    return replace(carrier, theta=theta, covariance=covariance, residual=tuple(left))


def _factor(covariance: Array) -> Array:
    size, ways = np.linalg.eigh((covariance + covariance.T) / 2)
    return np.asarray(ways * np.sqrt(np.maximum(size, 0.0)))


def _net_through_draw(
    draw: Array, table: ErrorModel, model: ErrorModel, layout: str, rng: np.random.Generator
) -> Array:
    """Return one net per axis through a draw of the table, (model.size,); lost motion and squareness as sampled."""
    out = np.zeros(model.size)
    for axis in dict.fromkeys(c.axis for c in table.curves):
        mine = [c for c in table.curves if c.axis == axis and not c.reversal]
        if not mine:
            continue
        learnt = np.stack([draw[table.slices[c.component]] for c in mine], axis=1)
        net = train_net(mine[0].nodes[:, None], learnt, layout, rng)
        for k, curve in enumerate(c for c in model.curves if c.axis == axis and not c.reversal):
            out[model.slices[curve.component]] = net.at(curve.nodes[:, None])[:, k]
    for name in (*(c.component for c in table.curves if c.reversal), *table.pairs):
        out[model.slices[name]] = draw[table.slices[name]]
    return out


def _net_misfit(theta: Array, table: ErrorPosterior, model: ErrorModel) -> Array:
    """Return the covariance (size, size) of the misfit of the nets to the table; both have seen the same noise."""
    out = np.zeros((model.size, model.size))
    for fine, coarse in zip(model.curves, table.model.curves):
        if fine.reversal:
            continue
        here, there = model.slices[fine.component], table.model.slices[coarse.component]
        away = coarse.projector @ (np.interp(coarse.nodes, fine.nodes, theta[here]) - table.theta[there])
        process = fine.projector @ smooth(fine, SPAN * fine.travel) @ fine.projector.T
        out[here, here] = float((away**2).mean()) * process * len(process) / np.trace(process)
    return out


def left_between(post: ErrorPosterior, coarse: ErrorModel) -> float:
    """Return the misfit of a spline through fewer nodes to the curves, root mean square as expected by the posterior, over their u at the nodes
    left out: the largest of all curves.
    """
    out = 0.0
    for fine, few in zip(post.model.curves, coarse.curves):
        here = post.model.slices[fine.component]
        left, between = _departures(fine, few)
        covariance = post.covariance[here, here]
        missed = float(((left @ post.theta[here]) ** 2).sum() + (left @ covariance * left).sum())
        out = max(out, missed / float(np.diag(covariance)[between].sum()))
    return float(np.sqrt(out))


def expected_between(post: ErrorPosterior) -> float:
    """Return the same misfit for twice as many nodes and the present ones, before a fit: for processes of the most probable size and
    length, over the u here."""
    out = 0.0
    for few, size in zip(post.model.curves, post.smooth.sizes):
        fine = replace(few, nodes=np.linspace(few.nodes[0], few.nodes[-1], 2 * len(few.nodes) - 1))
        left, _ = _departures(fine, few)
        rough = left @ fine.free @ unit_factor(fine, post.smooth.lengths[few.component]) * size
        here = post.model.slices[few.component]
        out = max(out, float((rough**2).sum(axis=1).mean() / np.diag(post.covariance)[here].mean()))
    return float(np.sqrt(out))


def _departures(fine: Curve, few: Curve) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Return the matrix from a curve at its k nodes to the misfit of a spline through few of them at the m others, and which nodes these
    are (k,) bool."""
    between = ~np.isin(fine.nodes, few.nodes)
    left = np.eye(len(fine.nodes))
    left[:, ~between] -= few.weights(fine.nodes)
    return left[between], between
