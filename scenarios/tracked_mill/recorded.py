"""A year of checks of one machining centre: what `vcmm new tracked_mill` copies into its folder `checks`.

    DATE_plate   every fourth Monday: twelve spheres of a calibrated plate at two heights, touched by the probe in the spindle
    DATE_bar     every other month: a ball bar in three planes
    DATE_laser   once, in June: a laser along X

The machine is three slopes, three squarenesses and the warmth of its scales, added up by hand; no effect of the catalogue is used:

    x:  (s_X + 10 um/(m K) (T_X - 20)) x - c y + b z      c = C0Y, b = B0Z
    y:  (s_Y + 10 um/(m K) (T_Y - 20)) y - a z            a = A0Z
    z:  (s_Z + 10 um/(m K) (T_Z - 20)) z

The screw of X wears, the slopes wander and go with the season, the hall is colder in winter, and on 18 June the spindle ran into a vice.
"""

from __future__ import annotations

import numpy as np

from vcmm import Array

START, SEED = np.datetime64("2026-01-05"), 33
DAYS = 364
LENGTH = 500.0  # mm, of every travel
WEAR, SEASON = 12.0, 2.5  # um/m: of X in a year; of all slopes to either side
WALK, TURN = 2.0, 2.0  # um/m and urad in a year: what slopes and squarenesses wander
COLLISION_DAY, COLLISION = 164, 38.0  # 18 June; urad of C0Y
EXPANSION, ASSUMED = 10.6, 10.0  # um/(m K): of the scales, and in the machine file
PLATE_U, BAR_U, LASER_U = 0.8, 0.4, 0.3  # um, of one reading
NAMES = ("sX", "sY", "sZ", "C0Y", "B0Z", "A0Z")


def day_name(day: int) -> str:
    return str(START + day)


def truth() -> Array:
    """(DAYS + 1, 6): slopes in um/m and squarenesses in urad of every day."""
    rng = np.random.default_rng([SEED, 1])
    start = np.array([2.0, -1.5, 1.0, 3.0, -2.0, 1.5])
    steps = rng.normal(size=(DAYS, 6)) * np.array([WALK] * 3 + [TURN] * 3) / np.sqrt(365.25)
    steps[:, 0] += WEAR / 365.25
    steps[COLLISION_DAY - 1, 3] += COLLISION
    out = start + np.concatenate([np.zeros((1, 6)), np.cumsum(steps, axis=0)])
    out[:, :3] += SEASON * np.sin(2 * np.pi * np.arange(DAYS + 1) / 365.25)[:, None]
    return np.asarray(out)


def temperatures(day: int) -> Array:
    """(3,) degC of the scales X Y Z: 18 in winter, 23 in summer, and what a day differs by."""
    rng = np.random.default_rng([SEED, 2, day])
    hall = 20.5 - 2.5 * np.cos(2 * np.pi * (day - 15) / 365.25) + 0.5 * rng.normal()
    return np.asarray(hall + np.array([0.3, 0.1, 0.6]) + 0.1 * rng.normal(size=3)).round(2)


def tip(theta: Array, warm: Array, q: Array) -> Array:
    """Tip error (n, 3) um at positions q (n, 3) mm; theta (6,), warm (3,) degC of the scales."""
    m = q * 1e-3
    out = (theta[:3] + EXPANSION * (warm - 20.0)) * m
    out[:, 0] += -theta[3] * m[:, 1] + theta[4] * m[:, 2]
    out[:, 1] += -theta[5] * m[:, 2]
    return np.asarray(out)


