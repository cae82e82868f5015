"""vcmm calibrate --nodes: positions of the machine at the nodes of a grid, from LaserTracer lengths; a residual field for its file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.core.errors import UsageError
from vcmm.face.cli.calibrate_given import CalibrationFiles, CalibrationInput
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.node_field import check_nodes, node_text
from vcmm.learn.calibration.field_process import ProcessFit, fit_process
from vcmm.learn.calibration.nodes import NodeScatter, node_scatter
from vcmm.physics.structure.residual import ResidualField
from vcmm.physics.structure.scatter import Scatter
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say, show_table
from vcmm.show.tables.nodes import NODE_COLUMNS, nodes_table, process_json, process_sentences, sentences
from vcmm.show.tables.table import records


class Nodes(NamedTuple):
    """The scatter at every node, and the assumed process between them."""

    scatter: NodeScatter
    fit: ProcessFit


@dataclass(frozen=True)
class NodesJob(Job[CalibrationInput, Nodes]):
    """The nodes of one recording multilaterated; the machine file is written where --out names one."""

    request: CalibrationFiles
    schema = "vcmm.nodes/1"

    def check(self) -> None:
        if len(self.request.files) != 1:
            raise UsageError(
                f"--nodes takes one recording with all stations, not {len(self.request.files)}; put their rows into one file, distinguished by setup"
            )

    def load(self) -> CalibrationInput:
        return self.request.load()

    def run(self, loaded: CalibrationInput, report: Progress) -> Nodes:
        scatter = node_scatter(loaded.recordings[0], loaded.machine)
        if self.request.out is not None:
            check_nodes(scatter, loaded.machine)
        return Nodes(scatter, fit_process(scatter))

    def record(self, loaded: CalibrationInput, result: Nodes) -> Record:
        return Record(node_body(result.scatter, result.fit, self.request.out), self.request.read())

    def export(self, loaded: CalibrationInput, result: Nodes, content: dict[str, object]) -> None:
        """Write the machine file."""
        out = self.request.out
        if out is None:
            return
        output_folder(out.parent)
        names = [f.name for f in self.request.files]
        write_text(
            out, node_text(result.scatter, loaded.machine, self.request.machine, out, names, result.fit)
        )
        say(f"wrote {out}")
        if any(i.effect == Scatter.name for i in loaded.machine.inputs):
            say(f"warning: {ResidualField.counted_twice}")

    def show(self, loaded: CalibrationInput, result: Nodes) -> None:
        show_table(nodes_table(result.scatter))
        for sentence in (*sentences(result.scatter), *process_sentences(result.fit)):
            print(sentence)


def node_body(scatter: NodeScatter, fit: ProcessFit, out: Path | None) -> dict[str, object]:
    """Return the JSON document without its frame."""
    located = scatter.multilateration
    return {
        "machine": None if out is None else str(out),
        "residual_um": scatter.u * 1e3,
        "degrees_of_freedom": located.freedom,
        "condition": located.condition,
        "stations": [
            {"place_mm": s.tolist(), "dead_path_mm": float(p)}
            for s, p in zip(located.stations, located.dead_paths)
        ],
        "process": process_json(fit, int(scatter.dof.min())),
        "rejected_share": scatter.rejection_share(),
        "nodes": records(NODE_COLUMNS, nodes_table(scatter).rows),
    }
