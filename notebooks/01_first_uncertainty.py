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
# # 1. A first uncertainty
#
# A ring gauge of 50 mm on a measuring machine: the file of `vcmm new ring_gauge`, the job of `vcmm uncertainty ring_gauge.toml`.
# Error = indicated - true.

# %%
import vcmm

scenario = vcmm.load_scenario(vcmm.example("ring_gauge"))
scenario.plot()

# %% [markdown]
# Measured once, virtually: the machine that the file describes, with one draw of everything that is not known exactly. Other seeds are
# other machines on other days.

# %%
readings = [vcmm.measure(scenario, seed=seed).values[0].value for seed in range(20)]
print(f"lowest {min(readings):.5f} mm, highest {max(readings):.5f} mm, nominal 50 mm")

# %% [markdown]
# The uncertainty says how far such readings are spread: U is half the interval that holds the true value with a probability of 95 %.

# %%
result = vcmm.uncertainty(scenario)
(diameter,) = result.characteristics
print(
    f"{diameter.value:.5f} mm, U = {diameter.expanded * 1e3:.2f} um, k = {diameter.k:.2f}; {diameter.decision.text}"
)
result.plot()

# %% [markdown]
# By hand: of n touches evenly around a circle the radius is the mean, so u(d) = 2 u / sqrt(n). With u = 0.3 um and n = 16 that is 0.15 um.

# %%
scatter = next(line for line in diameter.budget if line.input.startswith("scatter"))
print(f"scatter of the touches: {scatter.u * 1e3:.3f} um")
assert abs(scatter.u * 1e3 - 2 * 0.3 / 16**0.5) < 2e-3
assert sum(abs(r - 50.0) < diameter.expanded for r in readings) >= 16  # about 19 of 20
