# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown]
# # Gaska et al. 2014: residual errors of a Leitz PMM 12106
#
# Published and typed in: 52 nodes, the standard deviations of 8 of them, 14 approaches from five stations, the law, the interpolation, the results.
# Drawn, because unpublished: the other 44 nodes, the stations, the part, its five places, the plan, the probe. See docs/gaska2014.md.

# %%
import numpy as np

import vcmm

paper = vcmm.twin("gaska2014")  # scenarios/gaska2014/*.py
maps, nodes, readings, tracer, twin = paper.maps, paper.nodes, paper.readings, paper.tracer, paper.twin
scenario = vcmm.load_scenario(vcmm.example("gaska2014"))
print(scenario.name, "-", len(scenario.places), "places,", scenario.task().touches.run.n, "touches")

# %% [markdown]
# The eight published rows (Table 2): d(X) goes with d(Y), and belongs to the column. Draws for the other nodes have both, and the published maxima and means.

# %%
print(
    "r of d(X), d(Y):",
    round(nodes.correlation_of(nodes.TABLE2), 2),
    " F of the columns:",
    nodes.column_ratio(nodes.TABLE2).round(1),
)
drawn = nodes.draw_deviations(nodes.SHOWN)
print("largest", drawn.max(axis=0), "mean", drawn.mean(axis=0).round(2), "um")
assert np.allclose(drawn[16], nodes.PUBLISHED[17])

# %% [markdown]
# The title procedure: lengths from five stations to 52 nodes, 14 approaches each; points, stations and dead paths solved together. d is smaller than the
# scatter of one approach where that does not come back at every station.

# %%
for share in (0.0, 0.5, 1.0):
    found = tracer.found_by(tracer.Approached(drawn * 1e-3, hysteresis=share), seed=1)
    ratio = np.sqrt((found.d**2).mean() / (drawn**2 * 1e-6).mean())
    one = np.sqrt((found.single**2).mean() / (drawn**2 * 1e-6).mean())
    print(
        f"hysteresis {share:4.0%}: residuals {found.u * 1e3:.2f} um, d {ratio:.2f} and one approach {one:.2f} of the truth,"
        f" the instrument's share {found.instrument.min() * 1e3:.2f} to {found.instrument.max() * 1e3:.2f} um"
    )
    assert abs(one - 1) < 0.05

# %% [markdown]
# Sixteen readings of the model, over 12 machines here (the demo takes 200), beside Table 3: 0.66 um for the form, 0.44 um for the distance in the mean.

# %%
for one in readings.matrix(scenario, twin.machines(12), trials=400):
    form, distance = (np.median(u.mean(axis=1)) * 1e3 for u in (one.form, one.distance))
    print(
        f"{one.reading.words:32s} form {form:.2f} um  distance {distance:.2f} um  ratio {one.ratio()[0]:.2f}"
    )
    assert (one.ratio()[0] > 1) == (one.reading.redraw == "touch")

# %% [markdown]
# Fig. 7: the scatter of X over the plane at z = 125 mm, linear between the columns and of the nearest column.

# %%
for plane in ("linear", "nearest"):
    values = maps.field_map(drawn, 0, plane, 125.0, "control")
    print(plane, "from", values.min().round(2), "to", values.max().round(2), "um")
