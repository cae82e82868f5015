"""Runs of real machines that others published, one after another: each later run predicted before it is used.

    python -m referee.real_runs DATA FOLDER            DATA: folder with recordings_2 and recordings_3

The first run of a machine is diagnosed (`vcmm diagnose`), its file followed through the later ones (`vcmm track`; a month apart by assumption, for they have no
dates). Of every later run the root mean square over its readings, zero or rigid position free, about

    yesterday's file    the file of the first run, unchanged
    prediction          the file of the day, from all runs before it
    own least squares   a fit to the first run that shares nothing with the package: a straight line with a step per direction; both temperatures; a linear map of a plate

One long recording of a heating machine (heatB) is cut into sixths by time; as many are the first run as `diagnose` needs to write a file.
--only takes the groups with a word in their title.
"""

import argparse
import csv
import itertools
import json
import re
import shutil
import tomllib
from pathlib import Path

import numpy as np

from referee.files import call

GROUPS = (
    ("slit axis", ("recordings_3/strB", "recordings_3/strC", "recordings_3/strD"), "line"),
    ("one axis, ISO 230-2", ("recordings_2/mcuA", "recordings_2/mcuB"), "line"),
    ("plug plates", ("recordings_2/plateA", "recordings_2/plateB"), "plate"),
    ("heating, two halves", ("recordings_2/heatC1", "recordings_2/heatC2"), "heat"),
    ("heating, sixths", ("recordings_3/heatB",), "heat"),
)


PARTS = 6  # of one long recording


def rows_of(path):
    with path.open() as stream:
        return list(csv.DictReader(stream))


