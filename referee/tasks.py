"""What is measured: features, touches, characteristics, and their values by the definition of the standard.

The same definition gives the truth (dense surface) and the reference value of a measurement (touched points).
Sources: ISO 1101:2017 (form, orientation of the extracted surface, position), ISO 5459:2011 (datum systems),
ISO 14405-1:2016 (GG), ISO 14405-2 (distances).
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from referee import fits

Array = NDArray[np.float64]


@dataclass
class Characteristic:
    """One line of the drawing: `keys` are those of the scenario file, without its name."""

    name: str
    keys: dict
    nominal: float = 0.0


@dataclass
class Task:
    """Features, the places where they are touched, and characteristics."""

    name: str
    features: dict
    places: dict
    characteristics: list = field(default_factory=list)


def _ring(count: int, sweep: float = 2 * np.pi, levels: tuple = (0.0,)) -> tuple[Array, Array]:
    """Angles and heights, level by level."""
    end = sweep >= 2 * np.pi
    angle = np.linspace(0, sweep, count, endpoint=not end)
    return np.tile(angle, len(levels)), np.repeat(levels, count)


def _grid(nu: int, nv: int) -> tuple[Array, Array]:
    """Even grid inside a margin of a tenth."""
    u, v = np.meshgrid(np.linspace(-0.9, 0.9, nu), np.linspace(-0.9, 0.9, nv) if nv > 1 else [0.0])
    return u.ravel(), v.ravel()


CIRCLE = {"type": "circle", "point": (0, 0, 0), "radius": 15.0, "inside": True}
BORE = {"type": "cylinder", "point": (0, 0, 0), "radius": 15.0, "length": 20.0, "inside": True}
TOP = {"type": "plane", "point": (0, 0, 20), "normal": (0, 0, 1), "u": (1, 0, 0), "half": (40.0, 30.0)}
LEDGE = {"type": "plane", "point": (0, 0, 0), "normal": (0, 0, 1), "u": (1, 0, 0), "half": (30.0, 10.0)}
FRONT = {"type": "plane", "point": (0, -40, 10), "normal": (0, -1, 0), "u": (1, 0, 0), "half": (40.0, 8.0)}
SIDE = {"type": "plane", "point": (-50, 0, 10), "normal": (-1, 0, 0), "u": (0, 1, 0), "half": (30.0, 8.0)}
LINE = {"type": "line", "point": (0, 0, 0), "normal": (0, 0, 1), "u": (1, 0, 0), "half": (40.0, 0.0)}
HOLE = {"type": "cylinder", "point": (-25, 0, 0), "radius": 6.0, "length": 20.0, "inside": True}
MATE = {"type": "cylinder", "point": (25, 0, 0), "radius": 6.0, "length": 20.0, "inside": True}
LEVELS = (-0.8, -0.3, 0.3, 0.8)

SIZE = {"type": "size", "criterion": "GG", "limits": (-0.008, 0.008)}
APART = {"type": "distance", "limits": (-0.005, 0.005)}


def _form(kind: str, feature: str, letter: str = "G") -> Characteristic:
    name = kind if letter == "G" else kind + " minimum zone"
    return Characteristic(name, {"type": kind, "of": feature, "criterion": letter, "zone": 0.003})


def _size(feature: str, nominal: float) -> Characteristic:
    return Characteristic("size", {**SIZE, "of": feature}, nominal)


TASKS = {
    t.name: t
    for t in (
        Task(
            "circle8", {"ring": CIRCLE}, {"ring": _ring(8)}, [_size("ring", 30.0), _form("roundness", "ring")]
        ),
        Task("three", {"ring": CIRCLE}, {"ring": _ring(3)}, [_size("ring", 30.0)]),
        Task(
            "circle36",
            {"ring": CIRCLE},
            {"ring": _ring(36)},
            [_size("ring", 30.0), _form("roundness", "ring")],
        ),
        Task("zone36", {"ring": CIRCLE}, {"ring": _ring(36)}, [_form("roundness", "ring", "C")]),
        Task("arc30", {"ring": CIRCLE}, {"ring": _ring(30, 2 * np.pi / 3)}, [_size("ring", 30.0)]),
        Task("plane25", {"top": TOP}, {"top": _grid(5, 5)}, [_form("flatness", "top")]),
        Task("plane100", {"top": TOP}, {"top": _grid(10, 10)}, [_form("flatness", "top")]),
        Task("planezone", {"top": TOP}, {"top": _grid(10, 10)}, [_form("flatness", "top", "C")]),
        Task("line15", {"edge": LINE}, {"edge": _grid(15, 1)}, [_form("straightness", "edge")]),
        Task(
            "bore48",
            {"bore": BORE},
            {"bore": _ring(12, levels=LEVELS)},
            [_size("bore", 30.0), _form("cylindricity", "bore")],
        ),
        Task(
            "square",
            {"top": TOP, "bore": BORE},
            {"top": _grid(6, 5), "bore": _ring(12, levels=LEVELS)},
            [
                Characteristic(
                    "axis square",
                    {"type": "perpendicularity", "of": "bore", "datums": ("top",), "zone": 0.008},
                )
            ],
        ),
        Task(
            "wall",
            {"top": TOP, "front": FRONT},
            {"top": _grid(6, 5), "front": _grid(8, 3)},
            [
                Characteristic(
                    "wall square",
                    {"type": "perpendicularity", "of": "front", "datums": ("top",), "zone": 0.01},
                )
            ],
        ),
        Task(
            "ledge",
            {"top": TOP, "ledge": LEDGE},
            {"top": _grid(6, 5), "ledge": _grid(8, 3)},
            [
                Characteristic(
                    "parallel", {"type": "parallelism", "of": "ledge", "datums": ("top",), "zone": 0.012}
                ),
                Characteristic("step", {**APART, "between": ("top", "ledge")}, 20.0),
            ],
        ),
        Task(
            "holes",
            {"hole": HOLE, "mate": MATE},
            {"hole": _ring(8, levels=LEVELS), "mate": _ring(8, levels=LEVELS)},
            [Characteristic("apart", {**APART, "between": ("hole", "mate")}, 50.0)],
        ),
        Task(
            "place",
            {"top": TOP, "front": FRONT, "side": SIDE, "bore": BORE},
            {"top": _grid(5, 4), "front": _grid(6, 2), "side": _grid(5, 2), "bore": _ring(12, levels=LEVELS)},
            [
                Characteristic(
                    "position",
                    {"type": "position", "of": "bore", "datums": ("top", "front", "side"), "zone": 0.015},
                )
            ],
        ),
    )
}


def value(characteristic: Characteristic, features: dict, points: dict) -> float:
    """Value of a characteristic by the definition of the standard, mm.

    Parameters
    ----------
    features : dict
        Nominal features by name.
    points : dict
        Points by feature: dense ones for the truth, touched ones for what a measurement indicates.
    """
    keys = characteristic.keys
    kind, zone = keys["type"], keys.get("criterion") == "C"
    if kind == "distance":
        return _distance(*[(features[n], points[n]) for n in keys["between"]])
    feature, own = features[keys["of"]], points[keys["of"]]
    if kind == "size":
        return 2 * (fits.circle(own[:, :2])[1] if feature["type"] == "circle" else fits.cylinder(own)[2])
    if kind == "roundness":
        return fits.roundness(own[:, :2], zone)
    if kind == "cylindricity":
        return fits.cylindricity(own, zone)
    if kind == "flatness":
        return fits.flatness(own, np.array(feature["normal"], float), zone)
    if kind == "straightness":
        along, height = own @ np.array(feature["u"], float), own @ np.array(feature["normal"], float)
        return fits.straightness(along, height, zone)
    datums = [(features[n], points[n]) for n in keys["datums"]]
    primary = fits.plane(datums[0][1], np.array(datums[0][0]["normal"], float))[1]
    if kind == "parallelism":
        return float(np.ptp(own @ primary))
    if kind == "perpendicularity":
        return _square(feature, own, primary)
    if kind == "position":
        return _position(feature, own, datums, primary)
    raise ValueError(f"no definition of {kind}")


def _distance(first: tuple, second: tuple) -> float:
    """From the plane or axis of the first feature to the middle of the second."""
    if first[0]["type"] == "plane":
        centre, normal = fits.plane(first[1], np.array(first[0]["normal"], float))
        return float(abs((fits.plane(second[1], normal)[0] - centre) @ normal))
    (a, da, _), (b, db, _) = fits.cylinder(first[1]), fits.cylinder(second[1])
    middle = second[0]["point"][2] + second[0]["length"] / 2
    away = b + middle * db - a
    unit = da / np.linalg.norm(da)
    return float(np.linalg.norm(away - away @ unit * unit))


def _square(feature: dict, points: Array, primary: Array) -> float:
    """Squareness of the associated axis over its nominal length, or of the extracted surface, to a datum plane."""
    if feature["type"] == "cylinder":
        direction = fits.cylinder(points)[1]
        unit = direction / np.linalg.norm(direction)
        return float(feature["length"] * np.linalg.norm(unit - unit @ primary * primary))
    centre, normal = fits.constrained_plane(points, np.array(feature["normal"], float), [primary])
    along = np.cross(primary, normal)
    away = points - centre
    design = np.column_stack([np.ones(len(points)), away @ along])
    coefficients, half = fits.chebyshev(design, away @ normal)
    return 2 * half / float(np.hypot(1, coefficients[1]))


def _position(feature: dict, points: Array, datums: list, primary: Array) -> float:
    """Twice the largest departure of the axis, over its nominal length, from its place in three datum planes."""
    point, direction, _ = fits.cylinder(points)
    (front, front_points), (side, side_points) = datums[1], datums[2]
    c2, n2 = fits.constrained_plane(front_points, np.array(front["normal"], float), [primary])
    c3, n3 = fits.constrained_plane(side_points, np.array(side["normal"], float), [primary, n2])
    nominal = np.array(feature["point"], float)
    largest = 0.0
    for height in (nominal[2], nominal[2] + feature["length"]):
        end = point + height * direction
        off = []
        for centre, normal, datum in ((c2, n2, front), (c3, n3, side)):
            wanted = (nominal - np.array(datum["point"], float)) @ np.array(datum["normal"], float)
            off.append((end - centre) @ normal - wanted)
        largest = max(largest, float(np.hypot(*off)))
    return 2 * largest
