"""The tables of a recording file (recording/1) as pydantic models, and the words in them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.laws import Law, Normal, StudentT
from vcmm.core.text import LARGEST
from vcmm.core.units import quantity, usual
from vcmm.files.columns import LABELS
from vcmm.files.own.machine_tables import RecordTable
from vcmm.files.own.pose_tables import PosesTable
from vcmm.files.own.scenario import PoseTable
from vcmm.files.own.touch_tables import TouchesTable
from vcmm.files.problems import Problems, TableProblems
from vcmm.files.schema import Distance, Point, Table
from vcmm.files.toml import Location
from vcmm.task.response.recording import ALL_ROWS, NUISANCES

INDICATED, ACTUAL = "indicated - true", "actual - commanded"
_POINT = (0.0, 0.0, 0.0)


class NoiseTable(Table):
    law: Literal["normal", "t"] = "normal"
    u: str | None = Field(default=None, examples=['"0.5 um"'])
    scale: str | None = Field(default=None, examples=['"0.7 um"'])
    dof: float | None = Field(default=None, examples=["6"])


class SeriesTable(Table):
    data: str = Field(examples=['"temperatures.csv"'])


class KnownTable(Table):
    """Known uncertainties of this recording: a table with one column per independent draw, in the rows of the data."""

    data: str = Field(examples=['"part-known.csv"'])


class LineTable(Table):
    """Place of the measurement of an axis (formats iso230, rtl, scope): the axis, the other axes, the reflector."""

    axis: str = ""
    at: dict[str, str] = Field(default_factory=dict, examples=['{ Y = "250 mm", Z = "-100 mm" }'])
    offset: Point = _POINT


class StylusTable(Table):
    """Instrument of a point table (format points)."""

    offset: Point = _POINT
    tip_diameter: Distance = 0.0


class ScopeTable(Table):
    """Columns of a controller's trace (format scope): axis = [commanded, actual]."""

    time: str = "time_s"
    time_unit: Literal["", "s", "ms", "us", "filetime"] = ""
    unit: Literal["", "mm", "um", "m", "in", "deg", "rad"] = ""
    axes: dict[str, list[str]] = Field(default_factory=dict, examples=['{ X = ["SetPos", "ActPos"] }'])


class CounterTable(Table):
    """Value of one count of a log (format klipper)."""

    step: Distance


class InstrumentTable(Table):
    """Instrument: name, standard uncertainties of its own errors, and for which rows these are the same.

    compensated: what its software corrects for; the sensor columns that this needs must be there. serial: recordings that state the
    same were made by one and the same instrument.
    """

    name: str = Field(examples=['"laser linear"'])
    serial: str = Field(default="", examples=['"L-2041"'])
    u: dict[str, str] = Field(default_factory=dict, examples=['{ scale = "0.3 um/m" }'])
    redraw: str = "machine"
    compensated: list[Literal["air", "material"]] = Field(default_factory=list, examples=['["air"]'])


class ReversalTable(Table):
    """Reversal of one artefact against the machine: changes of sign or place of the readings.

    error: what is sought (EZX, B0C, EXC ...); tilt: of a face test. sense: "+" where the reading in the set-up "normal" grows with
    the error (face, half turn: when the turning part moves to +Z). probes: of a face test, signed place of each from the axis.
    """

    test: Literal["straightness", "half-turn", "direct", "donaldson", "face", "multi-step"]
    error: str = ""
    tilt: Literal["", "EAC", "EBC"] = ""
    sense: Literal["+", "-"] = "+"
    probes: dict[str, str] = Field(default_factory=dict, examples=['{ centre = "0 mm", outer = "25 mm" }'])
    u_centre: Distance = 0.0
    harmonics: int = Field(default=15, ge=1, le=200, examples=["15"])
    axis_tilt: str = Field(default="0 urad", examples=['"0.1 urad"'])


DATE = r"^([0-9]{4}-[0-9]{2}-[0-9]{2}([T ][0-9]{2}:[0-9]{2}(:[0-9]{2})?)?)?$"  # ISO 8601, so that text sorts as time


class RecordingFile(Table):
    """recording/1"""

    vcmm: str
    name: str = ""
    date: str = Field(default="", pattern=DATE, examples=['"2026-11-22"'])
    data: str = Field(examples=['"touches.csv"'])
    format: Literal[
        "", "table", "points", "iso230", "rtl", "scope", "tpoint", "altaz", "klipper", "touches"
    ] = ""
    equinox: Literal["", "date", "J2000"] = ""
    machine: str | dict[str, Any] | None = Field(default=None, examples=['"machine.toml"'])
    kind: Literal["probe", "displacement", "length", "angle", "path", "pose"] = Field(examples=['"probe"'])
    observed: Literal["", "indicated - true", "actual - commanded"] = ""
    history: Literal["", "none", "travel", "rows", "path"] = ""
    down: list[float] | None = Field(default=None, min_length=3, max_length=3, examples=["[0, 0, -1]"])
    nuisance: dict[str, str] = Field(default_factory=dict, examples=['{ rigid = "pose" }'])
    noise: NoiseTable | None = None
    known: KnownTable | None = None
    series: list[SeriesTable] = Field(default_factory=list)
    line: LineTable | None = None
    pose: PoseTable | None = None
    stylus: StylusTable | None = None
    scope: ScopeTable | None = None
    counter: CounterTable | None = None
    instrument: InstrumentTable | None = None
    reversal: ReversalTable | None = None
    touch: TouchesTable | None = None
    poses: PosesTable | None = None
    record: RecordTable = Field(default_factory=RecordTable)

    @property
    def shape(self) -> str:
        """Format of the data: as stated, else .rtl by its ending, else the columns of a recording."""
        return self.format or ("rtl" if self.data.lower().endswith(".rtl") else "table")

    @property
    def measuring(self) -> bool:
        """True for indicated - true, the default of every kind but path and pose."""
        return (self.observed or (ACTUAL if self.kind in ("path", "pose") else INDICATED)) == INDICATED

    @property
    def memory(self) -> str:
        """Source of the history of the axes: rows of paths and displacements follow one another without detours."""
        return self.history or ("rows" if self.kind in ("path", "displacement") else "travel")


