"""Results written on the part: deviation from nominal with U and decision, with a leader line to the feature of each."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm.show import charts as draw
from vcmm.show.charts import Callout
from vcmm.show.pages.view import feature_mesh
from vcmm.show.report.answers import FINE_UNITS, STATE, is_about_value, places_of, signed_value
from vcmm.show.report.meshes import creases
from vcmm.show.report.scene_items import mesh_arrays

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult
    from vcmm.core.run import Array
    from vcmm.part.part import Feature, Part

MOST_LABELS = 14  # more than seven on either side cannot be read
MOST_LINES = 3000  # of the outline: a mesh with more creases is drawn by its features


def callout_picture(
    part: Part, results: Sequence[CharacteristicResult], places: Mapping[str, Array]
) -> list[str]:
    """Return the part with its results; nothing where no result has a place. places: feature -> points (n, 3) of it, drawing frame."""
    by_name = {c.name: c for c in part.characteristics}
    labels = []
    for c in results:
        of = by_name.get(c.name)
        if of is None:
            continue
        names = [n for n in (of.between or of.of) if n in places]
        if names:
            labels.append(_callout(c, [np.nanmean(places[n], axis=0) for n in names[:2]]))
    if not labels:
        return []
    more = "" if len(labels) <= MOST_LABELS else f"; the first {MOST_LABELS} of {len(labels)}"
    title = f"Results on the part: deviation from nominal ± U\nDrawing frame, seen from the front right and above{more}"
    return [draw.on_page(draw.callouts, outlines(part), labels[:MOST_LABELS], title=title)]


def _callout(c: CharacteristicResult, spots: Sequence[Array]) -> Callout:
    word, scale = FINE_UNITS[c.unit]
    verdict = "" if c.decision is None else c.decision.text
    deviation, expanded = (c.value - c.nominal) * scale, c.stated[0] * scale
    return Callout(
        c.name, _text(c, deviation, expanded, word), np.array(spots), verdict=verdict, colour=STATE.get(verdict, "muted"),
        value=deviation, expanded=expanded, unit=word,
    )  # fmt: skip


def _text(c: CharacteristicResult, deviation: float, expanded: float, word: str) -> str:
    """Return -0.37 ± 0.99 µm; "0.0 µm, U = 1.3 µm" where the interval does not lie about the value, as in the first lines of the page."""
    sign = "" if c.nominal == 0 else "+"
    if not math.isfinite(expanded) or is_about_value(c):
        return signed_value(deviation, expanded, word, sign)
    places = places_of(expanded)
    return f"{deviation + 0.0:{sign}.{places}f} {word}, U = {expanded:.{places}f} {word}".replace("-", "−")


def outlines(part: Part) -> Array:
    """Return the creases of the part (n, 2, 3): of its mesh, else of the nominal surfaces of its features; points as crosses."""
    if part.mesh is not None:
        lines = creases(np.asarray(part.mesh.vertices), np.asarray(part.mesh.faces))
        if 0 < len(lines) <= MOST_LINES:
            return lines
    outlines_of = [_outline(f) for f in part.features.values()]
    return np.concatenate(outlines_of) if outlines_of else np.zeros((0, 2, 3))


def _outline(feature: Feature) -> Array:
    shape = feature_mesh(feature)
    if shape is None:
        at = np.asarray(feature.point, float)
        return np.array([[at, at]])
    return creases(*mesh_arrays(shape))
