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
# # 3. Your machine from your certificate
#
# No error map, no calibration of your own: a machine file may state nothing but what its acceptance test promised (ISO 10360-2 and -5).
# The scenario is that of `vcmm new certificate`; write your own figures in its `[machine.certificate]`.

# %%
import vcmm

file = vcmm.example("certificate")
scenario = vcmm.load_scenario(file)
result = vcmm.uncertainty(scenario)
for c in result.characteristics:
    print(f"{c.name:20s} U {c.expanded * 1e3:.2f} um  {c.decision.text if c.decision else ''}")

# %% [markdown]
# Machines are drawn that pass this test, and the plate is measured on all of them. What would a better machine be worth? Half the length
# error, with everything else as before:

# %%
stated = {"E0_MPE": "0.9 um + L/700", "R0_MPL": "1.5 um", "P_Form_Sph_1x25": "1.8 um", "prior": "limit"}
better = vcmm.uncertainty(vcmm.load_scenario(file, certificate=stated))
for before, after in zip(result.characteristics, better.characteristics):
    print(f"{before.name:20s} U {before.expanded * 1e3:.2f} -> {after.expanded * 1e3:.2f} um")

# %% [markdown]
# And a prior that is less cautious: most machines do not use all of their limit.

# %%
usual = vcmm.uncertainty(
    vcmm.load_scenario(file, certificate={**stated, "E0_MPE": "1.8 um + L/350", "prior": "typical"})
)
for cautious, typical in zip(result.characteristics, usual.characteristics):
    print(
        f"{cautious.name:20s} U {cautious.expanded * 1e3:.2f} (limit) {typical.expanded * 1e3:.2f} um (typical)"
    )
    assert typical.expanded < cautious.expanded
result.characteristics[1].budget.plot(title="main contributors to the distance")
