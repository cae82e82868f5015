"""A browser without network for the pages, one with this machine's loopback for the workbench, and the pages themselves."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.shop.machining import shop
from vcmm.face.cli import run

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
SIZE = {"width": 1280, "height": 900}
JOBS = {
    "uncertainty": ("uncertainty", "plate.toml"),
    "field": ("field", "ballbar/machine.toml"),
    "diagnosis": ("diagnose", "ballbar.toml"),
    "cut": ("cut", "boss.toml"),
}


@pytest.fixture(scope="session")
def playing() -> Iterator[Any]:
    sync_api = pytest.importorskip(
        "playwright.sync_api", reason="playwright is missing: pip install vcmm[browser]"
    )
    with sync_api.sync_playwright() as playwright:
        yield playwright


def opened(playing: Any, program: str) -> Any:
    """The browser, or a skip with its own words where it does not start."""
    from playwright.sync_api import Error

    try:
        return playing.chromium.launch(executable_path=program, args=FLAGS)
    except Error as why:
        pytest.skip(f"{program} does not start: {str(why).splitlines()[0]}")


@pytest.fixture(scope="session")
def program() -> str:
    """Path of the browser; CHROMIUM names another one."""
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, PROGRAMS)), None)
    if found is None:
        pytest.skip("no browser here: install chromium, or name one in CHROMIUM")
    return found


@pytest.fixture(scope="session")
def unplugged(playing: Any, program: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A browser in a network namespace without any interface, where this may be made (root); else as it is."""
    start = tmp_path_factory.mktemp("browser") / "start.sh"
    alone = (
        shutil.which("unshare")
        and subprocess.run(["unshare", "-n", "true"], capture_output=True).returncode == 0
    )
    start.write_text(f'#!/bin/sh\nexec {"unshare -n " if alone else ""}"{program}" "$@"\n')
    start.chmod(0o755)
    browser = opened(playing, str(start))
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def plugged(playing: Any, program: str) -> Iterator[Any]:
    """A browser that reaches this machine."""
    browser = opened(playing, program)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the output of every job of JOBS, each in a folder of its name."""
    folder = tmp_path_factory.mktemp("reports")
    for name, text in (
        ("boss.toml", shop.SCENARIO), ("mill.toml", shop.MACHINE + '[repeatability]\nu = "1 um"\n'), ("setup.toml", shop.SETUP), ("part.nc", shop.PROGRAM),
    ):  # fmt: skip
        (folder / name).write_text(text)
    assert run(["new", "plate", "--out", str(folder)]) == run(["new", "ballbar", "--out", str(folder)]) == 0
    for name, (verb, file) in JOBS.items():
        assert run([verb, str(folder / file), "--out", str(folder / name)]) in (0, 1)
    return folder


class Watched:
    """A page of the browser with what it asked for and what it complained about."""

    def __init__(self, browser: Any, **look: Any) -> None:
        self.context = browser.new_context(viewport=SIZE, **look)
        self.page = self.context.new_page()
        self.asked: list[str] = []
        self.complaints: list[str] = []
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", lambda said: said.type == "error" and self.complaints.append(said.text))

    def scene(self, number: int = 0) -> Any:
        """The scene, scrolled into view and drawn."""
        figure = self.page.locator("figure", has=self.page.locator(".scene")).nth(number)
        figure.scroll_into_view_if_needed()
        figure.locator(".live .main-svg").first.wait_for(state="attached", timeout=30_000)
        self.page.wait_for_function(
            "n => document.querySelectorAll('.scene')[n].closest('figure').matches('.drawn')", arg=number
        )
        return figure

    def __enter__(self) -> Watched:
        return self

    def __exit__(self, *_: object) -> None:
        self.context.close()
