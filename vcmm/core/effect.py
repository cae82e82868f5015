"""Effect and param: the one open interface of vcmm.

An Effect is a physical reason why one link of the machine is not where it should be. It is declared once, by
its parameters and one method, and then serves simulation, Monte Carlo, budget, diagnosis, command line and docs.

    link          which link moves: an axis letter, "tip" (workpiece axes), "tool" (frame of the last tool-side
                  axis), "command" (moves the commanded X, Y and Z, machine axes: a work offset) or "reading" (added to
                  indicated - true, not carried and not negated)
    error_motion  (n, 6): x y z in mm, a b c in rad, in tip sense, in that link's frame
    place         where in the link's transform the six numbers act: "motion" (after the nominal motion),
                  "travel" (turns the direction of travel only: squareness), "location" (moves the centre line)
    own           True for tables: the numbers are the axis's own motion; the machine negates them for an axis
                  that carries the workpiece
    per           how candidates multiply: machine, axis, pair, component, direction, sensor, stylus, part ...
    needs         columns of the run that must be present; "{axis}" and other place fields are filled in

    about         what files, reports and jobs know of it: source, words, what it belongs to ... (`About`)
    diagnosis     what diagnosis alone asks (`ForDiagnosis`)

Only `name` and these are declared; `where` and `id` follow. Both values, and the base classes for what a few effects can do besides, are in
`vcmm.core.declaration`.

Parameters are linear unless `scan` is given. The basis of a parameter is its unit response, so an effect writes
no derivative.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from functools import lru_cache
from typing import Any, ClassVar, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.declaration import (
    UM,
    URAD,
    About,
    ChoosesColumns,
    ForDiagnosis,
    KnownRange,
    Tabulated,
    Typical,
    WithResponse,
)
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array, Run
from vcmm.core.units import parse_unit

OF_AN_ANGLE = {
    "um": "urad",
    "mm": "rad",
    "nm": "nrad",
    "um/kg": "urad/kg",
}  # what a length is about an axis that turns
FREE_LINKS = ("tip", "tool", "command", "reading")  # links that are no axis
COLUMN = {letter: i for i, letter in enumerate("XYZABC")}  # EXj -> 0 ... ECj -> 5
# what a further key of an effect's table holds
POSITIONS = "positions"
POINTS = "points"
LETTERS = "letters"
GRIDS = "grids"
LENGTH = "length"
TEXT = "text"
WHOLE = "whole"
E = TypeVar("E", bound="Effect")


def param(
    default: Any,
    unit: str,
    doc: str,
    *,
    show: str = "",
    scan: Sequence[float] = (),
    shape: str = "",
    only: str = "",
    typical: Typical | None = None,
    lengths: Sequence[int] = (),
    most: float = float("inf"),
    chosen: bool = False,
) -> Any:
    """Declare a parameter of an effect.

    unit: canonical or file unit, it fixes the dimension ("um", "urad", "um/m", "um/(m K)", "s" ...).
    show: unit of reports when it differs. scan: trial values, only for parameters that act non-linearly.
    shape: text such as "(nodes, 3)" for array parameters; lengths: how many elements diagnosis tries.
    only: first letters of `component` that use it ("" = all). typical: how large it is when it matters. most: the largest
    trial value that the physics has, canonical unit. chosen: somebody typed it into a control, so that it neither wears nor wanders.
    """
    meta = {
        "unit": unit, "doc": doc, "show": show or unit, "scan": tuple(scan), "shape": shape, "only": only,
        "typical": typical, "lengths": tuple(lengths), "most": most, "chosen": chosen,
    }  # fmt: skip
    if callable(default):
        return field(default_factory=default, metadata=meta)
    return field(default=default, metadata=meta)


def _is_code(value: Any) -> bool:
    """Return whether a value is code: a method, a property, a class."""
    return callable(value) or hasattr(value, "__get__")


def _names(kind: type) -> list[str]:
    return [f.name for f in fields(kind)]


@dataclass(frozen=True, eq=False)
class Effect(ABC):
    """Base class of all effects; see the docstring of this module."""

    name: ClassVar[str] = ""
    per: ClassVar[str] = "machine"
    needs: ClassVar[tuple[str, ...]] = ()
    place: ClassVar[str] = "motion"
    own: ClassVar[bool] = False
    about: ClassVar[About] = About()
    diagnosis: ClassVar[ForDiagnosis] = ForDiagnosis()

    def __init_subclass__(cls) -> None:
        """Raises UsageError for a declaration that nothing would read: one that belongs into a value, or of an unknown name.

        A constant that the effect uses itself starts with an underscore or is annotated ClassVar. Methods are not looked at: an effect
        may have some of its own.
        """
        mine = vars(cls)
        for value, kind in (("about", About), ("diagnosis", ForDiagnosis)):
            beside = [name for name in _names(kind) if name in mine]
            if beside:
                raise UsageError(
                    f"{cls.__name__}: {', '.join(beside)} belongs into {value}; write {value} = {kind.__name__}({beside[0]}=...)"
                )
        declared = {
            name for base in cls.__mro__[1:] for name in (*vars(base), *getattr(base, "__annotations__", ()))
        }
        annotations = mine.get("__annotations__", {})
        for name, value in mine.items():
            if not (name.startswith("_") or name in declared or name in annotations or _is_code(value)):
                names = [
                    n for n in (*declared, *_names(About), *_names(ForDiagnosis)) if not n.startswith("_")
                ]
                raise UsageError(
                    f"{cls.__name__}: nothing reads {name!r}.{choose_from(name, names)} A constant of its own is _{name}, or is annotated ClassVar"
                )

    @property
    @abstractmethod
    def link(self) -> str:
        """Axis letter, "tip", "tool", "command" or "reading"."""

    @abstractmethod
    def error_motion(self, run: Run) -> Array:
        """Return the error motion (n, 6): x y z mm, a b c rad, tip sense, in the frame of `link`; for "reading" columns 0-2 in workpiece axes."""

    @property
    def where(self) -> str:
        """The place fields joined: "X" of backlash[X]; empty for an effect of the whole machine."""
        places = [(f, getattr(self, f.name)) for f in place_fields(type(self))]
        return ",".join(str(v) for f, v in places if v != "" and not (f.metadata["quiet"] and v == f.default))

    @property
    def id(self) -> str:
        return f"{self.name}[{self.where}]" if self.where else self.name


def required(effect: Effect) -> tuple[str, ...]:
    """Return the columns of the run that this instance needs."""
    return effect.required_columns() if isinstance(effect, ChoosesColumns) else declared_columns(effect)


def declared_columns(effect: Effect) -> tuple[str, ...]:
    """Return the columns as declared in `needs`, place fields filled in."""
    filled = {f.name: getattr(effect, f.name) for f in place_fields(type(effect))}
    return tuple(text.format(**filled) for text in effect.needs)


def known_range(effect: Effect) -> tuple[KnownRange, ...]:
    """Return the ranges in which a tabulated effect is known; () for an effect that is known everywhere."""
    return effect.known_range() if isinstance(effect, Tabulated) else ()


def own_nodes(effect: Effect) -> Array | None:
    """Return the positions (k,) of the stored numbers over its own axis, or None where it is no table over one axis."""
    return effect.own_nodes() if isinstance(effect, Tabulated) else None


@lru_cache(maxsize=1024)
def _parameters(kind: type[Effect]) -> dict[str, Field[Any]]:
    """Return the parameters of a class of effects by name, in order; cached, since every step of every derivative needs them."""
    return {f.name: f for f in fields(kind) if "unit" in f.metadata}


def parameter_fields(effect: type[Effect] | Effect) -> list[Field[Any]]:
    """Return the dataclass fields that are parameters, in order."""
    return list(_parameters(effect if isinstance(effect, type) else type(effect)).values())


def place_fields(effect: type[Effect] | Effect) -> list[Field[Any]]:
    """Return the text fields that say where the effect acts (axis, pair, component, direction, sensor, stylus ...)."""
    return list(_places(effect if isinstance(effect, type) else type(effect)))


@lru_cache(maxsize=1024)
def _places(kind: type[Effect]) -> tuple[Field[Any], ...]:
    return tuple(f for f in fields(kind) if f.metadata.get("place"))


def key_fields(effect: type[Effect] | Effect) -> list[Field[Any]]:
    """Return the other keys of the effect's table: neither place nor parameter, nor filled in by the program."""
    return [f for f in fields(effect) if not {"unit", "place", "internal"} & set(f.metadata)]


