"""Readings of the results of `import vcmm`: the document of `--json`, rows, the report, a notebook. One `Reading` for each job
on parts; those on machines and programs are in `machine_readings`."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vcmm.core.readable import Reading

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import UncertaintyResult
    from vcmm.answer.inference.job import EvaluatedPart
    from vcmm.show.tables.table import ResultTable
    from vcmm.task.measuring.cut_scenario import CutScenario
    from vcmm.task.measuring.scenario import Scenario

Rows = Sequence[Mapping[str, Any]]


def make_reading(
    schema: str,
    body: Callable[[Any], dict[str, Any]],
    *,
    rows: Callable[[dict[str, Any]], Rows],
    tables: Callable[[Any], Iterable[ResultTable[Any]]] = lambda result: (),
    summary: Callable[[Any], Iterable[tuple[str, str]]] = lambda result: (),
    page: Callable[[Any], str] | None = None,
    files: Sequence[str | Path] = (),
    seed: Callable[[Any], int | None] = lambda result: getattr(result, "seed", None),
    warnings: Callable[[Any], Sequence[str]] = lambda result: getattr(result, "warnings", ()),
) -> Reading:
    """Return a Reading. body: of the document; rows: of that body; summary: (name, answer) lines and tables of a notebook; files: that were read."""

    def document_of(result: Any) -> dict[str, Any]:
        from vcmm.show.console.documents import document, sources

        read = [p for f in files for p in sources(Path(f))]
        return document(schema, body(result), seed=seed(result), files=read, warnings=warnings(result))

    def brief(result: Any) -> str:
        from vcmm.show.report.text import escape
        from vcmm.show.tables.table import html

        lines = [f"<p><strong>{escape(name)}</strong>: {escape(text)}</p>" for name, text in summary(result)]
        return "\n".join([*lines, *(html(table) for table in tables(result))])

    def write(path: Path, text: str) -> Any:
        from vcmm.show.console.files import write_text

        return write_text(path, text)

    return Reading(document_of, lambda result: rows(body(result)), brief, page, write)


def names_and_answers(result: Any) -> list[tuple[str, str]]:
    """Return (name, answer) of every characteristic."""
    from vcmm.answer.evaluation.one_line import answer

    return [(c.name, answer(c)) for c in result.characteristics]


def characteristics_of(body: dict[str, Any]) -> Rows:
    """Return the rows of most documents; the budget of each is a table of its own."""
    return [{k: v for k, v in c.items() if k != "budget"} for c in body["characteristics"]]


def measurement_reading(files: Sequence[str | Path], seed: int | None) -> Reading:
    """Return the reading of `measure`."""
    from vcmm.show.tables.measured_points import measure_json, values

    return make_reading(
        "vcmm.measure/1",
        measure_json,
        rows=characteristics_of,
        tables=lambda m: [values(m)],
        files=files,
        seed=lambda m: seed,
    )


def uncertainty_reading(scenario: Scenario, files: Sequence[str | Path]) -> Reading:
    """Return the reading of `uncertainty`."""
    from vcmm.show.tables.uncertainty import results, uncertainty_json

    def page(result: UncertaintyResult) -> str:
        from vcmm.show.pages.uncertainty import uncertainty_page

        return uncertainty_page(scenario, result)

    return make_reading(
        "vcmm.uncertainty/1",
        uncertainty_json,
        rows=characteristics_of,
        tables=lambda u: [results(u)],
        summary=names_and_answers,
        page=page,
        files=files,
    )


def whole_of(part: EvaluatedPart) -> UncertaintyResult:
    """Return the characteristics of a measured part as an uncertainty result, for page and table."""
    return replace(
        part.uncertainty,
        characteristics=tuple(e.result for e in part.characteristics),
        warnings=part.warnings,
    )


def part_reading(scenario: Scenario, files: Sequence[str | Path]) -> Reading:
    """Return the reading of one part of `evaluate`."""
    from vcmm.answer.evaluation.one_line import answer
    from vcmm.show.tables.evaluation import evaluate_json
    from vcmm.show.tables.uncertainty import results

    def page(part: EvaluatedPart) -> str:
        from vcmm.show.console.documents import sources
        from vcmm.show.pages.sheet import sheet_page

        return sheet_page(scenario, part, [p for f in files for p in sources(Path(f))])

    def rows(body: dict[str, Any]) -> Rows:
        parts = body.get("parts", [body])
        return [
            {**({"part": p["part"]} if "part" in p else {}), **row}
            for p in parts
            for row in characteristics_of(p)
        ]

    return make_reading(
        "vcmm.uncertainty/1",
        lambda part: evaluate_json([part]),
        rows=rows,
        tables=lambda part: [results(whole_of(part))],
        summary=lambda part: [(e.name, answer(e.result)) for e in part.characteristics],
        page=page,
        files=files,
        seed=lambda part: part.uncertainty.seed,
    )


def cut_reading(scenario: CutScenario, files: Sequence[str | Path]) -> Reading:
    """Return the reading of `cut`."""
    from vcmm.show.pages.cut import cut_page
    from vcmm.show.tables.cut import cut_json, finished_part

    return make_reading(
        "vcmm.cut/1",
        cut_json,
        rows=characteristics_of,
        tables=lambda c: [finished_part(c)],
        summary=names_and_answers,
        page=lambda c: cut_page(scenario, c),
        files=[*files, scenario.program] if files else (),
        seed=lambda c: c.uncertainty.seed,
    )


def placement_reading(files: Sequence[str | Path]) -> Reading:
    """Return the reading of `place` on a measuring task."""
    from vcmm.answer.placing.advice import advice
    from vcmm.answer.placing.result import place_json
    from vcmm.show.pages.place import place_page
    from vcmm.show.tables.placement import compared_poses

    return make_reading(
        "vcmm.place/1",
        lambda p: place_json(p) | {"advice": advice(p)},
        rows=lambda body: body["objective"]["characteristics"],
        tables=lambda p: [compared_poses(p)],
        summary=lambda p: [("advice", text) for text in advice(p)[:1]],
        page=place_page,
        files=files,
    )


def placed_cut_reading(scenario: CutScenario, files: Sequence[str | Path]) -> Reading:
    """Return the reading of `place` on a cutting scenario."""
    from vcmm.face.bodies import placed_cut_json
    from vcmm.show.pages.place import place_cut_page
    from vcmm.show.tables.placement import compared_cut_poses

    return make_reading(
        "vcmm.place/1",
        placed_cut_json,
        rows=lambda body: body["conforming"],
        tables=lambda p: [compared_cut_poses(p)],
        page=lambda p: place_cut_page(scenario, p),
        files=[*files, scenario.program] if files else (),
        warnings=lambda p: p.after.warnings,
    )


def audit_reading(seed: int) -> Reading:
    """Return the reading of `audit`."""
    from vcmm.show.tables.audit import audit_json, audit_table

    return make_reading(
        "vcmm.audit/1",
        audit_json,
        rows=lambda body: body["audit"],
        tables=lambda rows: [audit_table(rows)],
        seed=lambda rows: seed,
    )


def routes_reading(scenario: Scenario, files: Sequence[str | Path]) -> Reading:
    """Return the reading of `routes`."""
    from vcmm.show.pages.routes import routes_page
    from vcmm.show.tables.routes import agreements_table, routes_json, routes_table

    return make_reading(
        "vcmm.routes/1",
        routes_json,
        rows=lambda body: [
            {"characteristic": c["name"], **route} for c in body["characteristics"] for route in c["routes"]
        ],
        tables=lambda f: [routes_table(f), agreements_table(f)],
        page=lambda f: routes_page(scenario, f),
        files=files,
        warnings=lambda f: f.remarks,
    )


def certificate_reading(file: str | Path) -> Reading:
    """Return the reading of `certificate`."""
    from vcmm.show.tables.certificate import worth_json, worth_tables

    return make_reading(
        "vcmm.certificate/1",
        worth_json,
        rows=lambda body: [*body["by_prior"], *body["by_fact"]],
        tables=worth_tables,
        summary=lambda w: [("certificate", w.stated)],
        files=[file],
    )
