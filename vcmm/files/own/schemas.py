"""JSON Schema of the TOML formats and of a document; effect and input tables come from the effect classes."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from vcmm.core.effect import Effect, parameter_fields, place_fields
from vcmm.core.errors import UsageError, choose_from
from vcmm.files.columns import REDRAW
from vcmm.files.own.check_list import CheckListFile
from vcmm.files.own.cut_tables import CutFile
from vcmm.files.own.design import DesignFile
from vcmm.files.own.effects import may_be_left_out
from vcmm.files.own.environment import EnvironmentTable
from vcmm.files.own.face_scan import FaceScanFile
from vcmm.files.own.features import TABLES
from vcmm.files.own.inputs import INPUT_KEYS, LAW_KEYS
from vcmm.files.own.machine import MachineFile
from vcmm.files.own.part import PartFile
from vcmm.files.own.plan import PlanFile
from vcmm.files.own.recording_tables import RecordingFile
from vcmm.files.own.scenario import JobTable, ScenarioFile
from vcmm.files.own.setup import SetupFile
from vcmm.files.own.track_document import NAME as TRACK
from vcmm.files.own.track_document import TrackDocument
from vcmm.files.schema import Table
from vcmm.physics import ALL

MODELS: dict[str, type[Table]] = {
    "machine": MachineFile,
    "scenario": ScenarioFile,
    "part": PartFile,
    "plan": PlanFile,
    "recording": RecordingFile,
    "setup": SetupFile,
    "design": DesignFile,
    "checks": CheckListFile,
    "scan": FaceScanFile,
}
DRAFT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]


def json_schema(kind: str) -> Schema:
    """Return the schema (draft 2020-12) of one file format; "track": of the document of `vcmm track`. Raises UsageError for an unknown kind."""
    if kind == "track":
        return TrackDocument.model_json_schema() | {"$schema": DRAFT, "title": TRACK}
    if kind not in MODELS:
        raise UsageError(f'unknown kind "{kind}".{choose_from(kind, [*MODELS, "track"])}')
    definitions: Schema = {}
    schema = _of(MODELS[kind], definitions)
    schema["properties"]["vcmm"] = {"const": f"{kind}/1"}
    schema["required"] = ["vcmm", *(k for k in schema.get("required", []) if k != "vcmm")]
    if kind == "scenario":
        _also_cuts(schema, definitions)
        sections: dict[str, type[Table]] = {
            "machine": MachineFile, "part": PartFile, "plan": PlanFile, "environment": EnvironmentTable, "job": JobTable,
        }  # fmt: skip
        for key, model in sections.items():
            inside = _of(model, definitions)
            inside["properties"].pop("vcmm", None)
            inside["required"] = [k for k in inside.get("required", []) if k != "vcmm"]
            schema["properties"][key] = {"anyOf": [{"type": "string", "description": "file name"}, inside]}
    head = {"$schema": DRAFT, "title": f"vcmm {kind}/1"}
    return schema | head | {"$defs": dict(sorted(definitions.items()))}


def _also_cuts(schema: Schema, definitions: Schema) -> None:
    """Add to the schema that a scenario measures ([plan]) or cuts ([cut]); each brings keys of its own."""
    schema["properties"] = _of(CutFile, definitions)["properties"] | schema["properties"]
    schema["required"] = [k for k in schema["required"] if k not in ("plan", "machine")]
    schema["anyOf"] = [{"required": ["machine", "plan"]}, {"required": ["cut"]}]


def _of(model: type[Table], definitions: Schema) -> Schema:
    """Return the schema of a model; its references are added to the definitions at the root, where they point."""
    schema = model.model_json_schema(mode="validation")
    definitions.update(schema.pop("$defs", {}))
    properties = schema["properties"]
    if model in (MachineFile, ScenarioFile):
        definitions["effect"] = {"oneOf": [_effect(e) for e in ALL]}
        definitions["input"] = _input()
        properties["effects"] = {"type": "array", "items": {"$ref": "#/$defs/effect"}}
        properties["inputs"] = {"type": "array", "items": {"$ref": "#/$defs/input"}}
    if model is PartFile:
        tables = [_feature(name, t, definitions) for name, t in TABLES.items()]
        properties["features"] = {"type": "object", "additionalProperties": {"oneOf": tables}}
    return schema


def _feature(name: str, table: type[Table], definitions: Schema) -> Schema:
    schema = table.model_json_schema(mode="validation")
    definitions.update(schema.pop("$defs", {}))
    schema["properties"]["type"] = {"const": name}
    return schema


def _effect(kind: type[Effect]) -> Schema:
    back = {v: k for k, v in kind.about.aliases.items()}
    properties: Schema = {f.name: {} for f in fields(kind) if not f.metadata.get("internal")}
    for f in place_fields(kind):
        form = "integer" if isinstance(f.default, int) else "string"
        properties[f.name] = {"type": form, "description": str(f.metadata["doc"])}
    for f in parameter_fields(kind):
        about: Schema = {"description": f"{f.metadata['doc']} ({f.metadata['unit']})"}
        about |= {"type": ["string", "array"]} if f.metadata["shape"] else {"type": "string"}
        properties[f.name] = about
        if f.name in back:
            properties[back[f.name]] = about
    return {
        "type": "object",
        "properties": {"effect": {"const": kind.name}} | properties,
        "required": ["effect", *(f.name for f in place_fields(kind) if not may_be_left_out(f))],
        "additionalProperties": False,
        "description": (kind.__doc__ or "").split("\n")[0],
    }


def _input() -> Schema:
    places = {f.name: f.default for kind in ALL for f in place_fields(kind)}
    properties: Schema = {
        name: {"type": ["integer", "string"] if isinstance(default, int) else "string"}
        for name, default in sorted(places.items())
    }
    properties |= {key: {} for key in INPUT_KEYS}
    properties["effect"] = {"enum": [e.name for e in ALL]}
    properties["law"] = {"enum": list(LAW_KEYS)}
    properties["redraw"] = {"enum": list(REDRAW)}
    return {
        "type": "object",
        "properties": properties,
        "oneOf": [{"required": ["effect", "parameter"]}, {"required": ["channel"]}],
        "additionalProperties": False,
    }
