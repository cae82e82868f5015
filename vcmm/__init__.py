"""vcmm: a virtual CMM and virtual machining simulator, from machine errors to task-specific uncertainty.

    import vcmm
    scenario = vcmm.load_scenario("plate.toml")
    result = vcmm.uncertainty(scenario)
    for c in result.characteristics:
        print(c.name, c.value, c.expanded, c.decision)

Everything public is imported on first use, so that `import vcmm` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"

_HOME = {
    "load_machine": "vcmm.files.machine",
    "load_scenario": "vcmm.files.scenario",
    "Machine": "vcmm.machine",
    "Axis": "vcmm.kinematics",
    "Run": "vcmm.run",
    "Effect": "vcmm.effect",
    "Input": "vcmm.inputs",
    "Scenario": "vcmm.scenario",
    "Settings": "vcmm.settings",
    "measure": "vcmm.jobs",
    "optimise_plan": "vcmm.placing.planning",
    "uncertainty": "vcmm.jobs",
    "field": "vcmm.volumetric",
    "place": "vcmm.jobs",
    "diagnose": "vcmm.diagnosing",
    "cut": "vcmm.machining.job",
    "compensate": "vcmm.compensating.job",
    "load_cut": "vcmm.files.cut_scenario",
    "load_recording": "vcmm.files.recording",
}
__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        from vcmm.errors import choose_from

        raise AttributeError(f'vcmm has no "{name}".{choose_from(name, __all__)}')
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
