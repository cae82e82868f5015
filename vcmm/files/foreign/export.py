"""Write results for other systems, by the ending of the file: .qif (QIF 3.0), .dfq (Q-DAS), .xml (results of a DCC).

Q-DAS ASCII transfer format (.dfq): characteristics with limits and the measured values of all parts, K-fields.

    K0100 number of characteristics     K1001 part number, K1002 part name      K2001/i number, K2002/i name of characteristic
    K2022/i decimals                    K2101/i nominal                         K2110/i, K2111/i lower, upper limit
    K2112/i, K2113/i allowances: limits from nominal    K2142/i unit            K2900/i remark: knowledge about the true value
    K0001/i value, K0002/i attribute (0 valid, 255 no value)    K0014/i part, where there are several

The format has no field for a measurement uncertainty of a value: it is in the remark of the characteristic.
Source: Q-DAS ASCII Transferformat V13, key catalogue.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError, choose_from
from vcmm.files.foreign.dcc import dcc_results
from vcmm.files.foreign.exported_values import HandedValue, handed_over
from vcmm.files.foreign.qif_results import qif_text
from vcmm.part.part import Part

DECIMALS = 7  # 0.1 nm, where U is not stated


def dfq_text(part: str, values: Mapping[str, Sequence[HandedValue]]) -> str:
    """Return the text of a file. values: by part, each with the same characteristics; angles in degrees. UsageError otherwise."""
    first = next(iter(values.values()))
    for name, part_values in values.items():
        if [v.name for v in part_values] != [v.name for v in first]:
            raise UsageError(
                f'the part "{name}" has other characteristics than the first one; export them apart'
            )
    lines = [f"K0100 {len(first)}", f"K1001 {_plain(part)}", f"K1002 {_plain(part)}"]
    decimals = [
        max(
            [_places(part_values[i]) for part_values in values.values() if part_values[i].interval]
            or [DECIMALS]
        )
        for i in range(len(first))
    ]
    for i, v in enumerate(first, 1):
        lines += _characteristic(i, v, decimals[i - 1])
    for name, part_values in values.items():
        for i, v in enumerate(part_values, 1):
            lines += [f"K0014/{i} {_plain(name)}"] if name else []
            lines += [f"K0001/{i} {_number(v.measured, v.unit, decimals[i - 1])}", f"K0002/{i} 0"]
    return "\r\n".join(lines) + "\r\n"


def _places(v: HandedValue) -> int:
    """Return the decimals of the value in the unit of the file, by its U."""
    places = v.places(1.0 if v.unit == "mm" else math.degrees(1.0))
    return DECIMALS if places is None else places


def _characteristic(i: int, v: HandedValue, decimals: int) -> list[str]:
    out = [f"K2001/{i} {i}", f"K2002/{i} {_plain(v.name)}", f"K2022/{i} {decimals}"]
    out.append(f"K2101/{i} {_number(v.nominal, v.unit)}")
    if v.tolerance is not None:
        low, high = v.tolerance
        out += [f"K2110/{i} {_number(low, v.unit)}", f"K2111/{i} {_number(high, v.unit)}"]
        out += [
            f"K2112/{i} {_number(low - v.nominal, v.unit)}",
            f"K2113/{i} {_number(high - v.nominal, v.unit)}",
        ]
    out.append(f"K2142/{i} {'mm' if v.unit == 'mm' else 'deg'}")
    out.append(f"K2900/{i} {_plain(_true_value_remark(v))}")
    return out


def _true_value_remark(v: HandedValue) -> str:
    """Return the remark about the true value: value +- U, its interval, or why neither is stated."""
    unit = "mm" if v.unit == "mm" else "deg"
    if v.interval is None:
        return v.why or "the interval of the true value has no end"
    if v.about and v.U is not None:
        return f"U = {_number(v.U, v.unit, _places(v))} {unit}, k = {v.k:.4g}, {v.p:.4g}"
    low, high = (_number(end, v.unit, _places(v)) for end in v.interval)
    return f"true value {low} to {high} {unit}, {v.p:.4g}"


def _number(value: float, unit: str, decimals: int = DECIMALS) -> str:
    return f"{value if unit == 'mm' else math.degrees(value):.{decimals}f}"


def _plain(text: str) -> str:
    """Return one line without control characters; the catalogue allows 80 characters."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())[:80]


ENDINGS = (".qif", ".dfq", ".xml")


def check_ending(path: str | Path) -> None:
    """Raise UsageError for a file whose ending names no system."""
    if Path(path).suffix.lower() not in ENDINGS:
        given = Path(path).suffix
        raise UsageError(
            f'--export {path}: the ending "{given}" names no format.{choose_from(given, ENDINGS)}'
        )


def export_text(
    path: str | Path, name: str, part: Part, document: Mapping[str, Any]
) -> tuple[str, tuple[str, ...]]:
    """Return the text of the file and notes on content that it cannot express. name: of the task; document: the output of `evaluate --json`."""
    check_ending(path)
    values = handed_over(document)
    ending = Path(path).suffix.lower()
    if ending == ".qif":
        return qif_text(part, values, json.dumps(document, sort_keys=True))
    return (dfq_text(name, values) if ending == ".dfq" else dcc_results(name, values)), ()
