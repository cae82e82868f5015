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

from vcmm.former_paths import install as _keep_former_paths

__version__ = "0.1.0"

_HOME = {
    "load_machine": "vcmm.files.machine",
    "load_scenario": "vcmm.files.scenario",
    "Machine": "vcmm.core.machine",
    "Axis": "vcmm.core.kinematics",
    "Run": "vcmm.core.run",
    "Effect": "vcmm.core.effect",
    "Input": "vcmm.core.inputs",
    "Scenario": "vcmm.measuring.scenario",
    "Settings": "vcmm.measuring.settings",
    "measure": "vcmm.api",
    "optimise_plan": "vcmm.placing.planning",
    "uncertainty": "vcmm.api",
    "evaluate": "vcmm.api",
    "audit": "vcmm.inference.audit",
    "field": "vcmm.response.volumetric",
    "place": "vcmm.api",
    "diagnose": "vcmm.diagnosis.job",
    "cut": "vcmm.machining.job",
    "compensate": "vcmm.compensating.job",
    "calibrate": "vcmm.calibrating.job",
    "load_cut": "vcmm.files.cut_scenario",
    "load_recording": "vcmm.files.recording",
}
__all__ = ["__version__", *_HOME]
_keep_former_paths()


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        from vcmm.core.errors import choose_from

        raise AttributeError(f'vcmm has no "{name}".{choose_from(name, __all__)}')
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
