"""Convert the short forms of a machine file to effects and Inputs: error table with its uncertainty, repeatability, scales."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from vcmm.core.axes import axis_of, is_location, is_rotary
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.inputs import EVERY, Input
from vcmm.core.kinematics import Chain
from vcmm.core.laws import Law, MultivariateNormal, Normal, StudentT
from vcmm.core.machine import FIRST_ORDER_LIMIT_RAD, LARGEST_TRANSLATION
from vcmm.core.run import Array
from vcmm.core.text import read_text
from vcmm.files.own.machine_tables import MachineFile, Repeatability, Scales, Uncertainty
from vcmm.files.problems import Problems
from vcmm.files.schema import is_complete
from vcmm.files.toml import Document, Location
from vcmm.physics.structure.component import ComponentSpline, ComponentTable
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.squareness import RotaryLocation, Squareness

if TYPE_CHECKING:
    from vcmm.files.foreign.isg import ErrorFile


def known_errors(
    model: MachineFile,
    data: Mapping[str, Any],
    document: Document,
    problems: Problems,
    at: Location,
    chain: Chain | None,
) -> tuple[list[Effect], list[Input]]:
    """Return effects and Inputs of [errors], [repeatability] and [environment]; `data` is the table as it was read."""
    effects: list[Effect] = []
    inputs: list[Input] = []
    if model.errors:
        here = (*at, "errors", "table")
        path = document.path.parent / model.errors.table
        cubic = model.errors.interpolation == "cubic"
        tables = problems.attempt(here, lambda: read_error_file(path))
        table_effects = (
            problems.attempt(here, lambda: effects_of(tables, cubic)) if tables is not None else None
        )
        stated = model.errors.uncertainty
        if table_effects:
            given = list(table_effects)
            table_effects = problems.attempt(
                (*at, "errors", "uncertainty"), lambda: refine_tables(given, stated)
            )
        for effect in table_effects or ():
            _check_on_machine(effect, chain, problems, here, path)
        if tables is not None and not model.large_errors:
            for text in _too_large(tables, path):
                problems.add(here, text)
        effects += table_effects or []
        inputs += _table_inputs(table_effects or [], model.errors.uncertainty)
        if model.errors.covariance is not None:
            given = list(table_effects or [])
            joint = problems.attempt((*at, "errors", "covariance"), lambda: _joint(model, document, given))
            modes, shared = joint or ([], [])
            effects += modes
            inputs += shared
    if model.repeatability and is_complete(model.repeatability, data["repeatability"]):
        repeatability = model.repeatability
        law = problems.attempt((*at, "repeatability"), lambda: _repeatability(repeatability))
        effects.append(Scatter())
        label = "repeatability of the machine file"
        inputs += [Input(Scatter.name, "", "value", law, "touch", label)] if law else []
    if model.environment and model.environment.scales and chain:
        scales, letters = model.environment.scales, [a for a in chain.letters if a in "XYZ"]
        found_scales = problems.attempt((*at, "environment", "scales"), lambda: _scales(scales, letters))
        more, known_scales = found_scales or ([], [])
        effects, inputs = effects + more, inputs + known_scales
    return effects, inputs


def _joint(
    model: MachineFile, document: Document, effects: Sequence[Effect]
) -> tuple[list[Effect], list[Input]]:
    """Return the joint knowledge of [errors] covariance about the table. Raises UsageError beside an `uncertainty`."""
    from vcmm.files.own.joint_covariance import joint_knowledge, read_joint_covariance

    errors = model.errors
    assert errors is not None
    assert errors.covariance is not None
    if errors.uncertainty is not None:
        raise UsageError("covariance and uncertainty both say how well the table is known; keep one of them")
    joint = read_joint_covariance(document.path.parent / errors.covariance)
    return joint_knowledge(joint, effects, errors.evidence)


def read_error_file(path: Path) -> ErrorFile:
    """Read an error table of either format, distinguished by its first line: [EXX] opens an Etalon section."""
    from vcmm.files.foreign.etalon import is_etalon, read_etalon
    from vcmm.files.foreign.isg import read_isg

    return read_etalon(path) if is_etalon(read_text(path)) else read_isg(path)


def effects_of(file: ErrorFile, cubic: bool = False) -> list[Effect]:
    """Return component tables (or cubic splines), squareness and rotary locations of an errors.csv."""
    effects: list[Effect] = []
    for table in file.tables:
        for name, values in table.values.items():
            if (
                cubic
                and len(table.arguments) == 1
                and table.arguments[0] == axis_of(name)
                and len(values) > 2
            ):
                effects.append(ComponentSpline(name, table.grids[0], values))
            else:
                effects.append(ComponentTable(name, table.arguments, table.grids, values))
    for name, value in file.constants.items():
        if not is_location(name):
            effects.append(Squareness(name, value))
        else:
            shift = "offset" if name[0] in "XYZ" else "tilt"
            effects.append(RotaryLocation(name, **{shift: value}))
    return effects


def _too_large(file: ErrorFile, path: Path) -> list[str]:
    """Return a problem for translations above 1 mm beside rotations below 1 mrad: nearly always a table in micrometres.

    A machine with large errors of both kinds is left to the engine, which refuses it unless exact evaluation is requested.
    """
    sizes = [(t.line, n, float(np.abs(v).max(initial=0.0))) for t in file.tables for n, v in t.values.items()]
    sizes += [(1, name, abs(value)) for name, value in file.constants.items()]
    rotations = [size for size in sizes if size[1][1 if size[1][0] == "E" else 0] in "ABC"]
    turned = any(size > FIRST_ORDER_LIMIT_RAD for _, _, size in rotations)
    wrong = [size for size in rotations if size[2] > LARGEST_ROTATION]
    wrong += [
        size for size in sizes if size not in rotations and size[2] > LARGEST_TRANSLATION and not turned
    ]
    return [
        f"{path}:{line}: {name} reaches {size:.4g} {'rad' if (line, name, size) in rotations else 'mm'}. Error tables are in mm and "
        "rad, so 6 um is 0.006: correct the unit, or state large_errors = true in the machine file if the machine is that bad"
        for line, name, size in wrong
    ]


def _check_on_machine(
    effect: Effect,
    chain: Chain | None,
    problems: Problems,
    at: Location,
    path: Path,
) -> None:
    if chain and effect.link not in chain.letters:
        problems.add(
            at,
            f'{path.name} holds {effect.where} of axis {effect.link}, which structure = "{chain.structure}" lacks',
        )
    if isinstance(effect, ComponentTable):
        for letter in effect.arguments:
            if chain and letter not in chain.letters:
                problems.add(
                    at, f"{path.name} tabulates {effect.where} over axis {letter}, which the machine lacks"
                )


def _table_inputs(effects: list[Effect], uncertainty: Uncertainty | None) -> list[Input]:
    """Return the Inputs of the short form `uncertainty`: Gaussian process per component over its axis, squareness independent.

    Of a rotary axis' location, offsets take the uncertainty of translations and tilts that of squareness.
    """
    if uncertainty is None:
        return []
    inputs: list[Input] = []
    laws: dict[
        tuple[float, tuple[str, ...], bytes], MultivariateNormal
    ] = {}  # tables at the same nodes share theirs
    for effect in effects:
        if isinstance(effect, ComponentTable | ComponentSpline):
            u = uncertainty.translation if effect.where[1] in "XYZ" else uncertainty.rotation
            if u > 0:
                letters, mesh = _nodes_of(effect)
                key = (u, letters, mesh.tobytes())
                law = laws.get(key) or _joint_law(letters, mesh, u, uncertainty.correlation_length)
                laws[key] = law
                inputs.append(
                    Input(
                        effect.name, effect.where, "values", law, "machine", "calibration of the error table"
                    )
                )
        elif isinstance(effect, Squareness) and uncertainty.squareness > 0:
            inputs.append(_constant(effect, "angle", uncertainty.squareness))
        elif isinstance(effect, RotaryLocation):
            name, u = (
                ("offset", uncertainty.translation)
                if effect.where[0] in "XYZ"
                else ("tilt", uncertainty.squareness)
            )
            inputs += [_constant(effect, name, u)] if u > 0 else []
    return inputs


def _constant(effect: Effect, parameter: str, u: float) -> Input:
    return Input(effect.name, effect.where, parameter, Normal(u), "machine", "calibration of the error table")


LARGEST_ROTATION = 0.1  # rad in an error table
FINE = 8  # nodes per correlation length: between them linear interpolation loses 0.2 % of u (of 3 it would be 1.4 %)
MOST_NODES = 2000  # of one table: its covariance is dense


def refine_tables(effects: list[Effect], uncertainty: Uncertainty | None) -> list[Effect]:
    """Return tables with nodes close enough to carry the Gaussian process: an eighth of the correlation length or less.

    The table itself does not change: new nodes lie on it. Without them draws at far nodes, interpolated, would have too
    small a variance between the nodes and far too small a variance of differences.
    """
    length = uncertainty.correlation_length if uncertainty else None
    if not length:
        return effects
    return [
        _refine(e, length / FINE) if isinstance(e, ComponentTable | ComponentSpline) else e for e in effects
    ]


def _refine(effect: Any, step: float) -> Effect:
    if effect.link not in "XYZ":
        return cast(Effect, effect)
    if isinstance(effect, ComponentSpline):
        nodes = _denser(np.asarray(effect.nodes, dtype=float), step)
        from scipy.interpolate import CubicSpline

        values = CubicSpline(effect.nodes, effect.values, bc_type="natural")(nodes)
        return cast(Effect, replace(effect, nodes=nodes, values=np.asarray(values)))
    values, grids = np.asarray(effect.values, dtype=float), list(effect.grids)
    measured = dict(zip(effect.arguments, grids)).get(effect.link)
    for axis, letter in enumerate(effect.arguments):
        if letter in "XYZ":
            grid, nodes = grids[axis], _denser(grids[axis], step)
            values = np.apply_along_axis(_between, axis, values, nodes, grid)
            grids[axis] = nodes
    if values.size > MOST_NODES:
        raise UsageError(
            f"correlation_length = {FINE * step:g} mm needs {values.size} nodes in the table of {effect.component}; "
            f"{MOST_NODES} are the limit: state a longer correlation length"
        )
    return cast(Effect, replace(effect, grids=tuple(grids), values=values, measured=measured))


def _between(column: Array, nodes: Array, grid: Array) -> Array:
    return np.interp(nodes, grid, column)


def _denser(grid: Array, step: float) -> Array:
    """Return all nodes of the grid and equal steps between them, none wider than `step`."""
    if (grid[-1] - grid[0]) / step > MOST_NODES:
        raise UsageError(
            f"correlation_length = {FINE * step:g} mm is too short for a table of {grid[-1] - grid[0]:g} mm; state a longer one"
        )
    parts = [np.linspace(a, b, int(np.ceil((b - a) / step)) + 1)[:-1] for a, b in pairwise(grid)]
    return np.concatenate([*parts, grid[-1:]])


def _nodes_of(effect: Any) -> tuple[tuple[str, ...], Array]:
    """Return the letters of the axes over which a table or curve is known, and its nodes (k, axes)."""
    table = isinstance(effect, ComponentTable)
    grids = effect.grids if table else (np.asarray(effect.nodes),)
    letters = tuple(effect.arguments) if table else (effect.link,)
    return letters, np.stack([g.ravel() for g in np.meshgrid(*grids, indexing="ij")], axis=1)


def _joint_law(letters: Sequence[str], mesh: Array, u: float, length: float | None) -> MultivariateNormal:
    """Return the law u^2 exp(-(dq)^2 / (2 l^2)) between the nodes (k, axes); without a correlation length the nodes are independent.

    A rotary axis has no length: its nodes are taken as independent unless they coincide.
    """
    squared: Array = np.zeros((len(mesh), len(mesh)))
    for i, letter in enumerate(letters):
        gap = mesh[:, None, i] - mesh[None, :, i]
        if length is None or is_rotary(letter):
            squared = squared + np.where(gap == 0, 0.0, np.inf)
        else:
            squared = squared + (gap / length) ** 2
    return MultivariateNormal(u**2 * np.exp(-squared / 2))


def _repeatability(table: Repeatability) -> Law:
    if table.law == "normal":
        if table.dof is not None:
            raise UsageError('dof goes with law = "t"; remove dof, or write nu, the degrees of freedom of u')
        if table.u is not None and table.scale is not None:
            raise UsageError("u and scale are both given; a normal law takes u")
        spread = table.u if table.u is not None else table.scale
        if spread is None:
            raise UsageError('law = "normal" needs u; write for example u = "0.5 um"')
        return Normal(spread) if table.nu is None else StudentT(spread, table.nu)
    if table.u is not None:
        raise UsageError(
            'law = "t" takes scale, the scale parameter of the law, not u; rename u to scale '
            "(u = scale times the root of dof / (dof - 2))"
        )
    if table.dof is not None and table.nu is not None:
        raise UsageError("nu and dof both state the degrees of freedom; keep one of them")
    dof = table.nu if table.dof is None else table.dof
    if table.scale is None or dof is None:
        raise UsageError('law = "t" needs scale and dof; write for example scale = "0.7 um" and dof = 6')
    return StudentT(table.scale, dof)


def _scales(table: Scales, letters: list[str]) -> tuple[list[Effect], list[Input]]:
    """Scale expansion of every linear axis; one coefficient for all scales, one sensor per scale."""
    corrected = table.expansion if table.compensated else 0.0
    effects: list[Effect] = [ScaleExpansion(a, table.expansion, corrected) for a in letters]
    inputs = []
    if table.u_expansion > 0:
        inputs.append(
            Input(
                ScaleExpansion.name,
                EVERY,
                "alpha",
                Normal(table.u_expansion),
                "machine",
                "expansion of the scales",
            )
        )
    if table.u_sensor > 0:
        for a in letters:
            inputs.append(
                Input(
                    "channel",
                    "",
                    f"temp_scale_{a.lower()}_C",
                    Normal(table.u_sensor),
                    "machine",
                    f"temperature sensor of scale {a}",
                )
            )
    return effects, inputs
