"""JSON Schema of the TOML formats; effect and input tables come from the effect classes."""

from __future__ import annotations

from typing import Any

from vcmm.effect import parameter_fields, place_fields
from vcmm.effects import ALL
from vcmm.errors import UsageError, choose_from
from vcmm.files.machine import MachineFile
from vcmm.files.part import TABLES, PartFile
from vcmm.files.plan import PlanFile
from vcmm.files.scenario import EnvironmentTable, JobTable, ScenarioFile
from vcmm.files.schema import Table

MODELS: dict[str, type[Table]] = {
    "machine": MachineFile,
    "scenario": ScenarioFile,
    "part": PartFile,
    "plan": PlanFile,
}


def json_schema(kind: str) -> dict[str, Any]:
    """The schema (draft 2020-12) of one file format. Raises UsageError for an unknown kind."""
    if kind not in MODELS:
        raise UsageError(f'unknown kind "{kind}".{choose_from(kind, MODELS)}')
    schema = MODELS[kind].model_json_schema(mode="validation")
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = f"vcmm {kind}/1"
    properties = schema["properties"]
    if "effects" in properties:
        properties["effects"]["items"] = {"oneOf": [_effect(e) for e in ALL]}
    if kind == "part":
        properties["features"]["additionalProperties"] = {
            "oneOf": [t.model_json_schema() for t in TABLES.values()]
        }
    if kind == "scenario":
        for key, model in (
            ("part", PartFile),
            ("plan", PlanFile),
            ("environment", EnvironmentTable),
            ("job", JobTable),
        ):
            properties[key] = {"anyOf": [{"type": "string"}, model.model_json_schema()]}
    return schema


def _effect(kind: Any) -> dict[str, Any]:
    text = {"type": "string"}
    properties: dict[str, Any] = {"effect": {"const": kind.name}}
    properties |= {f.name: text | {"description": str(f.metadata["doc"])} for f in place_fields(kind)}
    back = {v: k for k, v in kind.aliases.items()}
    for f in parameter_fields(kind):
        properties[back.get(f.name, f.name)] = {"description": f"{f.metadata['doc']} ({f.metadata['unit']})"}
    return {
        "type": "object",
        "properties": properties,
        "required": ["effect"],
        "description": (kind.__doc__ or "").split("\n")[0],
    }
