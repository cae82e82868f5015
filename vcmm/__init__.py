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
    "example": "vcmm.files.own.library",
    "load_machine": "vcmm.files.own.machine",
    "load_scenario": "vcmm.files.own.scenario",
    "Machine": "vcmm.core.machine",
    "Axis": "vcmm.core.kinematics",
    "Run": "vcmm.core.run",
    "Effect": "vcmm.core.effect",
    "Input": "vcmm.core.inputs",
    "Scenario": "vcmm.task.measuring.scenario",
    "Settings": "vcmm.task.measuring.settings",
    "measure": "vcmm.face.api",
    "optimise_plan": "vcmm.answer.placing.planning",
    "uncertainty": "vcmm.face.api",
    "evaluate": "vcmm.face.api",
    "audit": "vcmm.answer.inference.audit",
    "field": "vcmm.task.response.volumetric",
    "place": "vcmm.face.api",
    "diagnose": "vcmm.learn.diagnosis.job",
    "diagnose_several": "vcmm.learn.diagnosis.several",
    "cut": "vcmm.shop.machining.job",
    "compensate": "vcmm.compensation.job",
    "calibrate": "vcmm.learn.calibration.job",
    "load_cut": "vcmm.files.own.cut_scenario",
    "load_recording": "vcmm.files.own.recording",
    "twin": "vcmm.face.twins",
}
__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        from vcmm.core.errors import choose_from

        raise AttributeError(f'vcmm has no "{name}".{choose_from(name, __all__)}')
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
