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
# # Marin 2004: the chain multiplied out, a warm day, and the program rewritten
#
# The paper prints formulas and no numbers: machine, day, sensors, part and program are drawn. Equations 23 to 25 have lost
# signs and were derived again from the matrix product.

# %%

import vcmm

paper = vcmm.twin("marin2004")  # scenarios/marin2004/*.py
twin = paper.twin
scenario = vcmm.load_cut(vcmm.example("marin2004"))
result = twin.run(scenario)
print(f"tip errors up to {result.largest_um:.1f} um")
for a in result.agreements:
    print(f"{a.what:36s} against {a.against:24s} {a.nanometres:8.2g} nm")
assert max(a.nanometres for a in result.agreements) < 5

# %% [markdown]
# Thermal parameters: multiple regression on six sensors, learned on two drawn days, judged on a third.

# %%
for f in result.fits:
    unit = paper.day.UNITS[f.parameter]
    print(
        f"{paper.day.PARAMETERS[f.parameter]:10s} {f.span:5.1f} {unit} over the day, {f.rms:.2f} {unit} rms left"
    )

# %% [markdown]
# The NC file cut cold, and while the machine warms: as programmed, rewritten for the geometry, for the state at the start of the cut, and
# updated while it runs; last the control's tables.

# %%
for cut in result.cuts:
    line = "  ".join(f"{name} {values.mean():+6.2f}" for name, values in cut.departure.items())
    print(f"{cut.state:10s} {cut.model:22s} mean departure / um: {line}")
warm = {c.model: c for c in result.cuts if c.state == f"minute {result.warm}"}
assert abs(warm[twin.UPDATED].departure["top"].mean()) < 0.2 * abs(warm[twin.PLAIN].departure["top"].mean())
