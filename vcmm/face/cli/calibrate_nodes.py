"""vcmm calibrate --nodes: where the machine stops at the nodes of a grid, from LaserTracer lengths; a residual field for its file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.face.cli.calibrate_given import CalibrationFiles


def nodes_command(wanted: CalibrationFiles, json: bool) -> int:
    """Multilaterate, tell the nodes, write the machine file; the document is vcmm.nodes/1."""
    from vcmm.core.errors import UsageError
    from vcmm.files.learned.node_field import check_nodes, node_text
    from vcmm.learn.calibration.field_process import fit_process
    from vcmm.learn.calibration.nodes import node_scatter
    from vcmm.physics.structure.residual import ResidualField
    from vcmm.physics.structure.scatter import Scatter
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.files import output_folder, write_text
    from vcmm.show.console.terminal import say, show_table
    from vcmm.show.tables.nodes import nodes_table, process_sentences, sentences

    if len(wanted.files) != 1:
        raise UsageError(
            f"--nodes takes one recording with all stations, not {len(wanted.files)}; put their rows into one file, told apart by setup"
        )
    given, out = wanted.load(), wanted.out
    found = node_scatter(given.recordings[0], given.machine)
    if out is not None:
        check_nodes(found, given.machine)
    fit = fit_process(found)
    if out is not None:
        output_folder(out.parent)
        names = [f.name for f in wanted.files]
        write_text(out, node_text(found, given.machine, wanted.machine, out, names, fit))
        say(f"wrote {out}")
        if any(i.effect == Scatter.name for i in given.machine.inputs):
            say(f"warning: {ResidualField.counted_twice}")
    if json:
        print_json(document("vcmm.nodes/1", node_body(found, fit, out), files=wanted.read()))
        return 0
    show_table(nodes_table(found))
    for sentence in (*sentences(found), *process_sentences(fit)):
        print(sentence)
    return 0


def node_body(found: Any, fit: Any, out: Any) -> dict[str, Any]:
    """The JSON document without its frame."""
    from vcmm.show.tables.nodes import NODE_COLUMNS, nodes_table, process_json
    from vcmm.show.tables.table import records

    one = found.located
    return {
        "machine": None if out is None else str(out),
        "residual_um": found.u * 1e3,
        "degrees_of_freedom": one.left,
        "condition": one.condition,
        "stations": [
            {"place_mm": s.tolist(), "dead_path_mm": float(p)} for s, p in zip(one.stations, one.dead_paths)
        ],
        "process": process_json(fit, int(found.dof.min())),
        "rejected_share": found.rejection_share(),
        "nodes": records(NODE_COLUMNS, nodes_table(found).rows),
    }
