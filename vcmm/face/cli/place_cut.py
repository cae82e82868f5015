"""vcmm place on a cutting scenario: the best place of the part on the table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.answer.placing.words import region_text
from vcmm.core.run import Array
from vcmm.face.bodies import placed_cut_json
from vcmm.face.job import Job, Progress, Record
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.placement_writer import placed_cut as placed_texts
from vcmm.shop.machining.placement import PlacedCut, place_cut
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.tables.answers import placed_cut_answers
from vcmm.show.tables.placement import compared_cut_poses, gains
from vcmm.task.measuring.cut_scenario import CutScenario


@dataclass(frozen=True)
class PlaceCutJob(Job[CutScenario, PlacedCut]):
    """A part that is cut, at its best place. search: options of the search that were given."""

    scenario: Path
    search: Mapping[str, Any]
    schema = "vcmm.place/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, "placement"

    def load(self) -> CutScenario:
        return load_cut(self.scenario)

    def run(self, loaded: CutScenario, report: Progress) -> PlacedCut:
        return place_cut(loaded, progress=report, **self.search)

    def record(self, loaded: CutScenario, result: PlacedCut) -> Record:
        files = [*sources(self.scenario), loaded.program]
        return Record(placed_cut_json(result), files, result.seed, result.after.warnings)

    def texts(self, loaded: CutScenario, result: PlacedCut, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.place import place_cut_page

        moved = placed_texts(self.scenario, loaded, folder, result.best.pose, shift_of(result))
        return {"place.json": content, "report.html": place_cut_page(loaded, result), **moved}

    def files_sentence(
        self, loaded: CutScenario, result: PlacedCut, folder: Path, names: Sequence[str]
    ) -> str:
        shift = ", ".join(f"{v:+.3f}" for v in shift_of(result))
        return (
            f"wrote {folder}/report.html, place.json, placed.toml, placed-setup.toml: part and work offsets moved by "
            f"({shift}) mm"
        )

    def show(self, loaded: CutScenario, result: PlacedCut) -> None:
        """Show poses compared, the gain of each characteristic, certainty and flatness."""
        show_answers(placed_cut_answers(result))
        for table in (compared_cut_poses(result), gains(result)):
            show_table(table)
        print(f"certificate: {result.certificate.text}\nflatness: {region_text(result)}")


def shift_of(placed: PlacedCut) -> Array:
    """Return the shift (3,) mm of part and work offsets."""
    return placed.best.pose[:3] - placed.present.pose[:3]
