"""Writes machine, scenario and points files, runs the command line and reads its document."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from referee.machines import TRAVEL
from referee.tasks import Task

Array = NDArray[np.float64]
SHIFT, TURN = (300.0, 250.0, -250.0), (0.0, 0.0, 30.0)
SCATTER = 0.0003  # mm, of one touch on the machine whose law is stated
STATED = {"translation": 2e-4, "rotation": 3e-7, "square": 5e-7, "length": 150.0}
CERTIFICATE = {"fixed": 1.9e-3, "slope": 1 / 300e3, "r0": 1.5e-3, "form": 1.8e-3, "size": 0.9e-3}


def _text(item: object) -> str:
    """TOML of a value: lengths carry their unit elsewhere."""
    if isinstance(item, str):
        return json.dumps(item)
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, (tuple, list)):
        return "[" + ", ".join(_text(i) for i in item) + "]"
    return repr(item)


def _feature(feature: dict) -> str:
    """One line of [part.features]."""
    x, y, z = feature["point"]
    keys = {"type": feature["type"], "point": f"{x} {y} {z} mm"}
    if "radius" in feature:
        keys |= {"axis": [0, 0, 1], "diameter": f"{2 * feature['radius']} mm", "inside": feature["inside"]}
        if "length" in feature:
            keys["length"] = f"{feature['length']} mm"
    elif feature["type"] == "line":
        u, half = np.array(feature["u"]), feature["half"][0]
        start = np.array(feature["point"]) - half * u
        keys["point"] = "{} {} {} mm".format(*start)
        keys |= {
            "direction": list(feature["u"]),
            "length": f"{2 * half} mm",
            "normal": list(feature["normal"]),
        }
    else:
        keys |= {"normal": list(feature["normal"]), "u": list(feature["u"])}
        keys["size"] = "{} {} mm".format(*(2 * h for h in feature["half"]))
    return "{ " + ", ".join(f"{k} = {_text(v)}" for k, v in keys.items()) + " }"


def machine_file(
    folder: Path, certificate: dict | None, dof: float = np.inf, table: Array | None = None
) -> None:
    """Write machine.toml: a law of 21 errors that is stated about a table, or a certificate alone (mm).

    Parameters
    ----------
    table : array, shape (k, 19), optional
        Row per node of all three axes: share of the travel from 0 to 1, then 18 errors (mm, rad), X first.
    """
    lines = ['vcmm = "machine/1"', 'name = "judged machine"', 'kind = "cmm"', 'structure = "w b Y X Z t"']
    for axis, (low, high) in TRAVEL.items():
        lines += [f"[axes.{axis}]", f'travel = ["{low} mm", "{high} mm"]']
    if certificate is not None:
        c = {k: 1e3 * v for k, v in certificate.items()}
        lines += ["[certificate]", f'E0_MPE = "{c["fixed"]:.6g} um + L/{1 / c["slope"]:.6g}"']
        lines += [f'R0_MPL = "{c["r0"]:.6g} um"', f'P_Form_Sph_1x25 = "{c["form"]:.6g} um"']
        lines += [f'P_Size_Sph_1x25 = "{c["size"]:.6g} um"']
    else:
        s = STATED
        lines += ["[errors]", 'table = "errors.csv"', 'state = "residual"']
        law = f'translation = "{1e3 * s["translation"]:.6g} um", rotation = "{1e6 * s["rotation"]:.6g} urad"'
        law += f', squareness = "{1e6 * s["square"]:.6g} urad", correlation_length = "{s["length"]} mm"'
        lines += ["uncertainty = { " + law + " }", "[repeatability]"]
        scale = f'"{1e3 * SCATTER:.6g} um"'
        lines += (
            ['law = "normal"', f"u = {scale}"]
            if np.isinf(dof)
            else ['law = "t"', f"scale = {scale}", f"dof = {dof}"]
        )
        rows = np.zeros((2, 19)) if table is None else table
        if table is None:
            rows[1, 0] = 1.0
        blocks = []
        for number, (axis, (low, high)) in enumerate(TRAVEL.items()):
            head = " ".join([axis, *(f"E{d}{axis}" for d in "XYZABC")])
            body = rows[:, 1 + 6 * number : 7 + 6 * number]
            blocks.append(
                "\n".join(
                    [
                        head,
                        *(
                            " ".join(f"{v:.12g}" for v in [low + r[0] * (high - low), *b])
                            for r, b in zip(rows, body)
                        ),
                    ]
                )
            )
        blocks.append("A0Z B0Z C0Y\n0 0 0")
        (folder / "errors.csv").write_text("\n#\n".join(blocks) + "\n")
    (folder / "machine.toml").write_text("\n".join(lines) + "\n")


def scenario_file(
    folder: Path, task: Task, nominal: dict, extra: str = "", forms: dict | None = None
) -> None:
    """Write scenario.toml and the planned points of every feature.

    Parameters
    ----------
    nominal : dict
        By feature nominal points and outward normals.
    extra : str
        Further tables.
    forms : dict, optional
        By feature the text of a stated form.
    """
    lines = ['vcmm = "scenario/1"', f'name = "{task.name}"', 'machine = "machine.toml"', "[part.features]"]
    for name, feature in task.features.items():
        text = _feature(feature)
        if forms and name in forms:
            text = text[:-2] + f", form = {forms[name]} }}"
        lines.append(f"{name} = {text}")
    for characteristic in task.characteristics:
        lines += ["[[part.characteristics]]", f"name = {_text(characteristic.name)}"]
        for key, item in characteristic.keys.items():
            if key == "zone":
                item = f"{item} mm"
            elif key == "limits":
                item = [f"{v} mm" for v in item]
            lines.append(f"{key} = {_text(item)}")
    lines += ["[pose]", 'shift = "{} {} {} mm"'.format(*SHIFT), 'turn = "{} {} {} deg"'.format(*TURN)]
    lines += ["[plan]", 'touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }']
    lines += ['styli.down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" }']
    for name, (points, normals) in nominal.items():
        lines += ["[[plan.steps]]", f'feature = "{name}"', 'stylus = "down"', f'points = "{name}.csv"']
        rows = [",".join(f"{v:.9g}" for v in [*p, *n]) for p, n in zip(points, normals)]
        (folder / f"{name}.csv").write_text("\n".join(["x_mm,y_mm,z_mm,nx,ny,nz", *rows]) + "\n")
    lines += ["[job]", 'known_bias = "corrected"', extra]
    (folder / "scenario.toml").write_text("\n".join(lines) + "\n")


def points_file(path: Path, parts: list[dict], digits: float = 0.0) -> None:
    """Write what was touched: one dictionary of points by feature per part."""
    places = 7 if not digits else max(0, round(-np.log10(digits)))
    rows = ["part,feature,x_mm,y_mm,z_mm"]
    for number, part in enumerate(parts):
        for name, points in part.items():
            rows += [f"p{number},{name}," + ",".join(f"{v:.{places}f}" for v in p) for p in points]
    path.write_text("\n".join(rows) + "\n")


def call(folder: Path, *words: str) -> dict:
    """Run `vcmm` in a folder and read the JSON document it prints.

    Raises
    ------
    RuntimeError
        The command failed; the text is what it said.
    """
    beside = Path(sys.executable).parent / "vcmm"
    command = [str(beside) if beside.exists() else "vcmm", *words, "--json"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=7200)
    if done.returncode not in (0, 1) or not done.stdout.strip():
        raise RuntimeError(f"exit {done.returncode}: " + (done.stderr or done.stdout)[-600:])
    return json.loads(done.stdout)
