"""A scenario with every type of characteristic on a machine of which a certificate is all that is known."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

HEAD = """vcmm = "scenario/1"
[machine]
kind = "cmm"
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.certificate]
{certificate}
[part.features]
top = {{ type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" }}
front = {{ type = "plane", point = "0 -40 10 mm", normal = [0, -1, 0], size = "80 20 mm" }}
bore = {{ type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true }}
ring = {{ type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }}
{characteristics}
[pose]
shift = "300 250 -300 mm"
[plan]
alignment = {{ plane = "top", line = "front", origin = "bore" }}
touch = {{ speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }}
[plan.styli.down]
offset = "0 0 -120 mm"
tip_diameter = "4 mm"
[[plan.steps]]
feature = "top"
stylus = "down"
points = {{ strategy = "grid", n = [5, 5], margin = "5 mm" }}
[[plan.steps]]
feature = "bore"
stylus = "down"
points = {{ strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 12 }}
[[plan.steps]]
feature = "ring"
stylus = "down"
points = {{ strategy = "even", n = 25 }}
[[plan.steps]]
feature = "front"
stylus = "down"
points = {{ strategy = "grid", n = [5, 3], margin = "3 mm" }}
"""
LIMITS = 'limits = ["-0.004 mm", "0.004 mm"]'
CHARACTERISTICS: Mapping[str, str] = {
    "size": f'of = "bore"\n{LIMITS}',
    "distance": f'between = ["front", "bore"]\n{LIMITS}',
    "angle": 'between = ["top", "front"]\nlimits = ["-20 arcsec", "20 arcsec"]',
    "roundness": 'of = "ring"\nzone = "0.004 mm"',
    "flatness": 'of = "top"\nzone = "0.004 mm"',
    "cylindricity": 'of = "bore"\nzone = "0.004 mm"',
    "perpendicularity": 'of = "bore"\ndatums = ["top"]\nzone = "0.004 mm"',
    "position": 'of = "ring"\ndatums = ["top", "front", "bore"]\nzone = "0.004 mm"',
    "circular_runout": 'of = "ring"\ndatums = ["bore"]\nzone = "0.004 mm"',
    "surface_profile": 'of = "top"\nzone = "0.008 mm"',
}


def scenario_with(folder: Path, certificate: Mapping[str, str], measured: str = "") -> Path:
    """certificate: key = text of its value; measured: the entries of [certificate.measured]."""
    stated = [f'{key} = "{value}"' for key, value in certificate.items()]
    if measured:
        stated.append(f"[machine.certificate.measured]\n{measured}")
    tables = [
        f'[[part.characteristics]]\nname = "{k}"\ntype = "{k}"\n{v}' for k, v in CHARACTERISTICS.items()
    ]
    path = folder / "task.toml"
    path.write_text(
        HEAD.format(certificate="\n".join(stated), characteristics="\n".join(tables)), encoding="utf-8"
    )
    return path