def at(
    default: Any,
    doc: str,
    quiet: bool = False,
    *,
    tries: Sequence[Any] = (),
    waves_over: str = "",
    waves_by: str = "",
    forms: Sequence[Any] = (),
) -> Any:
    """Declare a place field of an effect (axis, pair, component ...). quiet: not in the name at its default value.

    tries: values that diagnosis tries; the first carries half of the weight. waves_over: column (rad) over which they are
    waves per turn, of which only those are tried that its values resolve; waves_by: column that the waves are multiplied by.
    forms: values that are candidates of their own.
    """
    meta = {
        "place": True, "doc": doc, "quiet": quiet, "tries": tuple(tries), "waves_over": waves_over,
        "waves_by": waves_by, "forms": tuple(forms),
    }  # fmt: skip
    return field(default=default, metadata=meta)


def choice(default: str, tries: Sequence[str]) -> Any:
    """Declare a further key with a few words to choose from, which diagnosis tries; the first carries half of the weight."""
    return field(default=default, metadata={"tries": tuple(tries)})


def positions(default: Sequence[float]) -> Any:
    """Declare a further key that holds positions along the effect's own axis: nodes of a table, ends of a travel."""
    return field(default_factory=lambda: np.array(default, dtype=float), metadata={"kind": POSITIONS})


