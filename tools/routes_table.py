"""Count the routes on drawn machines: how often the true value is within U of each, and how often E_n says that they agree.

    python tools/routes_table.py 60

Writes nothing; prints the table of docs/routes.md.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from dataclasses import replace

from vcmm.files.scenario import load_scenario
from vcmm.library import path
from vcmm.routes.job import routes

SCENARIOS = ("ring_gauge", "plate", "certificate")


def counted(name: str, machines: int) -> list[str]:
    """Rows of one scenario: characteristic, share held by every route, share of agreement of every pair."""
    scenario = load_scenario(path(name))
    held: dict[str, dict[str, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for seed in range(machines):
        found = routes(scenario, settings=replace(scenario.settings, trials=2000, seed=seed))
        for c in found.characteristics:
            for r in c.routes:
                held[c.name][r.route].append(abs(c.error(r) or 0.0) <= 1)
            for a in c.agreements:
                held[c.name][f"{a.first} - {a.second}"].append(a.agrees)
    return [
        f"| {name}: {c} | " + " | ".join(f"{sum(v)}" for v in shares.values()) + " |"
        for c, shares in held.items()
        if len(shares) > 1
    ]


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    print(
        "| task | model | calibrated part | positions | E_n model - part | model - positions | part - positions |"
    )
    print("|---|---|---|---|---|---|---|")
    for one in SCENARIOS:
        print("\n".join(counted(one, count)), flush=True)
