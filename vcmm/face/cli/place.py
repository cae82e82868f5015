"""vcmm place: the pose that serves best."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Cluster, CountOption, Seed, Shard, Workers


def place_command(
    scenario: Path,
    *,
    plan: Annotated[bool, Parameter(name="--plan")] = False,
    budget: str | None = None,
    machines: Annotated[list[Path] | None, Parameter(consume_multiple=True)] = None,
    seed: Seed | None = None,
    evaluations: CountOption = None,
    scan: CountOption = None,
    trials: CountOption = None,
    draws: CountOption = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """The pose, among those that the fixture allows, with the smallest objective: gain, map, flatness, certificate.

    [placement] of the scenario says what may move and what is minimised; without it the part slides on the table and turns about the
    vertical, for U/T of all. A part that is cut moves with its work offset. `vcmm place gaska2014` runs the twin of a published study.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    plan
        Keep the pose; choose points, styli and order instead, and show U against measuring time.
    budget
        Measuring time that a plan may take (default: "5 min"); with --plan only.
    machines
        Machine files to choose from, or folders; each takes the place of the scenario's machine.
    seed
        Seed of the search, the scan and the trials (default: the scenario's, else 0).
    evaluations
        Evaluations of the objective that the search may use (default: 5000; gaska2014: 3000).
    scan
        Further poses for the certificate, the median and the worst pose (default: 4096; gaska2014: 2048).
    trials
        Monte Carlo trials of the full evaluation at the present and the best pose.
    draws
        Machines consistent with the published figures (default: 200); for gaska2014 only.
    workers
        Processes that share the machines of --machines; the document does not depend on it.
    cluster
        Address of a Dask scheduler whose workers share them, such as tcp://scheduler:8786.
    shard
        Try one part of the machines only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    out
        Folder for report.html, place.json and placed.toml (the new pose); with --plan for plan.json, plan.toml and points as CSV.
    """
    _check(plan, machines, draws, budget, (evaluations, scan, trials), (workers, cluster, shard))
    if plan:
        return _plan_points(scenario, budget or "5 min", seed, json, out)
    options = {"seed": seed, "evaluations": evaluations, "scanned": scan, "trials": trials}
    if machines and not (scenario.is_file() and _cuts(scenario)) and str(scenario) != "gaska2014":
        return _choose_machine((scenario, machines), options, (workers, cluster, shard), json, out)
    return _place_scenario(scenario, machines, draws, options, json, out)


def _check(
    plan: bool,
    machines: list[Path] | None,
    draws: int | None,
    budget: str | None,
    search: tuple[int | None, ...],
    shared: tuple[Any, ...],
) -> None:
    """Raises UsageError for options that would be passed over in silence."""
    if not machines or plan:
        asked = dict(zip(("--workers", "--cluster", "--shard"), (word is not None for word in shared)))
        _refuse("only the machines of --machines are shared out", asked)
    if plan:
        given = dict(zip(("--evaluations", "--scan", "--trials"), search))
        _refuse("--plan chooses points at one pose", {**given, "--machines": machines, "--draws": draws})
    else:
        _refuse("without --plan no points are chosen", {"--budget": budget})
    if machines:
        _refuse("the machines are those of --machines", {"--draws": draws})


def _place_scenario(
    scenario: Path,
    machines: list[Path] | None,
    draws: int | None,
    options: dict[str, Any],
    json: bool,
    out: Path | None,
) -> int:
    """One scenario on its own machine, or the twin."""
    from vcmm.show.console.files import output_folder

    folder = output_folder(out) if out else None
    given = {name: value for name, value in options.items() if value is not None}
    if str(scenario) == "gaska2014" and not scenario.exists():
        return _twin(machines, draws, given, json, folder)
    _refuse("only gaska2014 draws machines", {"--draws": draws})
    return _any(scenario, machines, given, json, folder)


def _choose_machine(
    named: tuple[Path, list[Path]],
    options: dict[str, Any],
    shared: tuple[Any, ...],
    json: bool,
    out: Path | None,
) -> int:
    """A choice of machines. named: scenario, machines; options: of the search; shared: workers, cluster, shard."""
    from vcmm.face.cli.place_machines import choose, shard_of_machines
    from vcmm.face.job import sharing_of

    sharing = sharing_of(*shared)
    if sharing.share is None:
        return choose(*named, options, json, out, sharing=sharing)
    return shard_of_machines(*named, options, sharing, json, out)


def _twin(
    machines: list[Path] | None, draws: int | None, options: dict[str, Any], json: bool, folder: Path | None
) -> int:
    """The twin of the published study: ranking, optimum and node reduction as tables, JSON, report."""
    from vcmm.face.twins import twin
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import progress, say, show_table

    _refuse("the twin has machines of its own", {"--machines": machines})
    source = example("gaska2014")
    scenario = load_scenario(source)
    with progress() as report:
        study = twin("gaska2014").placement_command.study(scenario, draws or 200, options, report)
    seed = options.get("seed", scenario.settings.seed)
    content = document("vcmm.place/1", study.body(), seed=seed, files=[source])
    if folder:
        write_files(folder, {"place.json": json_text(content), "report.html": study.html()})
        say(f"wrote {folder}/report.html, place.json")
    if json:
        print_json(content)
    else:
        for table in study.tables():
            show_table(table)
    return 0


def _refuse(why: str, given: dict[str, Any]) -> None:
    """An option that would be passed over in silence is refused."""
    from vcmm.core.errors import UsageError

    idle = [name for name, value in given.items() if value]
    if idle:
        raise UsageError(f"{', '.join(idle)}: {why}, so this has no meaning here; leave it out")


def _any(
    scenario: Path, machines: list[Path] | None, options: dict[str, Any], json: bool, folder: Path | None
) -> int:
    """A cut part, or the placement of one measuring task."""
    if scenario.is_file() and _cuts(scenario):
        from vcmm.face.cli.place_cut import placed_cut

        _refuse("a program is cut on the machine that its set-up was made for", {"--machines": machines})
        return placed_cut(scenario, options, json, folder)
    return _place(scenario, options, json, folder)


def _cuts(scenario: Path) -> bool:
    """Whether the scenario cuts a part."""
    from vcmm.files.toml import read_toml

    return "cut" in read_toml(scenario).data


def _plan_points(scenario: Path, budget: str, seed: int | None, json: bool, out: Path | None) -> int:
    """Points, styli and order under a time budget."""
    from vcmm.face.cli.place_plan import run_plan_option
    from vcmm.files.own.scenario import load_scenario

    loaded = load_scenario(scenario)
    return run_plan_option(
        loaded,
        scenario,
        budget=budget,
        seed=loaded.settings.seed if seed is None else seed,
        json=json,
        out=out,
    )


def _place(scenario: Path, options: dict[str, Any], json: bool, folder: Path | None) -> int:
    """Place one scenario and say what was found."""
    from vcmm.answer.placing.advice import advice
    from vcmm.answer.placing.placement import place
    from vcmm.answer.placing.result import place_json
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import progress

    loaded = load_scenario(scenario)
    with progress() as report, about(scenario, "placement"):
        placed = place(loaded, progress=report, **options)
    content = document(
        "vcmm.place/1",
        place_json(placed) | {"advice": advice(placed)},
        seed=placed.seed,
        files=sources(scenario),
        warnings=placed.warnings,
    )
    if folder:
        _write(folder, scenario, placed, content)
    if json:
        print_json(content)
    else:
        show(placed)
    return 0


def show(placed: Any) -> None:
    """Poses compared, why, certificate and flatness, advice."""
    from vcmm.answer.placing.advice import room_and_shares
    from vcmm.answer.placing.words import pose_text
    from vcmm.show.console.terminal import say_warnings, show_answers, show_table
    from vcmm.show.tables.answers import place_answers
    from vcmm.show.tables.placement import compared_poses, how_sure, why

    show_answers(place_answers(placed))
    for table in (compared_poses(placed), why(placed), how_sure(placed)):
        show_table(table)
    if placed.region.convenient is not None:
        print(f"convenient pose within 2 %: {pose_text(placed.region.convenient)}")
    print("\n".join(["advice:", *room_and_shares(placed)]))
    say_warnings(placed.warnings)


def _write(folder: Path, source: Path, placed: Any, content: dict[str, Any]) -> None:
    from vcmm.files.own.placement_writer import placed_text
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.place import place_page

    texts = {
        "place.json": json_text(content),
        "report.html": place_page(placed),
        "placed.toml": placed_text(
            source, folder / "placed.toml", placed.best.pose, convenient=placed.region.convenient
        ),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, place.json, placed.toml")
