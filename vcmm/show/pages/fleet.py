"""The page of a folder of recordings: changes of each machine, and the findings of every recording."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables import fleet as tables
from vcmm.show.tables.answers_runs import folder_answers
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.files.learned.fleet import Change


def fleet_page(folder: str, records: Sequence[tables.Record], changes: Sequence[Change]) -> str:
    """Return one self-contained HTML file."""
    far = [i for i, c in enumerate(changes) if not c.steady]
    blocks = [r.heading("What changed"), html(tables.changes(changes), emphasise=far)] if changes else []
    blocks += [r.heading("What each holds"), html(tables.recordings(folder, records))]
    return r.page(
        f"Recordings of {folder}",
        blocks,
        footer=f"vcmm {__version__}",
        answers=folder_answers(records, changes),
        facts=facts(more=[("recordings", f"{len(records)}")]),
    )
