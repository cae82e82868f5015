"""vcmm evaluate --compare: a measured part evaluated, and beside it what was predicted of it when it was cut.

Prediction and measurement are one model: the part is cut with the errors of the machine tool and measured with those of the
measuring machine, so the difference is judged with the covariance of both.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from vcmm.face.job import Flags, decision_code

OPTIONS = {"values": "--values", "tip_centres": "--tip-centres"}


def compare_with_cut(
    scenario: Path,
    cut: Path | None,
    options: dict[str, Any],
    flags: Flags,
    export: Path | None,
    require: str | None,
) -> int:
    """The whole job. scenario: with [cut] and [inspection], or of the measurement, and cut: of the cut part."""
    from vcmm.face.cli.cut import measured_points
    from vcmm.face.cli.cut_measured import came_back
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import progress
    from vcmm.show.tables.evaluation import evaluate_json

    _check(options, export or flags.evidence)
    folder = output_folder(flags.out) if flags.out else None
    file, loaded, measuring = _both(scenario, cut)
    points = options["points"]
    given = measured_points(points, "")
    parts: Any = ()
    if measuring is not None:
        from vcmm.face.api import evaluate

        with progress() as report, about(scenario):
            parts = evaluate(measuring, **(options | {"frame": options["frame"] or "part"}), progress=report)
    with progress() as report:
        back = came_back(
            file,
            loaded,
            given,
            in_machine=options["frame"] == "machine",
            seed=options["seed"],
            folder=folder or points.parent,
            report=report,
        )
    code = decision_code((e.result for p in parts for e in p.characteristics), require)
    body = evaluate_json(parts) if parts else {"characteristics": []}
    files = dict.fromkeys([*sources(scenario), *(sources(cut) if cut else ()), loaded.program, points])
    warnings = dict.fromkeys([*(w for p in parts for w in p.warnings), *_unsaid(measuring), *back.warnings])
    seed = parts[0].uncertainty.seed if parts else loaded.settings.seed
    content = document(
        "vcmm.uncertainty/1", body | back.json, seed=seed, files=[*files], warnings=[*warnings]
    )
    if folder:
        _write(folder, content)
    print_json(content) if flags.json else _show(parts, replace(back, warnings=tuple(warnings)))
    return code


def _check(options: dict[str, Any], further: Path | None) -> None:
    """UsageError for what a comparison has no use for."""
    from vcmm.core.errors import UsageError

    for key, flag in OPTIONS.items():
        if options[key]:
            raise UsageError(
                f"--compare takes measured points on the surface, --points points.csv; leave {flag} out"
            )
    if options["points"] is None:
        raise UsageError("--compare needs the measured points; add --points points.csv")
    if further:
        raise UsageError(
            "--export and --evidence are of an evaluation by itself; leave --compare out for them"
        )


def _both(scenario: Path, cut: Path | None) -> tuple[Path, Any, Any]:
    """(file of the cut, cut scenario that is inspected as measured, measuring scenario or None)."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.scenario import load_scenario
    from vcmm.files.toml import read_toml

    if "cut" in read_toml(scenario).data:
        if cut is not None:
            raise UsageError(f"{scenario} holds a [cut] itself; leave --cut out")
        loaded = load_cut(scenario)
        return scenario, loaded, inspecting(loaded)
    if cut is None:
        raise UsageError(
            f"{scenario} says nothing of how the part was cut: add --cut block.toml, the scenario with the table [cut]"
        )
    measuring = load_scenario(scenario)
    return cut, inspect_cut(load_cut(cut), measuring), measuring


def inspect_cut(cut: Any, measuring: Any) -> Any:
    """The cut scenario, its part measured as a measuring scenario says. UsageError: features that are not of the cut part."""
    from vcmm.core.errors import UsageError, choose_from
    from vcmm.core.knowledge import add_knowledge
    from vcmm.shop.machining.scenario import OTHER, Inspection

    for name in measuring.part.features:
        if name not in cut.part.features:
            raise UsageError(
                f'the feature "{name}" is measured, but the part that is cut has none of that name.{choose_from(name, cut.part.features)}'
            )
    machine = add_knowledge(measuring.machine, inputs=measuring.inputs)
    how = Inspection(OTHER, machine, measuring.pose, measuring.constants)
    return replace(
        cut, part=measuring.part, plan=measuring.plan, qualifications=measuring.qualifications, inspection=how
    )


def inspecting(cut: Any) -> Any:
    """The measuring scenario of [inspection]; None where no measuring machine is stated."""
    from vcmm.shop.machining.scenario import OTHER
    from vcmm.task.measuring.scenario import Scenario

    how = cut.inspection
    if how.kind != OTHER or cut.plan is None:
        return None
    return Scenario(
        cut.name, how.machine, cut.part, cut.plan, how.pose, how.constants, qualifications=cut.qualifications,
        settings=cut.settings,
    )  # fmt: skip


def _unsaid(measuring: Any) -> tuple[str, ...]:
    if measuring is not None:
        return ()
    return (
        "no measuring machine is stated ([inspection] machine and pose), so nothing is said of true values: only measured beside predicted",
    )


def _show(parts: Any, back: Any) -> None:
    from vcmm.face.cli.evaluated_parts import show_parts

    if parts:  # none where no measuring machine is stated
        show_parts(parts, ())
    back.show()


def _write(folder: Path, content: dict[str, Any]) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say

    write_files(folder, {"evaluation.json": json_text(content)})
    say(f"wrote {folder}/evaluation.json")
