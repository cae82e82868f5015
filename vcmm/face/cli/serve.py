"""vcmm serve: the page of a task, live on this machine."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import InputFile
from vcmm.face.workbench.bench import Bench
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.scenario import Scenario


def serve_command(
    scenario: InputFile,
    *,
    port: int = 0,
    open_browser: Annotated[bool, Parameter(name="--open", negative=())] = False,
) -> int:
    """Open the task as a live page on this machine: knobs for pose, temperature, styli, touches and scatter; U and budget follow.

    The server answers to 127.0.0.1 only, and only to the page whose address it prints. Ctrl-C ends it.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) of a measurement.
    port
        Port on 127.0.0.1; 0 takes any that is free.
    open_browser
        Open the page in the browser of this machine.
    """
    if not 0 <= port < 65536:
        raise UsageError(f"--port {port}: 0 to 65535")
    loaded = load_scenario(scenario, knobs=False)
    if not isinstance(loaded, Scenario):
        raise UsageError(f"{scenario}: the workbench is for measuring tasks; use vcmm cut for this one")
    with WorkbenchServer(Bench(loaded, scenario), port) as server:
        print(f"{server.address}\nCtrl-C ends the workbench.", flush=True)
        if open_browser:
            import webbrowser

            webbrowser.open(server.address)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print("the workbench is closed")
    return 0
