"""Every effect is placed on machines of every kind: what cannot sit on an axis is left out, and nothing fails."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.files.columns import run_columns
from vcmm.learn.diagnosis.candidates import build_catalogue
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.task.response.recording import Recording

N = 24


def everything(structure: str, kind: str) -> tuple[Recording, Machine]:
    """A recording in which every column of the catalogue stands, at random places."""
    rng = np.random.default_rng(3)
    chain = parse_structure(structure)
    axes = {a: Axis(a, (-1e3, 1e3)) for a in chain.letters}
    position = {a: rng.uniform(-1, 1, N) * (200.0 if a in "XYZ" else 1.0) for a in chain.letters}
    names = {
        c for c in run_columns() if not c.startswith(("u_", "tip_", "from_", "n", "d_", "dx", "dy", "dz"))
    }
    names |= {f"{w}_{a}{u}" for a in chain.letters for w, u in (("sense", ""), ("since_reversal", "_rad"))}
    columns = {c: rng.uniform(0.1, 2.0, N) for c in names}
    columns |= {c: rng.choice([-1.0, 1.0], N) for c in names if c.startswith("sense_")}
    columns["time_s"] = np.sort(rng.uniform(0, 3600.0, N))
    normal = rng.normal(size=(N, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    columns |= {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
    run = Run(position, np.tile([20.0, 10.0, -150.0], (N, 1)), columns)
    rows, none = np.arange(N), np.full(N, -1)
    value = 1e-3 * rng.standard_normal(N)
    measuring = kind != "path"
    return (
        Recording("all", kind, run, value, measuring, rows, normal, none, None, {}, Normal(1e-3)),
        Machine("m", "cmm", chain, axes),
    )


@pytest.mark.parametrize(
    ("structure", "kind"),
    [("w C' A' b X Y Z t", "probe"), ("w X' b Y Z C B t", "path"), ("w b C1 B2 A3 t", "angle")],
)
def test_every_effect_finds_its_places_on_a_rotary_machine(structure, kind):
    found = build_catalogue(make_problem(*everything(structure, kind)))
    places = {(f.name, w) for f in found.families for w in f.where.values()}
    rotary = [a for a in parse_structure(structure).letters if a[0] in "ABC"]
    assert {("backlash", a) for a in rotary} <= places
    bent = {w for name, w in places if name == "gradient_bending"} - {"x", "y", "z"}
    assert bent <= set("XYZ")  # a guide bends, a bearing does not
