"""Set-up files: setup/1 TOML to a Setup (machine, dialect, work offsets, tools, stock)."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from vcmm.core.errors import UsageError, VcmmError, choose_from
from vcmm.core.units import quantity
from vcmm.files.own.environment import Temperatures, columns_of
from vcmm.files.own.logs import read_logs
from vcmm.files.problems import Problems, TableProblems
from vcmm.files.schema import Angle, Diameter, Direction, Point, Size, Table, ToolLength, checked_model
from vcmm.files.schema import Deviation as Offset
from vcmm.files.toml import check_version, read_toml
from vcmm.program.dialects import names
from vcmm.program.limits import control_from
from vcmm.program.setup import KIENZLE, LINEAR_EDGE, ZERO, Bar, Setup, TemperatureLog, Tool
from vcmm.program.touching import Face, Round, Surface, box_faces
from vcmm.task.response.logs import sensor_of

_OFFSET = re.compile(r"G5[4-9]|G59\.[123]|G54\.1 P[1-9]\d*|G505|G5[1-9]\d")


SPINDLE = "spindle"  # the key of the tool that is in the spindle before any is called: tool 0

NEGATIVE_LENGTH = (
    'length = "{0:g} mm" is negative; it counts from the gauge line of the spindle to the tip. An offset H that was touched off '
    "from machine zero becomes length = H - Z, with Z the machine position of the work zero, which is then written to [offsets]: "
    'H = -212.4 mm and Z = -362.4 mm give length = "150 mm"'
)


TOOL_SIZES = {  # mm: smallest and largest that a tool has; below and above, a unit is wrong (chosen from catalogues)
    "length": (0.0, 3000.0), "diameter": (0.02, 1000.0), "corner_radius": (1e-3, 100.0), "nose_radius": (1e-3, 100.0),
    "stick_out": (0.1, 3000.0), "cutting_length": (0.02, 3000.0), "shank_diameter": (0.1, 1000.0), "width": (0.02, 100.0),
    "offset_x": (0.0, 3000.0), "offset_y": (0.0, 3000.0),
}  # fmt: skip


STEEPEST = math.radians(70.0)
UNITS = {"mm": 1.0, "inch": 25.4}  # mm


class ToolTable(Table):
    length: ToolLength = 0.0
    diameter: Diameter | None = None
    shape: Literal["flat", "ball", "bull", "drill", "turning", "probe"] = "flat"
    corner_radius: Size | None = None
    nose_radius: Size | None = None
    orientation: Annotated[int, Field(ge=0, le=9)] = 0
    offset_x: Offset = 0.0
    offset_y: Offset = 0.0
    name: str = ""
    teeth: Annotated[int, Field(ge=1)] | None = Field(default=None, examples=["3"])
    helix: Angle | None = Field(default=None, examples=['"30 deg"'])
    stick_out: Size | None = None
    cutting_length: Size | None = None
    shank_diameter: Size | None = None
    width: Size | None = None
    driven: Literal["x", "y", "z", "-x", "-y", "-z"] | None = None


class StockTable(Table):
    """box: milling; diameter and length: a bar on a lathe, its face at Z = front in work coordinates."""

    box: Point | None = Field(default=None, examples=['["100 mm", "60 mm", "30 mm"]'])
    corner: Point | None = None
    diameter: Size | None = Field(default=None, examples=['"60 mm"'])
    length: Size | None = Field(default=None, examples=['"120 mm"'])
    bore: Size | None = None
    front: Offset = 0.0
    thrust_ratio: Annotated[float, Field(gt=0)] | None = Field(default=None, examples=["0.45"])
    material: str | None = Field(default=None, examples=['"Al7075"'])


class SurfaceTable(Table):
    """Surface that a probing move meets, in work coordinates of `offset`: a plane (point, normal), or a bore or boss along Z (point,
    diameter, inside); height: how far it goes down from z of the point, without end where it is not said."""

    point: Point
    normal: Direction | None = None
    diameter: Diameter | None = Field(default=None, examples=['"30 mm"'])
    inside: bool = False
    height: Diameter | None = Field(default=None, examples=['"20 mm"'])
    offset: str = "G54"


class LogTable(Table):
    """data: time_s (from the start of the program), temp_<sensor>_C. zero_set: when the zeros were set, on the same clock."""

    data: str = Field(examples=['"sensors.csv"'])
    zero_set: str = Field(default="0 s", examples=['"-90 min"'])


class SetupFile(Table):
    """setup/1. set_with: the tool (or probe) with which X and Y of the work offsets were set, the first that cuts if not said."""

    vcmm: str
    machine: str | None = None
    dialect: str | None = None
    decimal_point: Literal["calculator", "increment"] | None = None
    arc_centre: Literal["incremental", "absolute"] | None = None
    block_delete: bool = False
    unit: Literal["mm", "inch"] | None = None
    drawing_dimensions: bool | None = Field(default=None, examples=["true"])
    subprograms: list[str] = Field(default_factory=list, examples=['["../macros"]'])
    offsets: dict[str, Point] = Field(default_factory=dict)
    rotations: dict[str, Angle] = Field(default_factory=dict)
    reference: Point = ZERO
    second_reference: Point = ZERO
    set_with: int | None = Field(default=None, examples=["3"])
    channel: Annotated[int, Field(ge=1, le=9)] = 1
    work_spindles: dict[str, Annotated[int, Field(ge=1, le=9)]] = Field(
        default_factory=dict, examples=["{ G55 = 2 }"]
    )
    tools: dict[str, ToolTable] = Field(default_factory=dict)
    stock: StockTable | None = None
    surfaces: list[SurfaceTable] = Field(default_factory=list)
    temperature: Temperatures | None = None
    temperature_log: LogTable | None = None
    control: dict[str, Any] | None = Field(default=None, examples=['{ tolerance = "10 um" }'])


def load_setup(path: str | Path) -> Setup:
    """Read a set-up file (setup/1).

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Setup
        Machine file, dialect, work offsets, tools, stock, and what the control does.

    Raises
    ------
    DataError
        Every problem of the file, each with its line.
    """
    document = read_toml(path)
    check_version(document, "setup")
    problems = Problems(document)
    model = checked_model(SetupFile, document.data, problems)
    if model is not None:
        _check_names(model, problems)
    tools = {} if model is None else _tools(model, problems)
    control = None
    active: tuple[str, ...] | None = None
    if model is not None and model.control is not None:
        motion = {k: v for k, v in model.control.items() if k != "compensation"}
        control = problems.attempt(("control",), lambda: control_from(motion))
        active = problems.attempt(("control", "compensation"), lambda: _active(model.control or {}))
    if model is not None and model.set_with is not None and model.set_with not in tools:
        numbers = [str(n) for n in tools]
        text = f"tool {model.set_with} is not in the set-up.{choose_from(str(model.set_with), numbers) if numbers else ''}"
        problems.add(("set_with",), f"{text} A probe is a tool too: add its length")
    surfaces = () if model is None or problems.found else _surfaces(model, problems)
    log = None
    if model is not None and model.temperature_log is not None:
        table, near = model.temperature_log, Path(path).parent
        log = problems.attempt(("temperature_log",), lambda: _log(table, near))
    problems.raise_if_any()
    assert model is not None
    folder = Path(path).parent
    return Setup(
        machine=folder / model.machine if model.machine else None, dialect=model.dialect, offsets=dict(model.offsets),
        rotations=dict(model.rotations), tools=tools, reference=model.reference, second_reference=model.second_reference,
        stock=model.stock.box if model.stock else None, stock_corner=model.stock.corner if model.stock else None,
        bar=_bar(model.stock),
        decimal_point=model.decimal_point, arc_centre=model.arc_centre, block_delete=model.block_delete, path=Path(path),
        unit=None if model.unit is None else UNITS[model.unit], drawing_dimensions=model.drawing_dimensions,
        axes=_axes_of(folder / model.machine) if model.machine else None,
        control=control, compensation=active, log=log, set_with=model.set_with, channel=model.channel, work_spindles=dict(model.work_spindles),
        subprograms=tuple(folder / name for name in model.subprograms),
        constants=columns_of(model.temperature) if model.temperature else {},
        material=model.stock.material if model.stock else None,
        thrust=model.stock.thrust_ratio if model.stock else None, surfaces=surfaces,
    )  # fmt: skip


def by_number(tools: Any) -> Any:
    """Return a table of tools with the number 0 for the one that is in the spindle."""
    return (
        {"0" if key == SPINDLE else key: t for key, t in tools.items()} if isinstance(tools, dict) else tools
    )


def _axes_of(machine: Path) -> frozenset[str] | None:
    """Return the letters of the axes of a machine file; None where it cannot be read, which the reader of the machine reports."""
    try:
        axes = read_toml(machine).data.get("axes")
    except VcmmError:
        return None
    return frozenset(axes) if isinstance(axes, dict) and axes else None


def _surfaces(model: SetupFile, problems: Problems) -> tuple[Surface, ...]:
    """Return the surfaces that probing moves meet, machine axes: stated ones, and the box of the stock."""
    out: list[Surface] = []
    for k, surface in enumerate(model.surfaces):
        if (surface.normal is None) == (surface.diameter is None):
            text = "a surface is a plane (point and normal) or a bore or boss along Z (point, diameter, inside); give one of the two"
            problems.add(("surfaces", k), text)
            continue
        if surface.offset not in model.offsets and surface.offset != "G54":
            text = f"{surface.offset} is not in [offsets].{choose_from(surface.offset, [*model.offsets])}"
            problems.add(("surfaces", k, "offset"), text)
            continue
        point = _move_point(surface.point, model.offsets.get(surface.offset, ZERO))
        if surface.diameter is not None:
            low = -math.inf if surface.height is None else point[2] - surface.height
            high = math.inf if surface.height is None else point[2]
            out.append(Round(point, surface.diameter / 2.0, surface.inside, low, high))
        elif surface.normal is not None:
            out.append(Face(point, surface.normal))
    if model.stock is not None and model.stock.box is not None:
        x, y, z = model.stock.box
        corner = model.stock.corner or (-x / 2.0, -y / 2.0, -z)
        zero = model.offsets.get("G54", next(iter(model.offsets.values()), ZERO))
        out += box_faces(_move_point(corner, zero), (x, y, z))
    return tuple(out)


def _move_point(
    point: tuple[float, float, float], by: tuple[float, float, float]
) -> tuple[float, float, float]:
    return point[0] + by[0], point[1] + by[1], point[2] + by[2]


def _log(table: LogTable, folder: Path) -> TemperatureLog:
    """Raises DataError with the lines of the log, UsageError where it holds no temperature or begins after the zero was set."""
    path = folder / table.data
    sensors = {sensor_of(n): s for n, s in read_logs([path]).items() if n.startswith("temp_")}
    if not sensors:
        raise UsageError(f"{path} logs no temperature; it needs time_s and columns temp_<sensor>_C")
    zero_set = quantity(table.zero_set, "time", "zero_set", "-90 min")
    begins = max(float(s.time[0]) for s in sensors.values())
    if min(zero_set, 0.0) < begins:
        raise UsageError(
            f"{path} begins at {begins:g} s, but {'the zeros were set' if zero_set < 0 else 'the program begins'} at {min(zero_set, 0.0):g} s; time_s "
            "counts from the start of the program, and is negative before it"
        )
    return TemperatureLog(sensors, zero_set, path)


def _active(control: dict[str, Any]) -> tuple[str, ...] | None:
    """Return [control] compensation: names of the compensations of the control itself; None where it is not stated."""
    name = control.get("compensation")
    if name is None:
        return None
    if not isinstance(name, list) or not all(isinstance(name, str) for name in name):
        raise UsageError(
            'control.compensation is a list of names, for example compensation = ["pitch"], or [] for none'
        )
    return tuple(name)


def _check_names(model: SetupFile, problems: Problems) -> None:
    if model.dialect is not None and model.dialect not in names():
        problems.add(("dialect",), f'unknown dialect "{model.dialect}".{choose_from(model.dialect, names())}')
    if model.machine == "":
        problems.add(
            ("machine",), 'machine = "" names no file; leave the key out, or write machine = "mill.toml"'
        )
    for table in ("offsets", "rotations", "work_spindles"):
        for name in getattr(model, table):
            if not _OFFSET.fullmatch(name):
                problems.add(
                    (table, name),
                    f'"{name}" is no work offset; write G54 to G59, G59.1 to G59.3, or "G54.1 P1"',
                )
    if model.stock is not None:
        _check_stock(model.stock, problems)


def _check_stock(stock: StockTable, problems: Problems) -> None:
    """Check that the stock is a box or a bar, not both, and that its material has known forces."""
    if (stock.box is None) == (stock.diameter is None):
        text = 'give either box = ["100 mm", "60 mm", "30 mm"] (milling) or diameter = "60 mm" and length = "120 mm" (turning)'
        problems.add(("stock",), text)
        return
    if stock.box is not None and min(stock.box) <= 0:
        problems.add(("stock", "box"), "the sizes of the stock must be positive")
    if stock.diameter is not None and stock.length is None:
        problems.add(("stock",), 'a bar needs its length, for example length = "120 mm"')
    if stock.diameter is not None and stock.bore is not None and not stock.bore < stock.diameter:
        problems.add(("stock", "bore"), "the bore must be smaller than the diameter")
    keys = (*LINEAR_EDGE, *KIENZLE) if stock.box is not None else (*KIENZLE,)
    if stock.material not in (None, *keys):
        text = f'no cutting forces are known of "{stock.material}".{choose_from(str(stock.material), keys)}'
        problems.add(("stock", "material"), text)


def _bar(stock: StockTable | None) -> Bar | None:
    if stock is None or stock.diameter is None or stock.length is None:
        return None
    return Bar(stock.diameter, stock.length, stock.bore or 0.0, stock.front, stock.thrust_ratio)


def _tools(model: SetupFile, problems: Problems) -> dict[int, Tool]:
    out = {}
    for key, table in model.tools.items():
        tool = problems.attempt(("tools", key), lambda key=key, table=table: _tool(key, table))  # type: ignore[misc]
        if tool is not None:
            out[tool.number] = tool
    return out


def _tool(key: str, t: ToolTable) -> Tool:
    """Return one tool, after checking its shape and sizes against each other."""
    if key != SPINDLE and not re.fullmatch(r"[0-9]{1,9}", key):
        raise UsageError(
            f'"{key}" is no tool number; write for example [tools.1], or [tools.{SPINDLE}] for the tool that is in the spindle'
        )
    if t.length < 0 and t.shape != "turning":
        raise TableProblems([("length", NEGATIVE_LENGTH.format(t.length))])
    if wrong := _wrong_sizes(t):
        raise TableProblems(wrong)
    if t.shape == "bull" and t.corner_radius is None:
        raise UsageError('a bull-nosed cutter needs corner_radius, for example corner_radius = "1 mm"')
    if t.corner_radius is not None and t.shape != "bull":
        raise UsageError('corner_radius belongs to shape = "bull"')
    if (t.cutting_length is None) != (t.shank_diameter is None):
        raise UsageError(
            'a shank needs both where it begins and how wide it is: cutting_length = "25 mm" and shank_diameter = "12 mm"'
        )
    if t.shape == "probe" and t.diameter is None:
        raise UsageError('a probe needs the diameter of its ball, for example diameter = "6 mm"')
    if t.driven is not None and t.shape in ("turning", "probe"):
        raise UsageError(
            f'driven belongs to a cutter with its own spindle (flat, ball, bull, drill), not to shape = "{t.shape}"'
        )
    if t.width is not None and (t.shape != "turning" or t.width < 2.0 * (t.nose_radius or 0.0)):
        raise UsageError(
            'width is that of the edge of a groove tool, shape = "turning", at least twice its nose_radius'
        )
    if t.helix is not None and not (t.shape in ("flat", "bull", "ball") and abs(t.helix) <= STEEPEST):
        raise UsageError(
            "helix is that of the edges of a flat, bull or ball mill, 0 to 70 deg (negative: left-hand)"
        )
    if t.nose_radius is not None and t.shape != "turning":
        raise UsageError('nose_radius belongs to shape = "turning"')
    if t.corner_radius and t.diameter is not None and 2.0 * t.corner_radius > t.diameter:
        raise UsageError(
            f"corner_radius of {t.corner_radius:g} mm is more than half the diameter of {t.diameter:g} mm"
        )
    return Tool(
        number=0 if key == SPINDLE else int(key), length=t.length, diameter=t.diameter, shape=t.shape, corner_radius=t.corner_radius or 0.0, nose_radius=t.nose_radius, orientation=t.orientation, offset_x=t.offset_x,
        offset_y=t.offset_y, name=t.name, teeth=t.teeth, helix=t.helix, stick_out=t.stick_out, cutting_length=t.cutting_length, shank_diameter=t.shank_diameter, driven=t.driven, width=t.width,
        length_stated="length" in t.model_fields_set,
    )  # fmt: skip


def _wrong_sizes(t: ToolTable) -> list[tuple[str, str]]:
    """Return (key, problem) of sizes that no tool has: um or m was written for mm."""
    out = []
    for key, (least, most) in TOOL_SIZES.items():
        value = getattr(t, key)
        if value is not None and not least <= abs(value) <= most:
            limits = f"{least:g} to {most:g} mm" if least else f"at most {most:g} mm"
            out.append((key, f"{key} is {value:g} mm, and a tool has {limits}; check its unit"))
    return out
