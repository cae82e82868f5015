"""vcmm cut: machine the part virtually; deviations of its features, U, decision, main contributors, cycle time."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.blocks import Sharing
from vcmm.core.errors import UsageError
from vcmm.core.units import quantity
from vcmm.face.cli.cut_measured import CameBack, came_back
from vcmm.face.cli.options import Cluster, InputFile, Json, Require, Seed, Shard, Workers
from vcmm.face.cli.proof import inspected_program
from vcmm.face.job import Flags, Progress, Record, SharedJob, decision_code, run_shared, sharing_of
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.measured_data import read_measured_points
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.proof import CutProof
from vcmm.shop.machining.result import CutResult
from vcmm.show.console.complaints import about
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.report.answers import answer_of
from vcmm.show.tables import cut as tables
from vcmm.show.tables.compensation import proof_json, proof_text
from vcmm.show.tables.uncertainty import not_added_up
from vcmm.task.measuring.cut_scenario import CutScenario


def cut_command(
    scenario: InputFile,
    *,
    trials: int | None = None,
    seed: Seed | None = None,
    engine: Literal["auto", "montecarlo", "exact"] = "auto",
    workers: Workers = None, cluster: Cluster = None, shard: Shard = None, json: Json = False, out: Path | None = None,
    measured: InputFile | None = None, frame: Literal["part", "machine"] = "part", u_point: str = "", inspect: InputFile | None = None, tolerance: str = "",
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
    sharing, back = (
        sharing_of(workers, cluster, shard),
        MeasuredBack.from_options(measured, frame == "machine", u_point),
    )
    other = _inspection_program(inspect, tolerance, back is not None or sharing.share is not None)
    job = CutJob(
        scenario, trials=trials, seed=seed, engine=engine, measured=back, other=other, require=require, folder=out, sharing=sharing
    )  # fmt: skip
    return run_shared(job, Flags(json, out))


def _inspection_program(inspect: Path | None, tolerance: str, taken: bool) -> tuple[Path, str] | None:
    """Return (program, tolerance) of --inspect. UsageError for options that do not go together."""
    if inspect is None:
        if tolerance:
            raise UsageError("--tolerance is of the proof; add --inspect PROGRAM")
        return None
    if taken:
        raise UsageError("--inspect cuts another program: give it without --measured and --shard")
    return inspect, tolerance or "1 um"


class MeasuredBack(NamedTuple):
    """A measured part: its points, whether they are in the machine frame, u of a point as text."""

    file: Path
    in_machine: bool
    u_point: str

    @classmethod
    def from_options(cls, file: Path | None, in_machine: bool, u_point: str) -> MeasuredBack | None:
        """Return the measured part; None where there is none. UsageError: --u-point without one."""
        if file is not None:
            return cls(file, in_machine, u_point)
        if u_point:
            raise UsageError("--u-point is of measured points; add --measured points.csv")
        return None


class CutTask(NamedTuple):
    """Input of a cut; points: of the measured part, and u of a point; proof: of another program, which is then cut instead."""

    scenario: CutScenario
    points: tuple[GivenPoints, float | None] | None
    proof: CutProof | None


class CutPart(NamedTuple):
    """The cut part, the exit code of its decisions, and the comparison with the measured part."""

    result: CutResult
    code: int
    back: CameBack | None


@dataclass(frozen=True)
class CutJob(SharedJob[CutTask, CutPart]):
    """A part cut virtually. other: program that is cut instead, and its tolerance; folder: of --out, for the recording."""

    scenario: Path
    trials: int | None = None
    seed: int | None = None
    engine: str = "auto"
    measured: MeasuredBack | None = None
    other: tuple[Path, str] | None = None
    require: str | None = None
    folder: Path | None = None
    verb, schema = "cut", "vcmm.cut/1"

    @property
    def stem(self) -> str:
        return self.scenario.stem

    def count_options(self) -> dict[str, Any]:
        return {"trials": self.trials, "seed": self.seed, "engine": self.engine}

    def options(self) -> dict[str, Any]:
        return {"scenario": str(self.scenario), **self.count_options()}

    def inputs(self) -> list[Path]:
        return sources(self.scenario)

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> CutJob:
        return cls(**options | {"scenario": Path(options["scenario"])}, sharing=sharing)

    def check_shard(self) -> None:
        if self.require is not None:
            raise UsageError("--require is of the whole job, not of one shard; give it without --shard")
        if self.measured is not None:
            raise UsageError("a shard counts trials only: give --measured to the whole job, without --shard")

    def load(self) -> CutTask:
        back = self.measured
        points = None if back is None else measured_points(back.file, back.u_point)
        scenario = load_cut(self.scenario)
        if self.other is None:
            return CutTask(scenario, points, None)
        proof = inspected_program(scenario, *self.other)
        return CutTask(replace(scenario, program=self.other[0]), points, proof)

    def run(self, loaded: CutTask, report: Progress) -> CutPart:
        with about(self.scenario, "cut"):
            result = cut(loaded.scenario, **self.count_options(), progress=report, sharing=self.sharing)
        code = decision_code(result.characteristics, self.require)  # before a recording is written
        back = self.measured
        if back is None or loaded.points is None:
            return CutPart(result, code, None)
        folder = self.folder or back.file.parent
        came = came_back(
            self.scenario, loaded.scenario, loaded.points, in_machine=back.in_machine, seed=self.seed, folder=folder, report=report,
        )  # fmt: skip
        return CutPart(result, code, came)

    def record(self, loaded: CutTask, result: CutPart) -> Record:
        files, body = [*sources(self.scenario), loaded.scenario.program], tables.cut_json(result.result)
        warnings = tuple(result.result.warnings)
        if result.back is not None and self.measured is not None:
            files, body = [*files, self.measured.file], body | result.back.json
            warnings = tuple(dict.fromkeys((*warnings, *result.back.warnings)))
        if loaded.proof is not None:
            body |= proof_json(loaded.proof)
        return Record(body, files, result.result.uncertainty.seed, warnings)

    def texts(self, loaded: CutTask, result: CutPart, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.cut import cut_page

        files = [*sources(self.scenario), loaded.scenario.program]
        return {
            "report.html": cut_page(loaded.scenario, result.result, files),
            "cut.json": content,
            "surface.csv": tables.surface_csv(result.result),
        }

    def write_binaries(self, loaded: CutTask, result: CutPart, folder: Path) -> list[str]:
        """Write the remaining blank, where the set-up states a stock."""
        from vcmm.shop.cutting.solid import write_stl
        from vcmm.shop.machining.turned_blank import TurnedBlank, write_turned_stl

        blank = result.result.blank
        if blank is None:
            return []
        if isinstance(blank, TurnedBlank):
            write_turned_stl(blank.after, folder / "stock.stl")
        else:
            write_stl(blank.after, folder / "stock.stl")
        return ["stock.stl"]

    def exit_code(self, loaded: CutTask, result: CutPart) -> int:
        return int(result.code or (loaded.proof is not None and not loaded.proof.is_met))

    def show(self, loaded: CutTask, result: CutPart) -> None:
        """Show the proof of another program, the prediction, and the measured part where there is one."""
        if loaded.proof is not None:
            print(proof_text(loaded.proof))
        show(result.result)
        if result.back is not None:
            result.back.show()


def measured_points(measured: Path, u_point: str) -> tuple[GivenPoints, float | None]:
    """Return (points, u of a point or None) of one measured part. UsageError for several parts."""
    points, *more = read_measured_points(measured)
    if more:
        raise UsageError(
            f"{measured}: there are {len(more) + 1} parts ({points.part}, {more[0].part} ...); compare them one by one, a file for each"
        )
    u = quantity(u_point, "length", "--u-point", "0.5 um") if u_point else None
    if u is not None and not u > 0:
        raise UsageError(f'--u-point "{u_point}" must be more than nothing, for example "0.5 um"')
    return points, u


def show(result: CutResult) -> None:
    """Show deviations, main contributors, shares within a batch, the surface."""
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
            f"stock ({result.blank.kept_as}): {result.blank.removed_volume / 1e3:.1f} cm³ removed, "
            f"{len(result.blank.collisions)} rapids through material"
        )
    say_warnings(result.warnings)


def _recut_text(result: Any) -> str:
    if result is None:
        return ""
    return f"cut again with the tools really displaced: {result.points} points differ from the result by {result.largest * 1e3:.3f} µm at most\n"
