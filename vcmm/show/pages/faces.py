"""The page of a face that was scanned on the machine: its map, its profile, figures, and errors that the scan does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.show import charts
from vcmm.show.charts import PlotSeries
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables import faces as tables
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.learn.calibration.face_map import FaceMap


def face_page(face: FaceMap) -> str:
    """Return one self-contained HTML file."""
    blocks = [r.heading("Figures"), html(tables.figures(face))]
    blocks += [r.note(text) for text in face.warnings]
    blocks += [r.heading("Map of the face"), charts.on_page(face_picture, face)]
    if face.r is not None:
        blocks += [r.heading("Profile over the radius"), charts.on_page(profile_picture, face)]
    made = facts("", face.machine or "no machine file", more=[("scan", face.scan.name)])
    return r.page(
        f"Face {face.scan.name}",
        blocks,
        footer=f"vcmm {__version__}. Heights along +Z above the programmed face.",
        facts=made,
    )


def face_picture(face: FaceMap, ax: charts.ChartSheet | None = None) -> Axes:
    """Return the map, µm."""
    return charts.heat_map(
        face.height * 1e3, face.x, face.y, x_label="x of the part / mm", y_label="y / mm", unit="µm",
        title="Height above the programmed face", symmetric=True, ax=ax,
    )  # fmt: skip


def profile_picture(face: FaceMap, ax: charts.ChartSheet | None = None) -> Axes:
    """Plot the profile with its 95 % band (2 u), and the odd part of the slide's error."""
    assert face.r is not None
    assert face.profile is not None
    p, u = face.profile * 1e3, 2e3 * face.u_profile
    series = [PlotSeries(face.r, p, "part", low=p - u, high=p + u)]
    if face.odd is not None and face.u_odd is not None:
        odd, wide = face.odd * 1e3, 2e3 * face.u_odd
        series.append(
            PlotSeries(
                face.r, odd, "odd part of the slide's error", low=odd - wide, high=odd + wide, dashed=True
            )
        )
    return charts.curve(
        series, x_label="radius / mm", y_label="height / µm", title="Profile; bands 2 u", ax=ax
    )