def runs_of(data, names):
    """(name, text of the recording file, rows) of every run; one alone is cut into PARTS."""
    out = []
    for name in names:
        folder = data / name
        out.append((folder.name, (folder / "recording.toml").read_text(), rows_of(folder / "data.csv")))
    if len(out) > 1:
        return out
    name, text, rows = out[0]
    cuts = [len(rows) * k // PARTS for k in range(PARTS + 1)]
    return [(f"{name} {k + 1}/{PARTS}", text, rows[a:b]) for k, (a, b) in enumerate(itertools.pairwise(cuts))]


def write_run(folder, number, text, rows, machine):
    """One run as a recording file of its own, with a date."""
    name = f"run{number}"
    with (folder / f"{name}.csv").open("w", newline="") as stream:
        out = csv.DictWriter(stream, rows[0].keys(), lineterminator="\n")
        out.writeheader()
        out.writerows(rows)
    text = re.sub(r'data = ".*"', f'data = "{name}.csv"', text)
    text = re.sub(r'machine = ".*"', f'machine = "{machine}"\ndate = "2026-{number + 1:02d}-01"', text)
    (folder / f"{name}.toml").write_text(text)
    return folder / f"{name}.toml"


def features(rows, kind):
    """(columns, value, nuisance) of a run, um."""
    number = {k: np.array([float(r[k]) for r in rows]) for k in rows[0] if k not in ("run", "direction")}
    if kind == "line":
        q = number["target_mm"]
        way = np.array([1.0 if r["direction"] == "up" else -1.0 for r in rows])
        return np.stack([q, way], axis=1), (number["actual_mm"] - q) * 1e3, np.ones((len(q), 1))
    if kind == "heat":
        t = np.stack([number["temp_column_C"], number["temp_table_C"]], axis=1)
        return t, number["d_um"], np.ones((len(t), 1))
    x, y, none = number["X_mm"], number["Y_mm"], np.zeros(len(rows))
    linear = np.block([[np.stack([x, none], 1)], [np.stack([none, y], 1)]])
    rigid = np.block([[np.stack([none + 1, none, -y], 1)], [np.stack([none, none + 1, x], 1)]])
    return linear, np.concatenate([number["dx_um"], number["dy_um"]]), rigid


def without(nuisance, columns):
    basis = np.linalg.qr(nuisance)[0]
    return columns - basis @ (basis.T @ columns)


def own_fit(rows, kind):
    columns, value, nuisance = features(rows, kind)
    return np.linalg.lstsq(without(nuisance, columns), without(nuisance, value), rcond=None)[0]


def own_rms(rows, kind, fit):
    """um, of what a run differs by from an earlier fit; None: from nothing."""
    columns, value, nuisance = features(rows, kind)
    left = without(nuisance, value if fit is None else value - columns @ fit)
    return float(np.sqrt((left**2).mean()))


def about(folder, machine, checks):
    """(rms in um of the last recording about a machine file, document) of `vcmm track`."""
    document = call(
        folder, "track", str(machine), str(checks), "--out", f"{checks}-out", "--replay", "--no-explain"
    )
    with (folder / f"{checks}-out" / "track.toml").open("rb") as stream:
        state = tomllib.load(stream)
    return state["recordings"][-1]["seen"]["rms_before"] * 1e3, document


def judge(data, folder, title, names, kind):
    runs = runs_of(data, names)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    shutil.copy(data / names[0] / "machine.toml", folder / "machine.toml")
    while True:
        first = write_run(folder, 0, runs[0][1], runs[0][2], "machine.toml")
        call(folder, "diagnose", first.name, "--out", "first")
        if (folder / "first" / "machine.toml").exists():
            break
        if len(names) > 1 or len(runs) < 3:
            raise RuntimeError(
                f"diagnose writes no machine file of {runs[0][0]}, so that nothing can be followed"
            )
        print(
            f"{title}: diagnose writes no machine file of {runs[0][0]}; taken together with {runs[1][0]}",
            flush=True,
        )
        runs = [(f"{runs[0][0]}, {runs[1][0]}", runs[0][1], runs[0][2] + runs[1][2]), *runs[2:]]
    known, now, out = "first/machine.toml", "first/machine.toml", []
    fit = own_fit(runs[0][2], kind)
    for k in range(1, len(runs)):
        alone, until = folder / f"alone{k}", folder / f"until{k}"
        for place in (alone, until):
            place.mkdir()
        write_run(alone, k, *runs[k][1:], "../machine.toml")
        for j in range(1, k + 1):
            write_run(until, j, *runs[j][1:], "../machine.toml")
        file, _ = about(folder, known, alone.name)
        predicted, _ = about(folder, now, alone.name)
        _, document = about(folder, known, until.name)
        now = f"{until.name}-out/machine.toml"
        check = document["checks"][-1]
        row = {
            "machine": title, "run": runs[k][0], "nothing": own_rms(runs[k][2], kind, None), "file": file, "predicted": predicted,
            "own": own_rms(runs[k][2], kind, fit), "innovation": check["innovation_over_u"], "alarm": check["alarm"],
        }  # fmt: skip
        print(json.dumps(row), flush=True)
        out.append(row)
    return out


def table(rows):
    lines = [
        "| machine | later run | no model, um | yesterday's file, um | prediction, um | own least squares, um | innovation over its u | alarm |"
    ]
    lines.append("|---|---|---|---|---|---|---|---|")
    for r in rows:
        numbers = " | ".join(f"{r[k]:.3g}" for k in ("nothing", "file", "predicted", "own", "innovation"))
        lines.append(f"| {r['machine']} | {r['run']} | {numbers} | {'yes' if r['alarm'] else 'no'} |")
    return lines


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("data", type=Path)
    words.add_argument("folder", type=Path)
    words.add_argument("--only", default="")
    given = words.parse_args()
    rows = []
    for number, (title, names, kind) in enumerate(GROUPS):
        if given.only not in title:
            continue
        try:
            rows += judge(given.data, given.folder / f"group{number}", title, names, kind)
        except RuntimeError as error:
            print(f"{title}: {error}", flush=True)
    print("\n".join(table(rows)))