def points(default: Callable[[], Array]) -> Any:
    """Declare a further key that holds points or vectors (k, 3), mm, a row each."""
    return field(default_factory=default, metadata={"kind": POINTS})


def argument_letters() -> Any:
    """Declare a further key that holds the letters of the axes over which a table stands."""
    return field(default=("X",), metadata={"kind": LETTERS})


def argument_grids(default: Sequence[Sequence[float]]) -> Any:
    """Declare a further key that holds one list of positions for each letter of `arguments`."""
    return field(
        default_factory=lambda: tuple(np.array(g, dtype=float) for g in default), metadata={"kind": GRIDS}
    )


def kind_of_key(spec: Field[Any]) -> str:
    """Return the type of another key of the effect's table: as declared, or by its default a length, a text or a whole number."""
    if "kind" in spec.metadata:
        return str(spec.metadata["kind"])
    return LENGTH if isinstance(spec.default, float) else TEXT if isinstance(spec.default, str) else WHOLE


def parameter(effect: Effect, name: str) -> Field[Any]:
    """Return the field of one parameter. Raises UsageError with the closest name."""
    parameters = _parameters(type(effect))
    name = effect.about.aliases.get(name, name)
    if name not in parameters:
        raise UsageError(f"{effect.name} has no parameter {name}.{choose_from(name, parameters)}")
    return parameters[name]


def unit_at(kind: type[Effect] | Effect, unit: str, component: str = "", axis: str = "") -> str:
    """Return the declared unit of a parameter at its place: "mm or rad" is settled by the component (EXX mm, EAX rad), a length along an
    axis by whether that turns.
    """
    if unit == "mm or rad":
        return "rad" if component[1:2] in tuple("ABC") else "mm"
    return OF_AN_ANGLE.get(unit, unit) if kind.about.along_axis and is_rotary(axis) else unit


def unit_of(effect: Effect, name: str) -> str:
    """Return the unit of a parameter of this effect in files. Raises UsageError for an unknown parameter."""
    unit = parameter(effect, name).metadata["unit"]
    return unit_at(effect, unit, str(getattr(effect, "component", "")), str(getattr(effect, "axis", "")))


