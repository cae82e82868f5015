"""vcmm view: a machine or a measuring task in a window, or as a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import InputFile
from vcmm.files.toml import read_toml
from vcmm.show.console.files import output_folder
from vcmm.show.console.terminal import say

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.show.report.scene_items import Item


def view_command(
    file: InputFile,
    *,
    png: Path | None = None,
    close: Annotated[bool, Parameter(name="--close", negative=())] = False,
    look: Literal["grid", "slices", "hull"] = "grid",
) -> int:
    """Open a window with the part in its machine (scenario/1), or with the tip errors of a machine over its volume (machine/1).

    Parameters
    ----------
    file
        Scenario of a measurement, or machine file.
    png
        Write this picture instead of opening a window; works without a display.
    close
        Of a scenario: the part alone, with the uncertainty of every touch.
    look
        Of a machine: its grid of travels, straight and bent; slices through the map of its tip errors; the hull of its travels, bent.
    """
    from vcmm.show.report.window import show

    if png is not None and png.suffix.lower() != ".png":
        raise UsageError(f"--png {png}: the picture is a PNG; name it picture.png")
    items, title = _items(file, close, look)
    if png is not None:
        output_folder(png.parent)
    show(items, title, png.resolve() if png else None)
    if png:
        say(f"wrote {png}")
    return 0


def _items(file: Path, close: bool, look: str) -> tuple[Sequence[Item], str]:
    """Return the content of the window, and its title."""
    kind = str(read_toml(file).data.get("vcmm", "")).split("/")[0]
    if kind == "machine":
        from vcmm.files.own.machine import load_machine
        from vcmm.show.pages.field import volume_scene
        from vcmm.show.pages.volume import volume_hull, volume_slices

        if close:
            raise UsageError("--close is for the part of a scenario; leave it out, or name a scenario")
        machine = load_machine(file)
        scenes: dict[str, Callable[[Machine], Sequence[Item]]] = {
            "grid": volume_scene,
            "slices": volume_slices,
            "hull": volume_hull,
        }
        return scenes[look](machine), machine.name or file.stem
    if kind != "scenario":
        raise UsageError(f"{file}: a scenario/1 or machine/1 is shown, this is {kind or 'neither'}")
    if look != "grid":
        raise UsageError(
            f"--look {look} is for the volume of a machine file; leave it out, or name a machine file"
        )
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
