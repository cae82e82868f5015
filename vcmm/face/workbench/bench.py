"""One task on the bench: previews at once, long work one at a time, the older given up when a knob moves on or it is cancelled."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError
from vcmm.face import api
from vcmm.face.workbench.jobs import run_files, run_open
from vcmm.face.workbench.live import preview
from vcmm.face.workbench.saved import saved_text
from vcmm.face.workbench.sweep import pictures, sweep
from vcmm.files.own.scenario import turned_knobs
from vcmm.show.console.documents import document
from vcmm.show.pages.uncertainty import decision_chart, scenes
from vcmm.show.report.scene import figure_of
from vcmm.show.tables.uncertainty import uncertainty_json
from vcmm.task.measuring.knobs import knobs_of, with_knobs
from vcmm.task.measuring.scenario import Scenario

Question = tuple[str, int]  # the page that asks, and which of its questions
MOST_PAGES = 100  # pages whose newest question is remembered


class GivenUp(Exception):
    """A newer question has come; the answer to this one is no longer wanted."""


class Bench:
    """The task, and which question of every open page is its newest. Answers are dictionaries of JSON."""

    def __init__(self, scenario: Scenario, source: Path | None = None) -> None:
        """source: the file of the scenario, whose [knobs] are not turned yet (`load_scenario(..., knobs=False)`)."""
        self.scenario, self.source = scenario, source
        self._turned = {} if source is None else turned_knobs(source)
        self._working = threading.Lock()
        self._asked = threading.Lock()
        self._newest: dict[str, int] = {}
        self._done: dict[str, tuple[str, float | None]] = {}

    def state(self) -> dict[str, Any]:
        """Name, knobs with their ranges, and where those stand that the file has turned."""
        knobs = [vars(k) | {"low": k.reach[0], "high": k.reach[1]} for k in knobs_of(self.scenario)]
        return {"name": self.scenario.name, "knobs": knobs, "turned": self._turned}

    def progress(self, page: str = "") -> dict[str, Any]:
        """What the long work of a page is at, in words and as a share; empty where it has none."""
        text, share = self._done.get(page, ("", None))
        return {"text": text, "share": share}

    def cancel(self, page: str = "") -> dict[str, Any]:
        """Ends what a page has asked for: it answers GivenUp at its next step."""
        self._ask(page)
        return {"cancelled": True}

    def saved(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The scenario file with the knobs at `values`, to be kept in the folder of the one that was opened."""
        if self.source is None:
            raise UsageError(
                "this task was not read from a file; vcmm serve SCENARIO opens one that can be saved"
            )
        stem = self.source.stem.removesuffix("-turned")
        return {"name": f"{stem}-turned.toml", "toml": saved_text(self.source, self.scenario, values)}

    def sweep(self, values: Mapping[str, Any], knob: str, page: str = "") -> dict[str, Any]:
        """U of every characteristic along one knob; other pages may ask between two of its steps."""
        mine = self._ask(page)

        def step(done: int, total: int) -> None:
            self._check_newest(mine)
            self._done[page] = (f"sweep, {done} of {total}", done / total)

        try:
            found = sweep(self.scenario, values, knob, step)
            with self._working:
                return found | {"pictures": pictures(self.scenario, found)}
        finally:
            self._done.pop(page, None)

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
            self._done[page] = (text, share)

        try:
            with self._working:
                self._check_newest(mine)
                result = api.uncertainty(chosen, progress=report)
                self._check_newest(mine)
                zones = [decision_chart(c) for c in result.characteristics]
        finally:
            self._done.pop(page, None)
        figures = [figure_of(items)[0] for items in scenes(result)]
        body = {"preview": False, **uncertainty_json(result), "figures": figures, "pictures": zones}
        return document("vcmm.uncertainty/1", body, seed=result.seed, files=[], warnings=result.warnings)

    def job(
        self, name: str, files: Mapping[str, bytes], folder: Path, values: Mapping[str, Any], page: str = ""
    ) -> dict[str, Any]:
        """Another job: on the task with its knobs at `values`, or with dropped files. GivenUp when it is cancelled."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)

        def report(text: str, share: float | None) -> None:
            self._check_newest(mine)
            self._done[page] = (text, share)

        try:
            with self._working:
                self._check_newest(mine)
                if files:
                    return run_files(name, files, folder, chosen, report)
                return run_open(name, chosen, report)
        finally:
            self._done.pop(page, None)

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

    files: by plain name (checked by the caller); folder: an empty one, in which they are read.
    """
    return run_files("diagnose", files, folder, None, lambda text, share: None)
