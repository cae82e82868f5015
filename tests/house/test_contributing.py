"""CONTRIBUTING's example, carried out: the file as it stands there, its line, its number, and every job that it promises."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from tests.house.test_layers import PACKAGE

CONTRIBUTING = PACKAGE.parent / "CONTRIBUTING.md"
EFFECTS_TESTS = PACKAGE.parent / "tests" / "physics"
STEM, CLASS = "ram_droop", "RamDroop"

# In a process of its own, in which vcmm.physics has the file and the line. Y carries the workpiece of the small machine.
STORY = """
import json
from pathlib import Path

import numpy as np

from tests.house.other_effects import with_file
from tests.house.small_jobs import KNOWN, command, write
from tests.house.test_contributing import CLASS, EFFECTS_TESTS, STEM, blocks

source, number = blocks()
with_file(STEM, source, CLASS).install()
exec(number, {name: getattr(__import__(f"vcmm.physics.catalogue.{STEM}", fromlist=[name]), name) for name in (CLASS, "Run")})

folder = Path.cwd()
known = KNOWN.format(STEM, "axis", "Y", "c", "40 um/m^2", "4 um/m^2")
write(folder, known, lambda at: np.stack([0 * at[:, 0], 0 * at[:, 0], -40e-9 * at[:, 1] ** 2], axis=1))

said = json.loads(command("explain", STEM, "--json"))
assert (said["sign"], said["parameters"][0]["unit"]) == ("tip error: actual - nominal", "um/m^2"), said
assert STEM in {e["effect"] for e in json.loads(command("list", "effects", "--json"))["items"]}
assert f'"{STEM}"' in command("schema", "machine")

budget = json.loads(command("uncertainty", folder / "ring.toml", "--json"))["characteristics"][0]
assert any(line["input"] == f"{STEM}[Y].c" for line in budget["budget"]), budget

found = json.loads(command("diagnose", folder / "touches.toml", "--json"))
(answer,) = found["answer"]
assert (answer["effect"], answer["where"]) == (STEM, {"axis": "Y"}), answer
low, high = answer["parameters"]["c"]["interval95"]
assert low < 40.0 < high, answer
assert answer["text"].startswith("The ram hangs lower the further Y reaches out ("), answer

# The zero was set where Y = 250 mm and the tool feeds as far as 340 mm: it hangs by 40e-9 (340^2 - 250^2) mm = 2.124 um
new = json.loads(command("compensate", folder / "boss.toml", "--out", folder / "new.nc", "--decimals", 5, "--json"))
before, after = (new["deviation"][when]["max_um"] for when in ("before", "after"))
assert abs(before - 2.124) < 1e-6, before
assert new["met"], new
assert after < 1.0, after  # the tolerance

cut = json.loads(command("cut", folder / "boss.toml", "--json"))
assert cut["characteristics"][0]["name"] == "diameter", cut
import pytest  # the tests of all effects take the new one in

assert pytest.main(["-q", "-k", STEM, "-p", "no:cacheprovider", str(EFFECTS_TESTS)]) == 0
"""


def blocks() -> list[str]:
    """The Python blocks of CONTRIBUTING.md: the file, and the number by hand."""
    return re.findall(r"```python\n(.*?)```", CONTRIBUTING.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.thorough
def test_the_example_does_all_that_is_promised(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(PACKAGE.parent)!r})\n{STORY}"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    assert " passed" in done.stdout