def plate(theta: Array, day: int) -> list[str]:
    """Rows: what the probe reads of twelve spheres; where the plate lies is free."""
    rng, warm = np.random.default_rng([SEED, 3, day]), temperatures(day)
    q = np.array([[x, y, z] for x in (50.0, 250.0, 450.0) for y in (50.0, 450.0) for z in (50.0, 400.0)])
    lies = rng.normal(size=3) * 40.0 + np.cross(rng.normal(size=3) * 20.0, q * 1e-3)
    read = -tip(theta, warm, q) + lies + PLATE_U * rng.normal(size=q.shape)
    head = "X_mm,Y_mm,Z_mm,dx_um,dy_um,dz_um,temp_scale_x_C,temp_scale_y_C,temp_scale_z_C"
    return [head, *(_row(*a, *(f"{v:.3f}" for v in b), *warm) for a, b in zip(q, read))]


def bar(theta: Array, day: int) -> list[str]:
    """Rows: a ball bar of 150 mm about (250, 250, 200) in XY, YZ, ZX; its length and where its sphere lies are free."""
    rng, warm = np.random.default_rng([SEED, 4, day]), temperatures(day)
    centre, angles = np.array([250.0, 250.0, 200.0]), np.radians(np.arange(0, 360, 15))
    ways = np.zeros((3, len(angles), 3))
    for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
        ways[k, :, i], ways[k, :, j] = np.cos(angles), np.sin(angles)
    way = ways.reshape(-1, 3)
    q = centre + 150.0 * way
    moved = tip(theta, warm, q) - tip(theta, warm, centre[None])
    read = ((moved + rng.normal(size=3) * 8.0) * way).sum(axis=1) + 2.0 * rng.normal()
    read += BAR_U * rng.normal(size=len(q))
    head = (
        "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,d_um,u_um,temp_scale_x_C,temp_scale_y_C,temp_scale_z_C"
    )
    return [
        head,
        *(_row(*(f"{v:.4f}" for v in a), *centre, f"{b:.3f}", BAR_U, *warm) for a, b in zip(q, read)),
    ]


def laser(theta: Array, day: int) -> list[str]:
    """Rows: a laser along X, there and back; where it is zeroed is free."""
    rng, warm = np.random.default_rng([SEED, 5, day]), temperatures(day)
    q = np.tile([250.0, 250.0, 200.0], (22, 1))
    q[:, 0] = np.r_[np.linspace(0, LENGTH, 11), np.linspace(LENGTH, 0, 11)]
    read = -tip(theta, warm, q)[:, 0] + 5.0 * rng.normal() + LASER_U * rng.normal(size=len(q))
    head = "X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um,temp_scale_x_C,temp_scale_y_C,temp_scale_z_C"
    return [head, *(_row(*a, 1, 0, 0, f"{b:.3f}", LASER_U, *warm) for a, b in zip(q, read))]


def _row(*values: object) -> str:
    return ",".join(v if isinstance(v, str) else f"{v:g}" for v in values)


KINDS = {  # kind of check: (kind of recording, its other lines)
    "plate": ("probe", '[nuisance]\nrigid = ""\n'),
    "bar": ("length", 'observed = "actual - commanded"\n[nuisance]\nzero = ""\ncentre = ""\n'),
    "laser": ("displacement", '[nuisance]\nzero = ""\n'),
}


def calendar() -> list[tuple[int, str]]:
    """(day, kind of check) of the year."""
    plates = [(day, "plate") for day in range(0, DAYS + 1, 28)]
    return sorted([*plates, *((day, "bar") for day in range(31, DAYS, 60)), (150, "laser")])


def texts() -> dict[str, str]:
    """Name -> text of the recordings beside scenarios/tracked_mill.toml."""
    theta, write, out = truth(), {"plate": plate, "bar": bar, "laser": laser}, {}
    for day, check in calendar():
        name = f"{day_name(day)}_{check}"
        kind, more = KINDS[check]
        out[f"checks/{name}.csv"] = "\n".join(write[check](theta[day], day)) + "\n"
        out[f"checks/{name}.toml"] = (
            f'vcmm = "recording/1"\ndata = "{name}.csv"\nmachine = "../machine.toml"\nkind = "{kind}"\ndate = "{day_name(day)}"\n{more}'
        )
    return out
