"""One task on the bench: previews at once, whole evaluations one at a time, the older one given up when a knob moves on."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vcmm.core.confinement import confine
from vcmm.core.errors import UsageError, VcmmError
from vcmm.face import api
from vcmm.face.workbench.knobs import knobs_of, with_knobs
from vcmm.face.workbench.live import preview
from vcmm.show.console.documents import document
from vcmm.show.pages.uncertainty import scenes
from vcmm.show.report.scene import figure_of
from vcmm.show.tables.uncertainty import uncertainty_json
from vcmm.task.measuring.scenario import Scenario

Question = tuple[str, int]  # the page that asks, and which of its questions
MOST_PAGES = 100  # pages whose newest question is remembered


class GivenUp(Exception):
    """A newer question has come; the answer to this one is no longer wanted."""


class Bench:
    """The task, and which question of every open page is its newest. Answers are dictionaries of JSON."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self._working = threading.Lock()
        self._asked = threading.Lock()
        self._newest: dict[str, int] = {}

    def state(self) -> dict[str, Any]:
        """Name, knobs, and the answer with all knobs where they stand."""
        knobs = [vars(k) | {"low": k.reach[0], "high": k.reach[1]} for k in knobs_of(self.scenario)]
        return {"name": self.scenario.name, "knobs": knobs}

    def preview(self, values: Mapping[str, Any], page: str = "") -> dict[str, Any]:
        """Raises UsageError for knobs that do not exist; GivenUp when the page has asked something newer meanwhile."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)
        with self._working:
            self._check_newest(mine)
            return preview(chosen, chosen.settings.seed)

    def settle(self, values: Mapping[str, Any], page: str = "") -> dict[str, Any]:
        """The whole evaluation with its scenes. GivenUp as soon as the page has asked something newer."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)

        def report(text: str, share: float | None) -> None:
            self._check_newest(mine)

        with self._working:
            self._check_newest(mine)
            result = api.uncertainty(chosen, progress=report)
            self._check_newest(mine)
        figures = [figure_of(items)[0] for items in scenes(result)]
        body = {"preview": False, **uncertainty_json(result), "figures": figures}
        return document("vcmm.uncertainty/1", body, seed=result.seed, files=[], warnings=result.warnings)

    def _ask(self, page: str = "") -> Question:
        with self._asked:
            number = self._newest.pop(page, 0) + 1
            self._newest[page] = number  # the last to ask stands last
            if len(self._newest) > MOST_PAGES:
                del self._newest[next(iter(self._newest))]
            return page, number

    def _check_newest(self, question: Question) -> None:
        page, number = question
        if self._newest.get(page) != number:
            raise GivenUp


def diagnose_files(files: Mapping[str, bytes], folder: Path) -> dict[str, Any]:
    """What physics a dropped recording holds: its .toml and the tables that it names. Raises UsageError for other sets of files.

    files: by plain name (checked by the caller); folder: an empty one, in which they are read. What they name elsewhere on this
    machine is refused by the readers themselves (`confined`).
    """

    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.job import diagnose
    from vcmm.show.pages.diagnosis import sentences

    heads = [n for n in files if n.endswith(".toml") and b"recording/" in files[n]]
    if len(heads) != 1:
        raise UsageError(
            f'drop one recording (.toml with vcmm = "recording/1") and its tables; {len(heads)} are among the files'
        )
    for name, content in files.items():
        (folder / name).write_bytes(content)
    with confine(folder):
        try:
            recording, machine = load_recording(folder / heads[0])
        except VcmmError as error:
            problems = [p.replace(f"{folder}/", "") for p in getattr(error, "problems", (str(error),))]
            raise UsageError("\n".join(problems)) from None
    found = diagnose(recording, machine)
    answers = [{"effect": a.effect, "where": a.where, "probability": a.probability} for a in found.answer]
    return {"verdict": found.verdict, "sentences": list(sentences(found)), "answer": answers}
