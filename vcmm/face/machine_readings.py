"""Readings of results about machines, recordings and programs; see `vcmm.face.readings`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vcmm.core.readable import Reading
from vcmm.face.readings import Rows, make_reading

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.program.summary import ProgramSummary
    from vcmm.show.tables.table import ResultTable
    from vcmm.task.response.recording import Recording


def diagnosis_reading(recording: Recording, machine: Machine) -> Reading:
    """Return the reading of `diagnose`."""
    from vcmm.learn.diagnosis.result import diagnosis_json
    from vcmm.show.pages.diagnosis import diagnosis_page, sentences
    from vcmm.show.tables.diagnosis import answers

    return make_reading(
        "vcmm.diagnosis/1",
        lambda d: {k: v for k, v in diagnosis_json(d).items() if k != "schema"} | {"improved_machine": None},
        rows=lambda body: body["answer"],
        tables=answers,
        summary=lambda d: [("verdict", text) for text in sentences(d)],
        page=lambda d: diagnosis_page(recording, machine, d),
    )


def calibration_reading() -> Reading:
    """Return the reading of `calibrate`."""
    from vcmm.face.bodies import calibration_json
    from vcmm.show.pages.calibration import calibration_page
    from vcmm.show.tables.calibration import errors

    return make_reading(
        "vcmm.calibration/1",
        lambda c: calibration_json(c, None) | {"tests": []},
        rows=lambda body: body["identified"],
        tables=lambda c: [errors(c)],
        page=calibration_page,
    )


def compensation_reading(program: Path) -> Reading:
    """Return the reading of `compensate`; the proof by a cut is that of the command, which knows the part."""
    from vcmm.core.errors import UsageError
    from vcmm.face.bodies import compensation_json
    from vcmm.shop.machining.proof import proof_without_inspection
    from vcmm.show.pages.path import compensation_page
    from vcmm.show.tables.compensation import before_and_after, departures

    no_cut = proof_without_inspection("this call rewrites a program; vcmm compensate SCENARIO cuts it too")

    def page(result: Any) -> str:
        if result.paths is None:
            raise UsageError("the report draws both paths: call compensate(..., follow=True)")
        return compensation_page(result, program)

    return make_reading(
        "vcmm.compensation/1",
        lambda c: compensation_json(c, None, no_cut),
        rows=lambda body: [{"path": k, **v} for k, v in body["deviation"].items() if v is not None],
        tables=lambda c: [departures(c, before_and_after(c))],
        page=page,
    )


def field_reading(machine: Machine) -> Reading:
    """Return the reading of `field`."""
    from vcmm.show.pages.field import field_page
    from vcmm.show.tables.error_field import field_json, maxima
    from vcmm.task.response.volumetric import missing_columns

    def body(error_map: Any) -> dict[str, Any]:
        absent = missing_columns(machine, error_map.run)
        return {**field_json(error_map), "not_mapped": {name: list(columns) for name, columns in absent}}

    def rows(error_map: Any) -> Rows:
        at = [
            {f"{a}_{'mm' if a in 'XYZ' else 'rad'}": float(q[i]) for a, q in error_map.run.position.items()}
            for i in range(error_map.run.n)
        ]
        rows_of = zip(at, error_map.tip_error, error_map.tip_error if error_map.u is None else error_map.u)
        return [
            place
            | {f"error_{c}_mm": float(e[i]) for i, c in enumerate("xyz")}
            | ({} if error_map.u is None else {f"u_{c}_mm": float(u[i]) for i, c in enumerate("xyz")})
            for place, e, u in rows_of
        ]

    reading = make_reading(
        "vcmm.field/1",
        body,
        rows=lambda document: (),
        tables=lambda f: [maxima(machine, f)],
        page=lambda f: field_page(machine, f),
        warnings=lambda f: (),
    )
    return replace(reading, rows=rows)


def figures_reading(
    iso: str, table: ResultTable[Any], files: Sequence[str | Path], seed: int, warnings: Sequence[str]
) -> Reading:
    """Return the reading of `test`."""
    from vcmm.show.tables.calibration import figure_columns
    from vcmm.show.tables.table import records

    return make_reading(
        "vcmm.test/1",
        lambda figures: {"test": f"ISO {iso}", "figures": records(figure_columns(iso), figures)},
        rows=lambda body: body["figures"],
        tables=lambda figures: [table],
        files=files,
        seed=lambda figures: seed,
        warnings=lambda figures: warnings,
    )


def comparison_reading(files: Sequence[str | Path], seed: int, warnings: Sequence[str]) -> Reading:
    """Return the reading of `compare`."""
    from vcmm.learn.diagnosis.comparison import comparison_json
    from vcmm.show.pages.compare import compare_page
    from vcmm.show.tables.comparison import tables

    return make_reading(
        "vcmm.compare/1",
        comparison_json,
        rows=lambda body: body["machines"],
        tables=tables,
        page=compare_page,
        files=files,
        seed=lambda rows: seed,
        warnings=lambda rows: warnings,
    )


def program_reading(
    program: Path, total: ProgramSummary, machine: Machine | None, files: Sequence[str | Path]
) -> Reading:
    """Return the reading of `nc`."""
    from vcmm.program.reading import read_bytes
    from vcmm.show.console.program_document import nc_json
    from vcmm.show.pages.program import program_page
    from vcmm.show.tables import program as tables

    letters = "".join(machine.axes) if machine else "ABC"

    def body(p: Any) -> dict[str, Any]:
        return nc_json(p.program, total) | {"moves": [tables.move_json(m, letters) for m in p.moves]}

    reading = make_reading(
        "vcmm.nc/1",
        body,
        rows=lambda document: document["moves"],
        tables=lambda p: [tables.kinds(program.name, p.program, total), tables.extents(p.program, total)],
        page=lambda p: program_page(program.name, p.program, total, read_bytes(program), machine),
        warnings=lambda p: (),
    )

    def document_of(p: Any) -> dict[str, Any]:  # warnings of a program have a line and a column
        from vcmm.show.console.documents import document

        return document("vcmm.nc/1", {}, files=[Path(f) for f in files]) | body(p)

    return replace(reading, document=document_of)


def converted_reading(file: Path) -> Reading:
    """Return the reading of `convert`."""
    return make_reading(
        "vcmm.convert/1",
        lambda c: c.body(),
        rows=lambda body: [{"what": what, "count": n} for what, n in body["counts"].items()],
        summary=lambda c: [(c.kind, ", ".join(f"{n} {what}" for what, n in c.counts.items()))],
        files=[file],
        warnings=lambda c: (*c.notes, *c.problems),
    )
