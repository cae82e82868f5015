"""Digital calibration certificates (DCC of PTB, schema 2.4 to 3.3): the quantities of their results, in and out.

A quantity holds values (real, a list of reals, or a hybrid of the same values in several units: the first one is taken)
with a unit of D-SI and, where stated, the expanded uncertainty with its coverage factor; u = U / k.
Source: PTB, DCC schema 3.3.0 and D-SI data model 2.2 (SmartCom, doi 10.5281/zenodo.4709001).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from vcmm.core.errors import DataError
from vcmm.core.text import brief, csv_of
from vcmm.files.foreign.exported_values import HandedValue
from vcmm.files.foreign.xml import Node, read_xml, series

UNITS = {  # unit of D-SI -> the word here and the factor to it
    r"\metre": ("mm", 1e3), r"\milli\metre": ("mm", 1.0), r"\micro\metre": ("um", 1.0), r"\nano\metre": ("um", 1e-3),
    r"\radian": ("rad", 1.0), r"\micro\radian": ("urad", 1.0), r"\degree": ("deg", 1.0), r"\kelvin": ("K", 1.0),
    r"\degreecelsius": ("degC", 1.0), r"\one": ("1", 1.0), r"\kilogram": ("kg", 1.0), r"\newton": ("N", 1.0),
    r"\second": ("s", 1.0), r"\hertz": ("Hz", 1.0), r"\pascal": ("Pa", 1.0), r"\ohm": ("ohm", 1.0),
}  # fmt: skip
STATED = (
    "uncertainty", "valueExpandedMU", "coverageFactor", "coverageProbability", "valueStandardMU", "standardUnc",
    "intervalMin", "intervalMax",
)  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """One value of a certificate: its place in it, its unit in vcmm, expanded uncertainty U with factor k (None: not stated).

    interval: ends of a coverage interval that is stated in place of U, with the standard uncertainty; p: coverage probability of either.
    """

    section: str
    name: str
    value: float
    unit: str
    U: float | None
    k: float | None
    at: str
    standard: float | None = None
    interval: tuple[float, float] | None = None
    p: float | None = None

    @property
    def u(self) -> float | None:
        """Standard uncertainty: as stated beside an interval, or U / k."""
        return self.standard if self.U is None or not self.k else self.U / self.k


def read_dcc(path: str | Path) -> tuple[Quantity, ...]:
    """Read all quantities of the measurement results, of a whole certificate or of its measurementResults alone, as `evaluate --export` writes them.

    Raises DataError with file and line: no DCC, numbers without unit.
    """
    root = read_xml(path)
    if root.name not in ("digitalCalibrationCertificate", "measurementResults"):
        raise DataError(f"{root.at}: the root is <{brief(root.name)}>, not a digitalCalibrationCertificate")
    out: list[Quantity] = []
    above = "" if root.name == "measurementResults" else "measurementResults/"
    for result in root.many(f"{above}measurementResult"):
        for section in ("influenceConditions/influenceCondition", "results/result"):
            for block in result.many(section):
                label = _label(block) or block.attributes.get("refType", "")
                for node in (n for n in block.below() if n.name == "quantity"):
                    out += _quantities(node, label)
    if not out:
        raise DataError(f"{root.at}: this certificate holds no quantities")
    return tuple(out)


def quantities_csv(quantities: Sequence[Quantity]) -> str:
    """Return quantities as a table: section, name, value, unit, U, k, u, ends of the interval where one is stated, p."""
    rows = [
        [
            q.section,
            q.name,
            f"{q.value:.12g}",
            q.unit,
            *("" if v is None else f"{v:.12g}" for v in (q.U, q.k, q.u, *(q.interval or (None, None)), q.p)),
        ]
        for q in quantities
    ]
    return csv_of(
        [["section", "name", "value", "unit", "U", "k", "u", "interval_min", "interval_max", "p"], *rows]
    )


def _quantities(node: Node, section: str) -> list[Quantity]:
    name = _label(node) or node.attributes.get("refType", "") or "quantity"
    kinds = ("real", "realListXMLList", "hybrid", "constant")
    content = next((c for c in node.children if c.name in kinds), None)
    if content is None:
        return []
    if content.name == "hybrid":
        content = next((c for c in content.children if c.name in ("real", "realListXMLList")), content)
    if content.name == "realListXMLList":
        return _list(content, section, name)
    value, unit = content.one("value"), content.one("unit")
    if value is None or unit is None:
        raise DataError(f"{content.at}: the quantity {brief(name)} has no value or no unit")
    word, factor = _unit(unit, unit.text.strip())
    number = float(series(value)[0, 0])
    return [
        Quantity(
            section=section,
            name=name,
            value=factor * number,
            unit=word,
            at=content.at,
            **_uncertainty(content, factor),
        )
    ]


def _list(content: Node, section: str, name: str) -> list[Quantity]:
    values, units = content.one("valueXMLList"), content.one("unitXMLList")
    if values is None or units is None:
        raise DataError(f"{content.at}: the list {brief(name)} has no values or no units")
    numbers, words = series(values)[:, 0], units.text.split()
    words = words * len(numbers) if len(words) == 1 else words
    if len(words) != len(numbers):
        raise DataError(f"{units.at}: {len(words)} units of {len(numbers)} values")
    U, k = (
        _spread(content, "uncertaintyXMLList", len(numbers)),
        _spread(content, "coverageFactorXMLList", len(numbers)),
    )
    out = []
    for i, (number, word) in enumerate(zip(numbers, words)):
        unit, factor = _unit(units, word)
        wide = None if U is None else factor * U[i]
        quantity = Quantity(
            section=section, name=f"{name} {i + 1}", value=factor * float(number), unit=unit, U=wide,
            k=None if k is None else k[i], at=content.at,
        )  # fmt: skip
        out.append(quantity)
    return out


def _spread(content: Node, name: str, count: int) -> list[float] | None:
    """Return the numbers of a list within the uncertainties, one for all or one each."""
    node = next(
        (n for n in content.below() if n.name in (name, name.replace("uncertainty", "valueExpandedMU"))), None
    )
    if node is None:
        return None
    numbers = [float(v) for v in series(node)[:, 0]]
    if len(numbers) not in (1, count):
        raise DataError(f"{node.at}: {len(numbers)} numbers for {count} values")
    return numbers * count if len(numbers) == 1 else numbers


def _uncertainty(content: Node, factor: float) -> dict[str, Any]:
    """Return the keys of a Quantity: an expanded uncertainty with its factor (of a standard uncertainty alone 1), or an interval with its ends; p."""
    nodes = {n.name: n for n in content.below()}
    by_name = {name: float(series(n)[0, 0]) for name, n in nodes.items() if name in STATED}
    p = by_name.get("coverageProbability")
    for name in ("uncertainty", "valueExpandedMU"):
        if name in by_name:
            if "coverageFactor" not in by_name:
                raise DataError(f"{nodes[name].at}: an expanded uncertainty without its coverage factor")
            return {"U": factor * by_name[name], "k": by_name["coverageFactor"], "p": p}
    standard = by_name.get("valueStandardMU", by_name.get("standardUnc"))
    standard = None if standard is None else factor * standard
    if "intervalMin" in by_name and "intervalMax" in by_name:
        ends = factor * by_name["intervalMin"], factor * by_name["intervalMax"]
        return {"U": None, "k": None, "p": p, "standard": standard, "interval": ends}
    return {"U": standard, "k": None if standard is None else 1.0}


def _unit(node: Node, word: str) -> tuple[str, float]:
    """Return the unit in vcmm and its factor; an unknown unit does not change."""
    if not word:
        raise DataError(f"{node.at}: the unit is empty")
    return UNITS.get(word.replace(" ", ""), (word, 1.0))


def _label(node: Node) -> str:
    """Name in English where there is one, else the first language."""
    contents = node.many("name/content")
    english = [c for c in contents if c.attributes.get("lang") == "en"]
    return next((c.text.strip() for c in (english or contents)), "")


def dcc_results(title: str, values: Mapping[str, Sequence[HandedValue]]) -> str:
    """Return the element measurementResults of a DCC with the evaluated values, to be put into a laboratory's certificate.

    A value whose interval is value +- U has the expanded uncertainty; another interval (a corrected bias, a form) is written by
    its ends; where coverage is not demonstrated, neither is written. The laboratory adds administrativeData and its signature.
    """
    blocks = []
    for part, listed in values.items():
        rows = "\n".join(_value_xml(v) for v in listed)
        name = f"{title} {part}".strip()
        blocks.append(
            f"<dcc:result><dcc:name><dcc:content>{escape(name)}</dcc:content></dcc:name>\n<dcc:data>\n{rows}\n</dcc:data></dcc:result>"
        )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<dcc:measurementResults xmlns:dcc="https://ptb.de/dcc" xmlns:si="https://ptb.de/si">\n<dcc:measurementResult>\n'
        f"<dcc:name><dcc:content>{escape(title)}</dcc:content></dcc:name>\n<dcc:results>\n"
        + "\n".join(blocks)
        + "\n</dcc:results>\n</dcc:measurementResult>\n</dcc:measurementResults>\n"
    )


def _value_xml(v: HandedValue) -> str:
    unit = r"\milli\metre" if v.unit == "mm" else r"\radian"
    spread, places = "", v.places()
    if v.about and v.U is not None and v.k:
        spread = (
            f"<si:expandedMU><si:valueExpandedMU>{_digits(v.U, places)}</si:valueExpandedMU><si:coverageFactor>{v.k:.3g}</si:coverageFactor>"
            f"<si:coverageProbability>{v.p:.6g}</si:coverageProbability></si:expandedMU>"
        )
    elif v.interval is not None:
        low, high = v.interval
        spread = (
            f"<si:coverageIntervalMU><si:valueStandardMU>{v.u or 0.0:.3g}</si:valueStandardMU>"
            f"<si:intervalMin>{_digits(low, places)}</si:intervalMin><si:intervalMax>{_digits(high, places)}</si:intervalMax>"
            f"<si:coverageProbability>{v.p:.6g}</si:coverageProbability></si:coverageIntervalMU>"
        )
    if spread:
        spread = f"<si:measurementUncertaintyUnivariate>{spread}</si:measurementUncertaintyUnivariate>"
    return (
        f"<dcc:quantity><dcc:name><dcc:content>{escape(v.name)}</dcc:content></dcc:name>"
        f"<si:real><si:value>{_digits(v.measured, places)}</si:value><si:unit>{unit}</si:unit>{spread}</si:real></dcc:quantity>"
    )


def _digits(value: float, places: int | None) -> str:
    """Return a number to the place of the last digit of U; all its digits where U is not stated."""
    return f"{value:.12g}" if places is None else f"{value:.{places}f}"
