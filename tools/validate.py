"""Print how far vcmm is from its outside truths: VCMM_DATA=<folder> python tools/validate.py

The figures of the README's table "How it is known to be right" are this output.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np

from vcmm.answer.evaluation.interval import Linear
from vcmm.core.laws import Uniform
from vcmm.files.columns import read_positions
from vcmm.files.own.machine import load_machine

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))


def kinematics(root: Path) -> None:
    """Largest deviations over all reference machines."""
    document = json.loads((root / "reference" / "kinematics.json").read_text())
    exact = linear = 0.0
    for case in document["cases"]:
        machine = load_machine(root / "reference" / case["machine"])
        run = read_positions(root / "reference" / case["positions"], machine.chain.letters)
        exact = max(exact, np.abs(machine.tip_error(run, exact=True) - case["tip_error_mm"]).max())
        if case["first_order_applies"]:
            linear = max(linear, np.abs(machine.tip_error(run) - case["tip_error_mm"]).max())
    print(f"tip errors of {len(document['cases'])} machines, exact        {exact:.1e} mm  (bar 1e-9)")
    print(f"the same, first order                       {linear:.1e} mm  (bar 5e-6)")


def fits(root: Path) -> None:
    """Largest deviations over the NIST circles and the certified least-squares sets."""
    from test_fit_reference import deviations

    for name, count, length, angle in deviations(root / "data" / "fitting"):
        print(f"{name:12s} {count:2d} sets   {length:.1e} mm  {angle:.1e} rad  (bar 1e-9, 1e-10)")


def intervals() -> None:
    """JCGM 101, 9.2.3 and 9.2.4: four rectangular quantities, exact in closed form."""
    unit = Uniform(np.sqrt(3.0))
    for name, gains, exact in (("9.2.3", [1, 1, 1, 1], 3.879407), ("9.2.4", [1, 1, 1, 10], 17.015814)):
        high = Linear(0.0, [(unit, np.array(gains, dtype=float))]).interval(0.95)[1]
        print(f"JCGM 101, {name}: 95 % interval +-{high:.6f}, exact +-{exact:.6f}")


def main() -> None:
    root = Path(os.environ.get("VCMM_DATA", "."))
    if not (root / "reference" / "kinematics.json").exists():
        sys.exit("set VCMM_DATA to the folder with reference/ and data/")
    kinematics(root)
    fits(root)
    intervals()


if __name__ == "__main__":
    main()