def typical(effect: Effect, name: str) -> float:
    """Return the typical size of each element of a linear parameter, canonical unit; 1 of its own unit where none is declared.

    For "mm or rad" that is 1 um, or 1 urad for the rotations EA., EB., EC.; what lies along an axis that turns is an angle. Raises UsageError for an unknown parameter.
    """
    spec = parameter(effect, name)
    along = effect.about.along_axis and is_rotary(str(getattr(effect, "axis", "")))
    turns = along or str(getattr(effect, "component", ""))[1:2] in tuple("ABC")
    typical_size: Typical | None = spec.metadata["typical"]
    if typical_size is not None:
        return typical_size.turn if turns and typical_size.turn else typical_size.amount
    if spec.metadata["unit"] == "mm or rad":
        return URAD if turns else UM
    return parse_unit(spec.metadata["unit"]).factor


def with_parameter(effect: E, name: str, value: float | Array) -> E:
    """Return a copy with one parameter changed."""
    return replace(effect, **{parameter(effect, name).name: value})


def basis(effect: Effect, name: str, run: Run) -> Array:
    """Return the derivative of the error motion w.r.t. each element of a parameter: (n, 6, k), k = 1 for a number.

    Linear parameters: response to a unit step, exact. Parameters with `scan`: central difference.
    """
    spec = parameter(effect, name)
    columns = effect.response(spec.name, run) if isinstance(effect, WithResponse) else None
    if columns is not None:
        return columns
    return stepped_basis(effect, name, run)


def projected_basis(effect: Effect, name: str, run: Run, weights: Array) -> Array:
    """Return weights (n, 6) times `basis`, summed over the six numbers: (n, k)."""
    if isinstance(effect, WithResponse):
        columns = effect.projection(parameter(effect, name).name, run, weights)
        if columns is not None:
            return columns
    return np.asarray(np.einsum("ni,nik->nk", weights, basis(effect, name, run)))


def stepped_basis(effect: Effect, name: str, run: Run) -> Array:
    """Compute `basis` by stepping each element of the parameter."""
    spec = parameter(effect, name)
    value = np.asarray(getattr(effect, spec.name), dtype=float)
    if value.ndim == 0 and not spec.metadata["scan"]:
        unit, zero = _unit_step(effect, spec.name)
        return (unit.error_motion(run) - zero.error_motion(run))[:, :, None]
    columns = []
    for k in range(value.size):
        if spec.metadata["scan"]:
            step = 1e-4 * max(abs(float(value.flat[k])), 1e-6)
            high, low, width = _shift_element(value, k, step), _shift_element(value, k, -step), 2 * step
        else:  # linear: the response to a unit vector, free of cancellation
            low, width = np.zeros_like(value), 1.0
            high = _shift_element(low, k, 1.0)
        columns.append(_difference(effect, spec.name, high, low, run) / width)
    return np.stack(columns, axis=2)


_STEPS: WeakKeyDictionary[Effect, dict[str, tuple[Effect, Effect]]] = WeakKeyDictionary()


def _unit_step(effect: Effect, name: str) -> tuple[Effect, Effect]:
    """Return the effect with a linear parameter at one and at zero; cached, since searches evaluate it at thousands of runs."""
    steps = _STEPS.setdefault(effect, {})
    if name not in steps:
        steps[name] = with_parameter(effect, name, 1.0), with_parameter(effect, name, 0.0)
    return steps[name]


def _shift_element(value: Array, k: int, step: float) -> Array:
    out = value.copy()
    out.flat[k] += step
    return out


def _difference(effect: Effect, name: str, high: Array, low: Array, run: Run) -> Array:
    scalar = high.ndim == 0
    up = with_parameter(effect, name, float(high) if scalar else high).error_motion(run)
    return up - with_parameter(effect, name, float(low) if scalar else low).error_motion(run)


def motion(run: Run, **components: Array) -> Array:
    """Assemble an error motion from named columns: motion(run, X=..., B=...) -> (n, 6). An axis such as A1 is passed as A."""
    out = np.zeros((run.n, 6))
    for letter, values in components.items():
        out[:, COLUMN[letter[0]]] = values
    return out


def along(run: Run, direction: Array, amount: Array) -> Array:
    """Return a translation of `amount` (n,) mm along `direction` (n, 3) or (3,): (n, 6)."""
    out = np.zeros((run.n, 6))
    out[:, :3] = direction * np.asarray(amount)[:, None]
    return out
