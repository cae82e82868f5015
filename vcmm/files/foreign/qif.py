"""QIF 3.0 (ISO 23952): the document, its units, and the targets of its ids."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import brief
from vcmm.files.foreign.xml import Node, number, numbers, read_xml

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
