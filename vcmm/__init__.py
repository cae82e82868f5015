"""vcmm: a virtual CMM and virtual machining simulator, from machine errors to task-specific uncertainty.

    import vcmm
    scenario = vcmm.load_scenario("plate.toml")
    result = vcmm.uncertainty(scenario)
    print(result["bore diameter"])       # one line; in a notebook `result` shows a table
    result.to_dict(), result.to_dataframe(), result.report("plate.html"), result.plot()

Everything public is imported on first use, so that `import vcmm` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from vcmm.core import views

if TYPE_CHECKING:  # the same names for type checkers and editors
    from vcmm import physics as effects
    from vcmm.answer.placing.planning import optimise_plan
    from vcmm.core import kinematics, laws
    from vcmm.core.effect import Effect
    from vcmm.core.errors import ModelLimit, UsageError
    from vcmm.core.inputs import Input
    from vcmm.core.kinematics import Axis
    from vcmm.core.machine import Machine
    from vcmm.core.pose import Pose
    from vcmm.core.run import Array, Run, Series
    from vcmm.face.api import cut, evaluate, measure, place, uncertainty
    from vcmm.face.count_api import audit, certificate, routes
    from vcmm.face.file_api import convert, nc
    from vcmm.face.machine_api import calibrate, compare, compensate, diagnose, field, test
    from vcmm.face.public import (
        calibration,
        diagnosis,
        faces,
        instruments,
        machining,
        measuring,
        placement,
        reversals,
        tables,
    )
    from vcmm.face.twins import twin
    from vcmm.files.learned.track import track
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.design import load_design
    from vcmm.files.own.library import example
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.scenario import load_scenario
    from vcmm.files.own.setup import load_setup
    from vcmm.learn.diagnosis.several import diagnose_several
    from vcmm.part.gps import characteristics
    from vcmm.program.setup import Setup
    from vcmm.show import charts, report
    from vcmm.task.measuring.cut_scenario import CutScenario
    from vcmm.task.measuring.scenario import Scenario
    from vcmm.task.measuring.settings import Settings
    from vcmm.task.response.recording import Recording

__version__ = "0.1.0"

views.fill_from(lambda: importlib.import_module("vcmm.show.views"))

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
    "audit": "vcmm.face.count_api",
    "field": "vcmm.face.machine_api",
    "place": "vcmm.face.api",
    "diagnose": "vcmm.face.machine_api",
    "diagnose_several": "vcmm.learn.diagnosis.several",
    "cut": "vcmm.face.api",
    "compensate": "vcmm.face.machine_api",
    "calibrate": "vcmm.face.machine_api",
    "certificate": "vcmm.face.count_api",
    "compare": "vcmm.face.machine_api",
    "convert": "vcmm.face.file_api",
    "nc": "vcmm.face.file_api",
    "routes": "vcmm.face.count_api",
    "test": "vcmm.face.machine_api",
    "track": "vcmm.files.learned.track",
    "load_cut": "vcmm.files.own.cut_scenario",
    "load_recording": "vcmm.files.own.recording",
    "Array": "vcmm.core.run",
    "Series": "vcmm.core.run",
    "Pose": "vcmm.core.pose",
    "Setup": "vcmm.program.setup",
    "Recording": "vcmm.task.response.recording",
    "CutScenario": "vcmm.task.measuring.cut_scenario",
    "UsageError": "vcmm.core.errors",
    "ModelLimit": "vcmm.core.errors",
    "load_setup": "vcmm.files.own.setup",
    "load_design": "vcmm.files.own.design",
    "twin": "vcmm.face.twins",
}
# Subjects: modules under the name by which programs ask for them, as vcmm.effects.Squareness.
_SUBJECTS = {
    "calibration": "vcmm.face.public.calibration",
    "characteristics": "vcmm.part.gps.characteristics",
    "charts": "vcmm.show.charts",
    "diagnosis": "vcmm.face.public.diagnosis",
    "effects": "vcmm.physics",
    "faces": "vcmm.face.public.faces",
    "instruments": "vcmm.face.public.instruments",
    "kinematics": "vcmm.core.kinematics",
    "laws": "vcmm.core.laws",
    "machining": "vcmm.face.public.machining",
    "measuring": "vcmm.face.public.measuring",
    "placement": "vcmm.face.public.placement",
    "report": "vcmm.show.report",
    "reversals": "vcmm.face.public.reversals",
    "tables": "vcmm.face.public.tables",
}
__all__ = ["__version__", *_HOME, *_SUBJECTS]


def __getattr__(name: str) -> Any:
    if name in _SUBJECTS:
        return importlib.import_module(_SUBJECTS[name])
    if name not in _HOME:
        from vcmm.core.errors import choose_from

        raise AttributeError(f'vcmm has no "{name}".{choose_from(name, __all__)}')
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