TABLES_OF = {
    "line": ("iso230", "rtl", "scope", "klipper"),
    "counter": ("klipper",),
    "pose": ("points",),
    "stylus": ("points",),
    "scope": ("scope",),
    "touch": ("touches",),
}


def check_words(model: RecordingFile, problems: Problems) -> None:
    """Note nuisances and labels that do not exist, and tables that the format does not use."""
    for word, label in model.nuisance.items():
        here: Location = ("nuisance", word)
        if word not in NUISANCES:
            problems.add(here, f'unknown nuisance "{word}".{choose_from(word, NUISANCES)}')
        elif label not in (*ALL_ROWS, *LABELS):
            labels = choose_from(label, LABELS)
            problems.add(here, f'{word} = "{label}" is no label column.{labels} Or "" for all rows')
    for table, formats in TABLES_OF.items():
        if getattr(model, table) is not None and model.shape not in formats:
            due = " or ".join(f'"{f}"' for f in formats)
            problems.add((table,), f'goes with format = {due}, but the data are read as "{model.shape}"')
    if model.poses is not None and model.kind != "pose":
        problems.add(("poses",), f'goes with kind = "pose", but this is kind = "{model.kind}"')
    if model.kind == "pose":
        _check_pose_words(model, problems)


def _check_pose_words(model: RecordingFile, problems: Problems) -> None:
    """Note statements that a recording of poses cannot make."""
    idle = [k for k in ("known", "instrument", "reversal") if getattr(model, k) is not None]
    idle += [k for k in ("nuisance", "series") if getattr(model, k)]
    for key in idle:
        problems.add((key,), "poses take none: the places of the tracker and of the target are always free")
    if model.shape != "table":
        problems.add(
            ("format",), f'poses are read as a table, not as "{model.shape}"; name their columns in [poses]'
        )
    if model.measuring:
        problems.add(("observed",), f'what a tracker sees of an arm is "{ACTUAL}"; leave the key out')
    if model.noise is not None and model.noise.law != "normal":
        problems.add(("noise", "law"), 'poses take law = "normal"')


def noise_law(table: NoiseTable, angle: bool) -> Law:
    """Return the law of the noise in mm, or in rad for angle = True: t takes scale and dof, normal u or scale.

    Raises TableProblems naming the key.
    """
    unit = "urad" if angle else "um"
    given = [k for k in ("u", "scale", "dof") if getattr(table, k) is not None]
    if table.law == "t":
        wrong, missing = [k for k in given if k == "u"], [k for k in ("scale", "dof") if k not in given]
    else:
        wrong, missing = [k for k in given if k == "dof"], [] if {"u", "scale"} & set(given) else ["u"]
        wrong += ["scale"] if {"u", "scale"} <= set(given) else []
    if wrong:
        takes = "scale and dof" if table.law == "t" else "u"
        text = f'{wrong[0]} does not belong to law = "{table.law}", which takes {takes}'
        raise TableProblems([(wrong[0], text)])
    if missing:
        example = "6" if missing[0] == "dof" else f'"0.7 {unit}"'
        text = f'law = "{table.law}" needs {missing[0]}; write for example {missing[0]} = {example}'
        raise TableProblems([("", text)])
    if table.law == "t":
        return StudentT(_spread(table.scale, "scale", angle), float(table.dof or 0.0))
    key = "u" if table.u is not None else "scale"
    return Normal(_spread(getattr(table, key), key, angle))


def _spread(text: str | None, key: str, angle: bool) -> float:
    try:
        value = quantity(text, "angle" if angle else "length", key, "0.5 urad" if angle else "0.5 um")
        if value < usual("angle" if angle else "length") / LARGEST:
            raise UsageError(f'{key} = "{text}" must be above zero')
    except UsageError as error:
        raise TableProblems([(key, str(error))]) from None
    return value


def other_positions(line: LineTable, letters: tuple[str, ...], moving: tuple[str, ...]) -> dict[str, float]:
    """Return positions of the axes that did not move, mm or rad. Raises TableProblems for axes that are missing or too many."""
    problems: list[tuple[str | tuple[str, ...], str]] = []
    out: dict[str, float] = {}
    for letter, text in line.at.items():
        if letter not in letters or letter in moving:
            allowed = [a for a in letters if a not in moving]
            problems.append((("at", letter), f'at names axis "{letter}".{choose_from(letter, allowed)}'))
            continue
        try:
            rotary = is_rotary(letter)
            out[letter] = quantity(
                text, "angle" if rotary else "length", letter, "0 deg" if rotary else "250 mm"
            )
        except UsageError as error:
            problems.append((("at", letter), str(error)))
    missing = [a for a in letters if a not in moving and a not in line.at]
    if missing:
        example = ", ".join(f'{a} = "0 {"deg" if is_rotary(a) else "mm"}"' for a in missing)
        problems.append(
            ("at", f"where the other axes stood is missing (arms depend on it); add at = {{ {example} }}")
        )
    if problems:
        raise TableProblems(problems)
    return out
