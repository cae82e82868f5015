"""A machine of one unknown, the slope of X, and laser checks of it."""

from pathlib import Path

import numpy as np

MACHINE = """vcmm = "machine/1"
name = "small"
kind = "machine-tool"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "500 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["0 mm", "500 mm"]
[repeatability]
law = "normal"
u = "1 um"
[[effects]]
effect = "scale_factor"
axis = "X"
k = "0 um/m"
[[inputs]]
effect = "scale_factor"
axis = "X"
parameter = "k"
u = "4 um/m"
"""


def write_machine(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "checks").mkdir(exist_ok=True)
    path = folder / "machine.toml"
    path.write_text(MACHINE)
    return path


def write_check(folder: Path, date: str, positions, readings_um, name: str = "") -> Path:
    """A laser along X; where it is zeroed is free."""
    name = name or f"laser_{date}"
    rows = ["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um"]
    rows += [f"{q:g},250,250,1,0,0,{d:.9g},1" for q, d in zip(positions, readings_um)]
    (folder / f"{name}.csv").write_text("\n".join(rows) + "\n")
    path = folder / f"{name}.toml"
    date_line = f'date = "{date}"\n' if date else ""
    path.write_text(
        f'vcmm = "recording/1"\ndata = "{name}.csv"\nmachine = "../machine.toml"\nkind = "displacement"\n{date_line}'
        '[nuisance]\nzero = ""\n'
    )
    return path


def write_year(folder: Path, count: int, slope, seed: int = 1) -> Path:
    """`count` weekly checks of a slope(week) in um/m; indicated - true = -slope q."""
    rng = np.random.default_rng(seed)
    machine = write_machine(folder)
    q = np.linspace(0.0, 500.0, 11)
    for week in range(count):
        date = str(np.datetime64("2026-01-05") + 7 * week)
        write_check(folder / "checks", date, q, -slope(week) * q * 1e-3 + rng.normal(size=11))
    return machine
