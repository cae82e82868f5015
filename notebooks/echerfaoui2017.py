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
# # Laser, neural net, compensation: a bridge CMM of 2017
#
# Three machines with errors of the published size; the demo takes eight. First one machine: its errors, what the laser reads of
# them, what the net of the axis makes of the readings.

# %%
import numpy as np

import vcmm
from vcmm.show.charts.canvas import canvas

paper = vcmm.twin("echerfaoui2017")  # scenarios/echerfaoui2017/*.py
page, twin = paper.page, paper.twin
rng = np.random.default_rng(7)
cmm = twin.drawn_cmm(rng)
readings, square = twin.measured(cmm, "precision", rng)
nets = twin.by_nets(readings, "i, 2i+1, o", rng)

ax = canvas(None)
for k, name in enumerate(("EXX", "EYX", "EZX")):
    ax.plot(twin.NODES, 1e3 * cmm.curves["X"][:, k], label=f"{name} true")
    ax.plot(twin.TARGETS, 1e3 * readings["X"][:, k], "o", color=ax.get_lines()[-1].get_color(), markersize=3)
    ax.plot(
        twin.NODES, 1e3 * nets["X"][:, k], "--", color=ax.get_lines()[-1].get_color(), label=f"{name} net"
    )
ax.set(xlabel="X / mm", ylabel="µm", title="true, read (dots), learnt (dashed)")
_ = ax.legend(fontsize=8)

# %% [markdown]
# Synthesis and compensation over the volume, by nets and by splines.

# %%
true = twin.machine(cmm.curves, cmm.square)
for method, curves in (("nets", nets), ("splines", twin.by_splines(readings))):
    left = twin.compensated(true, twin.machine(curves, square), method)
    print(f"{method:8s} {left.before[3]:.1f} µm -> {left.after[3]:.1f} µm, {left.gain:.0%} less")

# %% [markdown]
# The paper's figures beside three machines.

# %%
result = twin.run(3)
for row in page.compared(result):
    print(f"{row.what:48s} {row.paper:32s} {min(row.values):6.1f} to {max(row.values):5.1f} {row.unit}")
