"""The flags that verbs share: which verb has which, and of every one that is absent the reason."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from vcmm.face.cli import VERBS, verb_help
from vcmm.face.cli.calibrate_jobs import JOBS

SHARED = ("--json", "--out", "--seed", "--workers", "--cluster", "--shard")
TOGETHER = ("--workers", "--cluster", "--shard")  # who does the work: a verb has all three or none

LOOK_UP = "a look-up: nothing is computed that one would keep; --json prints it"
NO_DRAWS = "nothing is drawn"
FIXED = "shows figures that are printed elsewhere, so its seed stands in its scenario"
ONE = "one computation of seconds; nothing of it is counted in blocks"
SEQUENCE = "each step needs the one before"
ITS_DOCUMENT = "its output is no result but the thing asked for"

# verb -> flag -> why it has no meaning there. A flag that is not named is there.
ABSENT: dict[str, dict[str, str]] = {
    "demo": {"--seed": FIXED, "--workers": ONE},
    "new": {"--json": "writes a file to edit", "--seed": NO_DRAWS, "--workers": ONE},
    "check": {"--seed": NO_DRAWS, "--workers": ONE},
    "field": {"--seed": NO_DRAWS, "--workers": ONE},
    "measure": {"--workers": "one draw"},
    "uncertainty": {},
    "evaluate": {"--workers": "what was measured is inverted in one process, in seconds"},
    "audit": {},
    "certificate": {"--workers": "its priors are compared on the same trials, in one process"},
    "routes": {"--workers": "its routes are compared on the same trials, in one process"},
    "rerun": {"--seed": "that of the pack", "--workers": "the command of the pack, as it was"},
    "place": {},
    "diagnose": {},
    "calibrate": {"--workers": ONE},
    "calibrate fit": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate design": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate program": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate simulate": {"--workers": ONE},
    "calibrate thermal": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate nodes": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate face": {"--seed": NO_DRAWS, "--workers": ONE},
    "calibrate compare": {
        "--out": "--out of calibrate is a machine file, and this writes none",
        "--seed": NO_DRAWS,
        "--workers": ONE,
    },
    "track": {"--workers": SEQUENCE},
    "test": {"--workers": ONE},
    "compare": {"--workers": ONE},
    "nc": {"--seed": NO_DRAWS, "--workers": ONE},
    "cut": {},
    "loop": {"--workers": SEQUENCE},
    "compensate": {"--seed": NO_DRAWS, "--workers": SEQUENCE},
    "convert": {"--seed": NO_DRAWS, "--workers": ONE},
    "view": {
        "--json": ITS_DOCUMENT,
        "--out": "--png names the picture",
        "--seed": NO_DRAWS,
        "--workers": ONE,
    },
    "serve": {
        "--json": ITS_DOCUMENT,
        "--out": ITS_DOCUMENT,
        "--seed": "that of the scenario",
        "--workers": ONE,
    },
    "merge": {"--seed": "that of the shards", "--workers": "puts together what others have done"},
    "list": {"--out": LOOK_UP, "--seed": NO_DRAWS, "--workers": ONE},
    "explain": {"--out": LOOK_UP, "--seed": NO_DRAWS, "--workers": ONE},
    "doctor": {"--seed": NO_DRAWS, "--workers": ONE},
    "schema": {"--json": "prints a JSON Schema", "--seed": NO_DRAWS, "--workers": ONE},
}
NAMES = [*VERBS, *(f"calibrate {job}" for job in JOBS)]


def flags_of(name: str) -> set[str]:
    verb, _, job = name.partition(" ")
    file = f"{verb}_jobs.py" if job else f"{verb}.py"
    source = (Path(verb_help.__file__).parent / file).read_text(encoding="utf-8")
    return {o.name for o in verb_help.options_of(ast.parse(source), f"{job or verb}_command")}


@pytest.mark.parametrize("name", NAMES)
def test_a_verb_has_every_shared_flag_or_a_reason(name: str):
    reasons = ABSENT[name]
    without = {flag for key in reasons for flag in (TOGETHER if key == "--workers" else (key,))}
    assert set(SHARED) & flags_of(name) == set(SHARED) - without
    assert all(len(reason) > 5 for reason in reasons.values())


def test_no_verb_is_forgotten():
    assert set(ABSENT) == set(NAMES)
