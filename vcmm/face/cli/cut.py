"""vcmm cut: machine the part virtually; deviations of its features, U, decision, main contributors, cycle time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from vcmm.face.cli.options import Cluster, Require, Seed, Shard, Workers


def cut_command(
    scenario: Path,
    *,
    trials: int | None = None,
    seed: Seed | None = None,
    engine: Literal["auto", "montecarlo", "exact"] = "auto",
    workers: Workers = None, cluster: Cluster = None, shard: Shard = None, json: Annotated[bool, Parameter(name="--json")] = False, out: Path | None = None,
    measured: Path | None = None, frame: Literal["part", "machine"] = "part", u_point: str = "", inspect: Path | None = None, tolerance: str = "",
    require: Require = None,
) -> int:  # fmt: skip
    """Machine a part virtually: program, machine, tools and set-up to the deviations of its features.

    Exit code 1 when a characteristic does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) with a [cut] table.
    trials
        Monte Carlo trials (default: the scenario's, else 10^6).
    seed
        Seed of the random streams (default: the scenario's, else 0).
    workers
        Processes that count the trials; the numbers do not depend on it.
    cluster
        Address of a Dask scheduler whose workers count them, such as tcp://scheduler:8786.
    shard
        Count one part only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    engine
        As in `vcmm uncertainty`; exact: transforms multiplied and the deepest of the candidates taken in every trial.
    out
        Folder for report.html, cut.json, surface.csv and, where the set-up states a stock, stock.stl.
    measured
        The part came back measured, points.csv: says where it departs, and writes a recording for diagnose (--out, else there).
    frame
        Of the measured points: the drawing frame (after alignment) or the machine frame.
    u_point
        Standard uncertainty of a measured point, for example "0.5 um"; default: found from the points.
    inspect
        Another program for the same part, as compensate writes it: cut instead, inspected, and compared with the scenario's own.
    tolerance
        Of --inspect: largest departure of a point that is allowed (default 1 um). Exit code 1 where it is not met.
    require
        conforms: exit code 1 also where a characteristic is undecided, not only where one does not conform.
    """
    from vcmm.face.job import sharing_of

    sharing, options = sharing_of(workers, cluster, shard), {"trials": trials, "seed": seed, "engine": engine}
    back = None if measured is None and not u_point else (measured, frame == "machine", u_point)
    other = _inspection_program(inspect, tolerance, back is not None or sharing.share is not None)
    if sharing.share is None:
        return run_cut(scenario, options, sharing, json, out, returned=back, other=other, require=require)
    return _shard(scenario, options, sharing, json, out, measured=back is not None, require=require)


def _inspection_program(inspect: Path | None, tolerance: str, taken: bool) -> tuple[Path, str] | None:
    """(program, tolerance) of --inspect. UsageError for options that do not go together."""
    from vcmm.core.errors import UsageError

    if inspect is None:
        if tolerance:
            raise UsageError("--tolerance is of the proof; add --inspect PROGRAM")
        return None
    if taken:
        raise UsageError("--inspect cuts another program: give it without --measured and --shard")
    return inspect, tolerance or "1 um"


def _shard(
    scenario: Path,
    options: dict[str, Any],
    sharing: Any,
    json: bool,
    out: Path | None,
    measured: bool,
    require: str | None,
) -> int:
    """A part of the trials, for `vcmm merge`."""
    from vcmm.core.errors import UsageError
    from vcmm.face.job import put_shard, write_shard
    from vcmm.show.console.documents import sources

    if require is not None:
        raise UsageError("--require is of the whole job, not of one shard; give it without --shard")
    if measured:
        raise UsageError("a shard counts trials only: give --measured to the whole job, without --shard")
    shared = write_shard(
        "cut", {"scenario": str(scenario), **options}, sources(scenario), sharing.share,
        lambda: _cut(scenario, options, sharing),
    )  # fmt: skip
    return put_shard(shared, scenario.stem, json, out)


def _cut(scenario: Path, options: dict[str, Any], sharing: Any, other: tuple[Path, str] | None = None) -> Any:
    """(scenario, result); complaints get file and line. other: program that is cut instead."""
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.shop.machining.job import cut
    from vcmm.show.console.complaints import about
    from vcmm.show.console.terminal import progress

    loaded = load_cut(scenario)
    loaded = loaded if other is None else replace(loaded, program=other[0])
    with progress() as report, about(scenario, "cut"):
        return loaded, cut(loaded, **options, progress=report, sharing=sharing)


def run_cut(
    scenario: Path, options: dict[str, Any], sharing: Any, json: bool, out: Path | None, returned: tuple[Path | None, bool, str] | None = None,
    other: tuple[Path, str] | None = None, require: str | None = None,
) -> int:  # fmt: skip
    """The whole job: document, files, tables. options: trials, seed, engine. returned: measured points, whether they stand in
    the machine frame, their standard uncertainty as text. other: program to inspect, and its tolerance.
    """
    from vcmm.face.cli.cut_measured import came_back
    from vcmm.face.cli.proof import inspected_program
    from vcmm.face.job import decision_code
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.show.console.documents import print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.tables.proofs import proof_json, proof_text

    given = None if returned is None else measured_points(returned[0], returned[2])
    folder = output_folder(out) if out else None
    proof = None if other is None else inspected_program(load_cut(scenario), *other)
    loaded, result = _cut(scenario, options, sharing, other)
    code = decision_code(result.characteristics, require)
    back, measured = None, returned[0] if returned else None
    if given is not None and returned is not None and measured is not None:
        back = came_back(scenario, loaded, given, returned[1], options["seed"], folder or measured.parent)
    content = _content(scenario, loaded, result, measured, back) | (
        {} if proof is None else proof_json(proof)
    )
    if folder:
        _write(folder, loaded, result, content, [*sources(scenario), loaded.program])
    if proof is not None and not json:
        print(proof_text(proof))
    print_json(content) if json else _show_both(result, back)
    return int(code or (proof is not None and not proof.met))


def _show_both(result: Any, back: Any) -> None:
    """The prediction, and the measured part where there is one."""
    show(result)
    if back is not None:
        back.show()


def _content(scenario: Path, loaded: Any, result: Any, measured: Path | None, back: Any) -> dict[str, Any]:
    """The document; back: of the measured part, None without one."""
    from vcmm.show.console.documents import document, sources
    from vcmm.show.tables.cut import cut_json

    files, warnings, body = [*sources(scenario), loaded.program], result.warnings, cut_json(result)
    if back is not None:
        files, warnings, body = (
            [*files, measured],
            tuple(dict.fromkeys((*warnings, *back.warnings))),
            body | back.json,
        )
    seed = result.uncertainty.seed
    return document("vcmm.cut/1", body, seed=seed, files=files, warnings=tuple(warnings))


def measured_points(measured: Path | None, u_point: str) -> Any:
    """(points, u of a point or None) of one measured part; None without one. UsageError for several parts."""
    from vcmm.core.errors import UsageError
    from vcmm.core.units import quantity

    if measured is None:
        if u_point:
            raise UsageError("--u-point is of measured points; add --measured points.csv")
        return None
    from vcmm.files.own.measured_data import read_measured_points

    points, *more = read_measured_points(measured)
    if more:
        raise UsageError(
            f"{measured}: there are {len(more) + 1} parts ({points.part}, {more[0].part} ...); compare them one by one, a file for each"
        )
    u = quantity(u_point, "length", "--u-point", "0.5 um") if u_point else None
    if u is not None and not u > 0:
        raise UsageError(f'--u-point "{u_point}" must be more than nothing, for example "0.5 um"')
    return points, u


def show(result: Any) -> None:
    """Deviations, main contributors, what a batch shares, the surface."""
    from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
    from vcmm.show.report.answers import answer_of
    from vcmm.show.tables import cut as tables
    from vcmm.show.tables.uncertainty import not_added_up

    show_answers(answer_of(c) for c in result.characteristics)
    show_table(tables.finished_part(result))
    for table in (tables.owners(result), tables.largest_contributions(result), tables.batch(result)):
        show_table(table)
    for sentence in not_added_up(result.characteristics):
        say(sentence)
    if result.threads:
        show_table(tables.threads(result))
    if result.grooves:
        show_table(tables.grooves(result))
    minutes, seconds = divmod(result.seconds, 60)
    print(
        f"{tables.surface_text(result.surface)}\n"
        f"{_recut_text(result.recut)}"
        f"cycle time: {minutes:.0f} min {seconds:.1f} s"
    )
    if result.blank is not None:
        print(
            f"stock ({result.blank.kept_as}): {result.blank.removed / 1e3:.1f} cm³ removed, "
            f"{len(result.blank.collisions)} rapids through material"
        )
    say_warnings(result.warnings)


def _recut_text(result: Any) -> str:
    if result is None:
        return ""
    return f"cut again with the tools really displaced: {result.points} points differ from the result by {result.largest * 1e3:.3f} µm at most\n"


def _write(folder: Path, scenario: Any, result: Any, content: dict[str, Any], files: list[Path]) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.cut import cut_page
    from vcmm.show.tables.cut import surface_csv

    texts = {
        "cut.json": json_text(content),
        "surface.csv": surface_csv(result),
        "report.html": cut_page(scenario, result, files),
    }
    write_files(folder, texts)
    if result.blank is not None:
        from vcmm.shop.cutting.solid import write_stl
        from vcmm.shop.machining.turned_blank import TurnedBlank, write_turned_stl

        if isinstance(result.blank, TurnedBlank):
            write_turned_stl(result.blank.after, folder / "stock.stl")
        else:
            write_stl(result.blank.after, folder / "stock.stl")
    say(f"wrote {folder}/report.html, cut.json, surface.csv{', stock.stl' if result.blank else ''}")
