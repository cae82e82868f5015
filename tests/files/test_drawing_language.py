"""Every symbol that a drawing may carry passes through a scenario: read, measured on a machine without errors, the nominal part conforms."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.face.api import measure
from vcmm.files.own.scenario import load_scenario

HEAD = """vcmm = "scenario/1"
[machine]
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[pose]
shift = "300 250 -200 mm"
[part]
GENERAL
[part.features]
top = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "120 80 mm" }
pad = { type = "plane", point = "40 30 20 mm", normal = [0, 0, 1], size = "10 10 mm" }
side = { type = "plane", point = "60 0 10 mm", normal = [1, 0, 0], size = "80 20 mm" }
bore = { type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true }
h1 = { type = "cylinder", point = "40 0 0 mm", axis = [0, 0, 1], diameter = "10 mm", length = "20 mm", inside = true }
h2 = { type = "cylinder", point = "-40 0 0 mm", axis = [0, 0, 1], diameter = "10 mm", length = "20 mm", inside = true }
neck = { type = "cylinder", point = "0 0 20 mm", axis = [0, 0, 1], diameter = "50 mm", length = "15 mm" }
j1 = { type = "cylinder", point = "0 0 40 mm", axis = [0, 0, 1], diameter = "20 mm", length = "15 mm" }
j2 = { type = "cylinder", point = "0 0 -20 mm", axis = [0, 0, 1], diameter = "20 mm", length = "15 mm" }
ring = { type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }
edge = { type = "line", point = "-40 0 20 mm", direction = [1, 0, 0], normal = [0, 0, 1], length = "80 mm" }
"""
PLAN = """
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
"""
PLANE, LINE, RING = (
    'strategy = "grid", n = [3, 3]',
    'strategy = "even", n = 400',
    'strategy = "even", n = 350',
)
HOLE = 'strategy = "levels", at = ["4 mm", "12 mm"], n = 6'
POINTS = {
    "top": PLANE, "pad": PLANE, "side": PLANE, "edge": LINE, "ring": RING, "bore": HOLE, "h1": HOLE, "h2": HOLE, "neck": HOLE, "j1": HOLE, "j2": HOLE,
}  # fmt: skip
SIZE_H1 = '[[part.characteristics]]\nname = "h1"\ntype = "size"\nof = "h1"\nlimits = ["0 mm", "0.1 mm"]\n'
CASES = {
    "circular run-out": 'type = "circular_runout"\nof = "neck"\ndatums = ["bore"]\nzone = "0.02 mm"',
    "total run-out": 'type = "total_runout"\nof = "neck"\ndatums = ["bore"]\nzone = "0.02 mm"',
    "run-out about a common datum A-B": 'type = "circular_runout"\nof = "neck"\ndatums = [["j1", "j2"]]\nzone = "0.02 mm"',
    "profile of a surface": 'type = "surface_profile"\nof = "neck"\ndatums = ["top", "bore"]\nzone = "0.02 mm"',
    "profile of a line": 'type = "line_profile"\nof = "edge"\ndatums = ["top"]\nzone = "0.02 mm"',
    "pattern": 'type = "position"\nof = ["h1", "h2"]\ndatums = ["top", "bore", "side"]\nzone = "0.1 mm"',
    "composite, lower line": 'type = "position"\nof = ["h1", "h2"]\ndatums = ["top"]\nzone = "0.02 mm"',
    "pattern, separate zones": 'type = "position"\nof = ["h1", "h2"]\ndatums = ["top", "bore", "side"]\nzones = "SZ"\nzone = "0.1 mm"',
    "projected zone": 'type = "position"\nof = "h1"\ndatums = ["top", "bore", "side"]\nprojected = "20 mm"\nzone = "0.1 mm"',
    "MMR": 'type = "position"\nof = "h1"\ndatums = ["top", "bore", "side"]\nmaterial = "M"\nzone = "0.1 mm"',
    "LMR": 'type = "position"\nof = "h1"\ndatums = ["top", "bore", "side"]\nmaterial = "L"\nzone = "0.1 mm"',
    "RPR": 'type = "position"\nof = "h1"\ndatums = ["top", "bore", "side"]\nmaterial = "M"\nreciprocity = true\nzone = "0.1 mm"',
    "partial datum": 'type = "perpendicularity"\nof = "bore"\ndatums = ["pad"]\nzone = "0.02 mm"',
    "datum in contact": 'type = "perpendicularity"\nof = "top"\ndatums = ["bore"]\ndatum_criterion = "X"\nzone = "0.02 mm"',
    "common plane": 'type = "perpendicularity"\nof = "bore"\ndatums = [["top", "pad"]]\nzone = "0.02 mm"',
    "H7": 'type = "size"\nof = "bore"\nlimits = "H7"',
    "filter, closed": 'type = "roundness"\nof = "ring"\nfilter = "gaussian"\nupr = 50\nzone = "0.02 mm"',
    "filter, open": 'type = "straightness"\nof = "edge"\nfilter = "spline"\ncutoff = "2.5 mm"\nzone = "0.02 mm"',
}
GENERAL = {
    "ISO 2768": ('general_tolerances = "ISO 2768-mK"', 'type = "perpendicularity"\nof = "bore"\ndatums = ["top"]'),
    "ISO 2768 of a size": ('general_tolerances = "ISO 2768-mK"', 'type = "size"\nof = "bore"'),
    "ISO 22081": ('general_tolerances = { size = "0.1 mm", angle = "0.5 deg", profile = "0.3 mm" }', 'type = "surface_profile"\nof = "neck"\ndatums = ["top", "bore"]'),
}  # fmt: skip


def scenario(folder: Path, lines: str, general: str = "") -> Path:
    wanted = [f for f in POINTS if f'"{f}"' in lines]
    steps = "".join(
        f'[[plan.steps]]\nfeature = "{f}"\nstylus = "down"\npoints = {{ {POINTS[f]} }}\n' for f in wanted
    )
    sized = SIZE_H1 if "material" in lines else ""
    path = folder / "scenario.toml"
    named = f'[[part.characteristics]]\nname = "asked"\n{lines}\n'
    path.write_text(HEAD.replace("GENERAL", general) + named + sized + PLAN + steps)
    return path


@pytest.mark.parametrize("name", CASES)
def test_a_symbol_passes_through(name: str, tmp_path: Path) -> None:
    loaded = load_scenario(scenario(tmp_path, CASES[name]))
    c = loaded.part.characteristics[0]
    assert c.zone is not None or c.limits is not None
    found = measure(loaded).values[0]
    assert found.value == pytest.approx(30.0 if c.type == "size" else 0.0, abs=1e-6)


@pytest.mark.parametrize("name", GENERAL)
def test_a_general_tolerance_holds_where_nothing_is_stated(name: str, tmp_path: Path) -> None:
    """Of 30 mm: ISO 2768-m +- 0.2 mm (6 to 30 mm); square within 0.4 mm in class K up to 100 mm; profile as the note says."""
    general, lines = GENERAL[name]
    c = load_scenario(scenario(tmp_path, lines, general)).part.characteristics[0]
    stated = {
        "ISO 2768": (c.zone, 0.4),
        "ISO 2768 of a size": (c.limits, (-0.2, 0.2)),
        "ISO 22081": (c.zone, 0.3),
    }[name]
    assert stated[0] == pytest.approx(stated[1])


def test_a_material_requirement_of_a_face_says_what_is_wrong(tmp_path: Path) -> None:
    """A plane has no size, so there is none to be added."""
    lines = 'type = "perpendicularity"\nof = "side"\ndatums = ["top"]\nmaterial = "M"\nzone = "0.1 mm"'
    with pytest.raises(DataError) as told:
        load_scenario(scenario(tmp_path, lines))
    assert '"side" is a plane; leave it out' in str(told.value)
    assert "add its size" not in str(told.value)
