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
# # Measuring on the lathe that cut the part
#
# One drawn lathe: its three reversals first, then an optical flat scanned in a spiral, with and without the error map.

# %%
import numpy as np

import vcmm
from vcmm.show.charts.canvas import canvas

paper = vcmm.twin("xcz_lathe")  # scenarios/xcz_lathe/*.py
flat, joint, lathe, surveys, twin = paper.flat, paper.joint, paper.lathe, paper.surveys, paper.twin
rng = np.random.default_rng(4)
drawn, shape, tried = twin.consistent(rng)
found = surveys.survey(drawn, rng)
nm = 1e6

ax = canvas(None)
ax.plot(found.straight.nodes, nm * found.straight.machine, label="E_ZX")
ax.plot(found.straight.nodes, nm * found.straight.artefact, "--", label="mirror")
ax.set(xlabel="X / mm", ylabel="nm", title="straightness reversal")
_ = ax.legend(fontsize=8)
print(f"E_ZX {np.ptp(found.straight.machine) * nm:.1f} nm, u {found.straight.u.mean() * nm:.2f} nm")
print(
    f"E_ZC {np.ptp(found.spindle.curve('EZC', lathe.CIRCLE)) * nm:.1f} nm, not identified of E_BC: {found.spindle.blind('EBC')}"
)

# %% [markdown]
# The half turn by eq. 11 as printed, and with the straightness taken off the scans first: 0.08 arcsec were put in.

# %%
for what, one in (("as printed", found.square), ("E_ZX off first", found.corrected)):
    print(f"{what:15s} {one.angle / lathe.ARCSEC:+.3f} arcsec, u {one.u / lathe.ARCSEC:.3f}")

# %% [markdown]
# Three scans of the flat, the map taken off, and all scans in one fit.

# %%
true = flat.levelled(flat.terms(*flat.cells()) @ shape)
scans = [flat.scanned(drawn, shape, rng) for _ in range(flat.REPEATS)]
for kind, off in twin.maps(found).items():
    heights = [flat.on_cells(scan.reading - off) for scan in scans]
    flatness = np.mean([flat.flatness(h).pv for h in heights]) * nm
    wrong = np.mean([flat.levelled(h - true).std() for h in heights]) * nm
    print(f"{kind:38s} flatness {flatness:5.1f} nm, off the true flat {wrong:.2f} nm rms")
turned = [flat.scanned(drawn, shape, rng, index) for index in twin.INDEXED]
fit = joint.joint_fit(found, turned, twin.INDEXED, yaw=True)
surface = fit.at(*flat.cells())
print(
    f"{'one fit, flat turned, yaw measured':38s} flatness {flat.flatness(surface).pv * nm:5.1f} nm, off {flat.levelled(surface - true).std() * nm:.2f} nm rms"
)

# %%
x, y = flat.cells()
ax = canvas(None, height=4.8)
dots = ax.scatter(x, y, c=flat.levelled(surface) * nm, s=9, cmap="RdBu_r")
ax.set(xlabel="x / mm", ylabel="y / mm", title="the flat / nm", aspect="equal")
_ = ax.figure.colorbar(dots)
