"""QIF 3.0 (ISO 23952): the document, its units, the targets of its ids, and the measuring machine.

The 21 errors of a Cartesian CMM in QIF 3.0 (CartesianCMMFPSTest) by their ISO 230-1 names, and its ISO 10360 test.

    XLinearity EXX   XAxisStraightnessY EYX   XAxisStraightnessZ EZX   XAxisRoll EAX   XAxisPitch EBX   XAxisYaw ECX
    YLinearity EYY   YAxisStraightnessX EXY   YAxisStraightnessZ EZY   YAxisRoll EBY   YAxisPitch EAY   YAxisYaw ECY
    ZLinearity EZZ   ZAxisStraightnessX EXZ   ZAxisStraightnessY EYZ   ZAxisRoll ECZ   ZAxisPitch EAZ   ZAxisYaw EBZ
    XYSquareness C0Y, XZSquareness B0Z, YZSquareness A0Z

Signs. QIF states for a linearity "measured by high-accuracy methods minus reported by the CMM": true - indicated, which
is -(indicated - true) of a measuring machine; the tip of a machine that indicates too little is too far, so the value
is the error of the tip, EXX as here. A squareness is positive where the angle between the positive axes exceeds 90 deg. In
this package's frame (conventions.md) a positive C0Y turns Y about +Z, away from +X: the angle grows, the sign is the
same; a positive A0Z turns Z about +X, towards -Y: the angle from Y grows, the same; a positive B0Z turns Z about +Y,
towards +X: the angle from X shrinks, so B0Z = -XZSquareness. For straightness and angles QIF fixes no sign: they are taken
as ISO 230-1 has them, and which of two tilts of Z is its pitch is a convention as well (about X here). A note states both.
Source: ISO 23952:2020, QIF 3.0, MeasurementResources.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import brief
from vcmm.files.foreign.drawing import mm, toml_value
from vcmm.files.foreign.xml import Node, number, numbers, read_xml, series

CURVES = {
    "X": {"XLinearity": "EXX", "XAxisStraightnessY": "EYX", "XAxisStraightnessZ": "EZX",
          "XAxisRoll": "EAX", "XAxisPitch": "EBX", "XAxisYaw": "ECX"},
    "Y": {"YAxisStraightnessX": "EXY", "YLinearity": "EYY", "YAxisStraightnessZ": "EZY",
          "YAxisPitch": "EAY", "YAxisRoll": "EBY", "YAxisYaw": "ECY"},
    "Z": {"ZAxisStraightnessX": "EXZ", "ZAxisStraightnessY": "EYZ", "ZLinearity": "EZZ",
          "ZAxisPitch": "EAZ", "ZAxisYaw": "EBZ", "ZAxisRoll": "ECZ"},
}  # fmt: skip
SQUARENESS = {"XYSquareness": ("C0Y", 1.0), "XZSquareness": ("B0Z", -1.0), "YZSquareness": ("A0Z", 1.0)}
UNITS_MM = {"mm": 1.0, "um": 1e-3, "inch": 25.4, "in": 25.4, "meter": 1e3, "m": 1e3}
UNITS_RAD = {
    "radian": 1.0,
    "rad": 1.0,
    "degree": np.pi / 180,
    "deg": np.pi / 180,
    "arcsecond": np.pi / 648000,
}
CONVENTIONS = (
    "QIF fixes no sign for straightness and angles: they are taken as ISO 230-1 has them (tip error, right-handed)",
    "pitch of Z is taken as its tilt about X (EAZ), yaw of Z as that about Y (EBZ)",
)


@dataclass(frozen=True, eq=False)
class QifMachine:
    """curves: axis -> name -> (positions (n,), values (n,)) in mm and rad; squareness in rad; MPE: base um, rate um/mm."""

    name: str
    curves: dict[str, dict[str, tuple[Array, Array]]]
    squareness: dict[str, float]
    mpe: tuple[float, float] | None
    notes: tuple[str, ...]


def read_qif_machine(path: str | Path) -> QifMachine:
    """Raises DataError with file and line: no Cartesian CMM with errors or a test, unknown units, positions out of order."""
    qif = read_qif(path)
    cmm = next((n for n in qif.root.below() if n.name == "CartesianCMM"), None)
    if cmm is None:
        raise DataError(
            f"{qif.root.at}: this document describes no CartesianCMM; other machines are not read"
        )
    test = next((n for n in cmm.below() if n.name == "CartesianCMMFPSTest"), None)
    mpe = _mpe(qif, cmm)
    if test is None and mpe is None:
        raise DataError(
            f"{cmm.at}: this machine has neither CartesianCMMFPSTest (its errors) nor CartesianCMMISO10360Test (its MPE)"
        )
    curves = {axis: _curves(qif, test, names) for axis, names in CURVES.items()} if test else {}
    square = {} if test is None else {
        name: sign * qif.to_rad * number(node)
        for key, (name, sign) in SQUARENESS.items() if (node := test.one(key)) is not None
    }  # fmt: skip
    notes = CONVENTIONS if test is not None else ()
    return QifMachine(
        cmm.words("Name") or qif.path.stem, {a: c for a, c in curves.items() if c}, square, mpe, notes
    )


def machine_files(machine: QifMachine, source: str) -> dict[str, str]:
    """Return machine.toml, and errors.csv where the file holds errors: the texts by name."""
    travels = _travels(machine)
    lines = [f"# {machine.name}, from {source}", *(f"# {n}" for n in machine.notes), 'vcmm = "machine/1"']
    lines += [f"name = {toml_value(machine.name)}", 'kind = "cmm"', 'structure = "w b Y X Z t"   # the file does not say it: correct it']  # fmt: skip
    for axis, (low, high) in travels.items():
        lines += [f"[axes.{axis}]", f"travel = [{toml_value(mm(low))}, {toml_value(mm(high))}]"]
    if machine.curves:
        lines += ["[errors]", 'table = "errors.csv"', 'state = "residual"']
    if machine.mpe is not None:
        base, rate = machine.mpe
        stated = f"{base:.6g} um + L/{1.0 / rate:.6g}" if rate else f"{base:.6g} um"
        head = "" if not machine.curves else "# "
        lines += [f"{head}[certificate]", f'{head}E0_MPE = "{stated}"']
        if head:
            lines[-2] = "# its certificate, for another machine file: [certificate]"
    texts = {"machine.toml": "\n".join(lines) + "\n"}
    return texts | ({"errors.csv": _table(machine)} if machine.curves else {})


def _table(machine: QifMachine) -> str:
    """Return the errors in the format of errors.csv: a table per axis, squareness in one of its own."""
    blocks = []
    for axis, curves in machine.curves.items():
        positions = np.unique(np.concatenate([p for p, _ in curves.values()]))
        rows = [[axis, *curves]]
        rows += [
            [f"{q:.12g}", *(f"{np.interp(q, p, v):.12g}" for p, v in curves.values())] for q in positions
        ]
        blocks.append("\n".join(" ".join(row) for row in rows))
    if machine.squareness:
        blocks.append(
            " ".join(machine.squareness) + "\n" + " ".join(f"{v:.12g}" for v in machine.squareness.values())
        )
    return "// mm and rad\n" + "\n#\n".join(blocks) + "\n"


def _travels(machine: QifMachine) -> dict[str, tuple[float, float]]:
    if not machine.curves:
        return {"X": (0.0, 600.0), "Y": (0.0, 500.0), "Z": (-400.0, 0.0)}
    return {
        axis: (min(p[0] for p, _ in c.values()), max(p[-1] for p, _ in c.values()))
        for axis, c in machine.curves.items()
    }


def _curves(qif: Qif, test: Node, names: dict[str, str]) -> dict[str, tuple[Array, Array]]:
    out = {}
    for key, name in names.items():
        node = test.one(key)
        if node is not None:
            out[name] = _curve(qif, node, angle=key[1:] in ("AxisRoll", "AxisPitch", "AxisYaw"))
    return out


def _curve(qif: Qif, node: Node, angle: bool) -> tuple[Array, Array]:
    domain, values = node.one("DomainValues"), node.one("RangeValues")
    if domain is None or values is None:
        raise DataError(f"{node.at}: <{node.name}> needs DomainValues and RangeValues")
    q, v = series(domain)[:, 0], series(values)[:, 0]
    if len(q) != len(v):
        raise DataError(f"{node.at}: <{node.name}> has {len(q)} positions and {len(v)} values")
    if len(q) < 2 or not (np.diff(q) > 0).all():
        raise DataError(f"{domain.at}: the positions of <{node.name}> must be two or more and increase")
    scale = _unit(node, "RangeAngularUnit", UNITS_RAD, qif.to_rad) if angle else _unit(node, "RangeLinearUnit", UNITS_MM, qif.to_mm)  # fmt: skip
    return _unit(node, "DomainLinearUnit", UNITS_MM, qif.to_mm) * q, scale * v


def _unit(node: Node, key: str, units: dict[str, float], default: float) -> float:
    at = node.one(key)
    if at is None:
        return default
    if at.text.strip() not in units:
        raise DataError(f'{at.at}: the unit "{at.text.strip()}" is not one of {", ".join(units)}')
    return units[at.text.strip()]


def _mpe(qif: Qif, cmm: Node) -> tuple[float, float] | None:
    """Return MPE_E0 = base um + rate um/mm times L."""
    test = next((n for n in cmm.below() if n.name == "CartesianCMMISO10360Test"), None)
    base = None if test is None else test.one("LinearError/BaseError")
    rate = None if test is None else test.one("LinearError/ErrorRate")
    if base is None or rate is None:
        return None
    return 1e3 * qif.length(base), 1e3 * number(rate)


NAMESPACE = "http://qifstandards.org/xsd/qif3"


@dataclass(frozen=True, eq=False)
class Qif:
    """A document: root, factors from its units to mm and rad, nodes by id."""

    path: Path
    root: Node
    to_mm: float
    to_rad: float
    by_id: dict[str, Node]

    def node_at(self, node: Node, path: str) -> Node | None:
        """Return the node whose id is given along a path below `node`; None where no id is given. DataError for an unknown id."""
        at = node.one(path)
        if at is None:
            return None
        target = self.by_id.get(at.text.strip())
        if target is None:
            raise DataError(f'{at.at}: the id "{brief(at.text.strip())}" belongs to nothing in this file')
        return target

    def length(self, node: Node) -> float:
        """Return a length in mm. Raises DataError: no number, another unit than that of the file."""
        _own_unit(node, "linearUnit")
        return self.to_mm * number(node)

    def angle(self, node: Node) -> float:
        """Return an angle in rad."""
        _own_unit(node, "angularUnit")
        return self.to_rad * number(node)

    def place(self, node: Node) -> Array:
        """Return three lengths in mm."""
        _own_unit(node, "linearUnit")
        return self.to_mm * np.array(numbers(node, 3))


def is_qif(path: str | Path) -> bool:
    """Return whether a file is named as QIF files are."""
    return str(path).lower().endswith(".qif")


def read_qif(path: str | Path) -> Qif:
    """Raises DataError with file and line: no QIF, another version than 3, units missing, an id given twice."""
    root = read_xml(path)
    if root.name != "QIFDocument":
        raise DataError(
            f"{root.at}: the root is <{brief(root.name)}>, not <QIFDocument>: this is no QIF file"
        )
    version = root.attributes.get("versionQIF", "")
    if not version.startswith("3."):
        raise DataError(f'{root.at}: versionQIF = "{brief(version)}"; version 3 is read (ISO 23952)')
    by_id: dict[str, Node] = {}
    for node in root.below():
        if (key := node.attributes.get("id")) is not None:
            if key in by_id:
                raise DataError(f'{node.at}: the id "{brief(key)}" is used here and at {by_id[key].at}')
            by_id[key] = node
    units = root.one("FileUnits/PrimaryUnits")
    if units is None:
        raise DataError(f"{root.at}: FileUnits/PrimaryUnits are missing, so no length has a unit")
    return Qif(Path(path), root, 1000.0 * _factor(units, "LinearUnit", 1.0), _angle(units), by_id)


def _factor(units: Node, name: str, default: float) -> float:
    node = units.one(name)
    if node is None:
        raise DataError(f"{units.at}: <{name}> is missing in PrimaryUnits")
    factor = node.one("UnitConversion/Factor")
    if factor is None:
        si = node.words("SIUnitName") or node.words("UnitName")
        if si not in ("meter", "metre", "radian"):
            raise DataError(f'{node.at}: the unit "{brief(si)}" has no UnitConversion/Factor to SI')
        return default
    value = number(factor)
    if value <= 0.0:
        raise DataError(f"{factor.at}: a factor of {value:g} to SI is no unit")
    return value


def _angle(units: Node) -> float:
    node = units.one("AngularUnit")
    factors = {"degree": math.pi / 180.0, "deg": math.pi / 180.0, "radian": 1.0, "rad": 1.0}
    if node is not None and node.one("UnitConversion/Factor") is None and node.words("UnitName") in factors:
        return factors[node.words("UnitName")]
    return 1.0 if node is None else _factor(units, "AngularUnit", 1.0)


def _own_unit(node: Node, kind: str) -> None:
    if kind in node.attributes:
        raise DataError(
            f'{node.at}: <{node.name}> has a unit of its own ({kind} = "{brief(node.attributes[kind])}"); '
            "only the primary units of the file are read"
        )
