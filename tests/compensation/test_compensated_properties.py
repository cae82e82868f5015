"""For any program: what is left is within tolerance and rounding, and every block means what it meant."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.compensation.mill import SETUP, body, rough, run

quick = settings(
    max_examples=25, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)
number = st.integers(-2000, 2000).map(lambda n: n / 10)
radius = st.integers(5, 600).map(lambda n: n / 10)


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Lines, arcs, increments, planes and holes in any order, absolute and incremental."""
    lines, absolute = ["%", "O1", "G21 G90 G54 G17", "G0 X0 Y0 Z50.", "G1 Z0 F500"], True
    for k in range(draw(st.integers(1, 7))):
        kind = draw(st.sampled_from(["line", "short", "arc", "circle", "mode", "hole", "rapid"]))
        if kind == "line":
            lines.append(
                f"N{k} G1 X{draw(number)} Y{draw(number)} (line {k})"
                if absolute
                else f"G1 X{draw(number) / 10:.3f}"
            )
        elif kind == "short":
            lines += [f"G1 X{draw(number) / 500:.3f}Y{draw(number) / 500:.3f}" for _ in range(4)]
        elif kind == "circle":
            lines.append(f"{draw(st.sampled_from(['G2', 'G3']))} I{draw(radius)} J{draw(number) / 10:.3f}")
        elif kind == "arc":
            r = draw(radius)
            mode = "G91 " if absolute else ""
            lines.append(
                f"{mode}G3 X{-r} Y{r} I{-r} J0." if draw(st.booleans()) else f"{mode}G2 X{r} Y{-r} R{r}"
            )
            absolute = False
        elif kind == "mode":
            absolute = not absolute
            lines.append("G90" if absolute else "G91")
        elif kind == "hole" and absolute:
            lines.append(f"G81 X{draw(number)} Y{draw(number)} Z-5. R3. F90")
            lines += ["G80", f"G0 X{draw(number)} Y{draw(number)}"]
        else:
            lines.append("G0 Z30." if absolute else "G0 Z-0.5")
        if not absolute and draw(st.booleans()):
            absolute = True
            lines.append("G90")
    return "\n".join([*lines, "M30", "%", ""])


@pytest.mark.thorough
@quick
@given(programs(), st.sampled_from([1e-3, 3e-3]), st.booleans())
def test_rewritten_programs(text: str, tolerance: float, carry: bool):
    # a rewritten program with other modal states, feeds, frames or comments raises: `compensate` compares all of them
    with tempfile.TemporaryDirectory() as folder:
        found = run(Path(folder), text, rough(), SETUP, tolerance=tolerance, carry=carry)
    assert found.after.largest <= tolerance + found.rounding.largest + 1e-6
    assert found.is_met
    step = found.rounding.step
    assert (
        found.rounding.largest <= 3**0.5 * step * (1.0 if carry else 0.75) + 0.3 * 3**0.5 * tolerance + 1e-6
    )
    same = [line for line in text.splitlines() if not any(c in line for c in "XYZIJKR")]
    assert [line.rstrip("\n") for line in body(found) if not any(c in line for c in "XYZIJKR")] == same
