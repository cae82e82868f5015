"""A comparison of machines with recordings as tables: figures, folds, and where they still differ."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm.show.tables.table import ResultTable, listing

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.comparison import Comparison

CAPTION = (
    "rows as they are: nuisance refitted by weighted least squares, nothing clipped; chi-square counts the stated noise "
    "alone, not the uncertainty of the calibration"
)


def short_names(paths: Sequence[str]) -> list[str]:
    """Return each path by as few of its last parts as tell it from the others; of "a, b", the files of several recordings, each."""
    every = [name.replace("\\", "/") for path in paths for name in path.split(", ")]
    return [", ".join(_short(name.replace("\\", "/"), every) for name in path.split(", ")) for path in paths]


def _short(path: str, others: Sequence[str]) -> str:
    parts = path.split("/")
    endings = ("/".join(parts[-k:]) for k in range(1, len(parts) + 1))
    alone = (e for e in endings if sum(("/" + other).endswith("/" + e) for other in others) == 1)
    return next(alone, path)


def tables(rows: Sequence[Comparison]) -> list[ResultTable[Sequence[str]]]:
    """Return the figures, the folds, and the covariates of the residuals."""
    unit, scale = ("µrad", 1e6) if rows[0].angle else ("µm", 1e3)
    files = short_names([c.file for c in rows])
    figures = [
        (file, *(f"{scale * v:.4g}" for v in (c.rms, c.weighted_rms, c.noise)), f"{c.chi2:.5g}", str(c.dof))
        for file, c in zip(files, rows)
    ]
    names = [name for name, _ in rows[0].folds]
    folds = [(n, *(f"{scale * dict(c.folds)[n]:.4g}" for c in rows)) for n in names]
    places = [
        (file, p.recording.name, place.covariate, place.direction, f"{place.p:.2g}")
        for file, c in zip(files, rows)
        for p in c.parts
        for place in p.depends_on
    ]
    heads = ("machine file", f"rms / {unit}", f"weighted / {unit}", f"noise / {unit}", "chi-square", "dof")
    out = [listing("simulation against recording", heads, figures, words=(0,), caption=CAPTION)]
    if folds:
        out.append(listing(f"rms fold by fold / {unit}", ("rows", *files), folds, words=(0,)))
    if places:
        columns = ("machine file", "recording", "depends on", "direction", "p")
        out.append(listing("where they still differ", columns, places, words=(0, 1, 2, 3)))
    return out
