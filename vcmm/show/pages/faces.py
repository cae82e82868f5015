"""The page of a face that was scanned on the machine: its map, its profile, figures, and errors that the scan does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.show import charts
from vcmm.show import report as r
from vcmm.show.charts import PlotSeries
from vcmm.show.pages.header import facts
from vcmm.show.tables import faces as tables
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.learn.calibration.face_map import FaceMap


def face_page(found: FaceMap) -> str:
    """Return one self-contained HTML file."""
    blocks = [r.heading("Figures"), html(tables.figures(found))]
    blocks += [r.note(text) for text in found.warnings]
    blocks += [r.heading("Map of the face"), charts.on_page(face_picture, found)]
    if found.r is not None:
        blocks += [r.heading("Profile over the radius"), charts.on_page(profile_picture, found)]
    made = facts("", found.machine or "no machine file", more=[("scan", found.scan.name)])
    return r.page(
        f"Face {found.scan.name}",
        blocks,
        footer=f"vcmm {__version__}. Heights along +Z above the programmed face.",
        facts=made,
    )


def face_picture(found: FaceMap, ax: charts.ChartSheet | None = None) -> Axes:
    """Return the map, µm."""
    return charts.heat_map(
        found.height * 1e3, found.x, found.y, x_label="x of the part / mm", y_label="y / mm", unit="µm",
        title="Height above the programmed face", symmetric=True, ax=ax,
    )  # fmt: skip


def profile_picture(found: FaceMap, ax: charts.ChartSheet | None = None) -> Axes:
    """Plot the profile with its 95 % band (2 u), and the odd part of the slide's error."""
    assert found.r is not None
    assert found.profile is not None
    p, u = found.profile * 1e3, 2e3 * found.u_profile
    series = [PlotSeries(found.r, p, "part", low=p - u, high=p + u)]
    if found.odd is not None and found.u_odd is not None:
        odd, wide = found.odd * 1e3, 2e3 * found.u_odd
        series.append(
            PlotSeries(
                found.r, odd, "odd part of the slide's error", low=odd - wide, high=odd + wide, dashed=True
            )
        )
    return charts.curve(
        series, x_label="radius / mm", y_label="height / µm", title="Profile; bands 2 u", ax=ax
    )
