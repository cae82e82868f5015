"""vcmm view: a machine or a measuring task in a window, or as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.files.toml import read_toml
from vcmm.show.console.files import output_folder
from vcmm.show.console.terminal import say


def view_command(file: Path, *, png: Path | None = None, close: Annotated[bool, Parameter(name="--close", negative=())] = False) -> int:  # fmt: skip
    """Open a window with the part in its machine (scenario/1), or with the tip errors of a machine over its volume (machine/1).

    Parameters
    ----------
    file
        Scenario of a measurement, or machine file.
    png
        Write this picture instead of opening a window; works without a display.
    close
        Of a scenario: the part alone, with the uncertainty of every touch.
    """
    from vcmm.show.report.window import show

    if png is not None and png.suffix.lower() != ".png":
        raise UsageError(f"--png {png}: the picture is a PNG; name it picture.png")
    items, title = _items(file, close)
    if png is not None:
        output_folder(png.parent)
    show(items, title, png.resolve() if png else None)
    if png:
        say(f"wrote {png}")
    return 0


def _items(file: Path, close: bool) -> tuple[Any, str]:
    """What the window holds, and its title."""
    kind = str(read_toml(file).data.get("vcmm", "")).split("/")[0]
    if kind == "machine":
        from vcmm.files.own.machine import load_machine
        from vcmm.show.pages.field import volume_scene

        machine = load_machine(file)
        return volume_scene(machine), machine.name or file.stem
    if kind != "scenario":
        raise UsageError(f"{file}: a scenario/1 or machine/1 is shown, this is {kind or 'neither'}")
    from vcmm.answer.evaluation.linear import prepare_model
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.pages.view import task_in_machine, touches_of
    from vcmm.task.measuring.scenario import Scenario

    loaded = load_scenario(file)
    if not isinstance(loaded, Scenario):
        raise UsageError(f"{file}: this scenario cuts; vcmm cut --out shows its part")
    task = loaded.task()
    return touches_of(task, prepare_model(task).influences) if close else task_in_machine(
        task
    ), loaded.name or file.stem
