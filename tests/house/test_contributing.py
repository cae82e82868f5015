"""CONTRIBUTING's examples, carried out: an effect (the file as it stands there, its line, its number, every job that it promises), and cycles."""

from __future__ import annotations

import json
import os
import re
import shutil
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


# What a program of each language does with the new row: heights of the tip over the hole, and whether at rapid.
CYCLES_STORY = """
import json
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.program.touching import Round

def heights(text, dialect):
    return [[m.kind, round(m.end[2], 6)] for m in interpret(text, dialect, Setup(strict=False)).moves if m.start[2] != m.end[2] or m.kind == "dwell"]

klartext = "BEGIN PGM P MM\\nTOOL CALL 1 Z S10\\nL Z+50 FMAX\\nCYCL DEF 380 A Q200=2 Q201=-10 Q206=100 Q211=0.5 Q208=200 Q203=0 Q204=20\\nCYCL CALL\\nEND PGM P MM"
sinumerik = "G17 G90 G71 G94 F100 S10 M3\\nG0 Z50\\nCYCLE380(20, 0, 2, -10, , 0.5)\\nM30"
g_code = "G21 G90 G94\\nG0 Z50.\\nG98 G85.5 Z-10. R2. P500 F100.\\nG80\\nM30"
bore = Setup(tools={9: Tool(9, diameter=6.0, shape="probe")}, surfaces=(Round((1.0, 0.0, 0.0), 15.0, inside=True),))
macro = interpret("G21 G90 G94\\nT9 M6\\nG0 X0. Y0.\\nG65 P9880 D30.\\nG0 X#135\\nM30", "fanuc", bore)
print(json.dumps({
    "Klartext": heights(klartext, "heidenhain"), "Sinumerik": heights(sinumerik, "sinumerik"), "G code": heights(g_code, "fanuc"),
    "macro": macro.moves[-1].end[0],
}))
"""


@pytest.mark.thorough
def test_a_cycle_is_one_row(tmp_path):
    """Each row drills from 2 mm above to 10 mm deep with a dwell of 0.5 s and comes back to 20 mm (G98: to the initial 50 mm); the macro finds
    the middle of a bore 1 mm beside the zero in X."""
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy / "vcmm", ignore=shutil.ignore_patterns("__pycache__"))
    section = CONTRIBUTING.read_text(encoding="utf-8").partition("## Add a cycle")[2]
    lines = re.findall(r"```py\n(.*?)```", section, re.DOTALL)[0].splitlines()
    assert len(lines) == 8
    for where, row in zip(lines[::2], lines[1::2]):
        path, name = where.removeprefix("# ").split(": ")
        text = (copy / path).read_text(encoding="utf-8")
        head, found, tail = re.split(rf"^({name}: Mapping\[.*)$", text, maxsplit=1, flags=re.MULTILINE)
        (copy / path).write_text(f"{head}{found}\n    {row}{tail}", encoding="utf-8")
    groups = copy / "vcmm" / "program" / "iso" / "groups.py"
    text = groups.read_text(encoding="utf-8")
    assert '_DRILLING = "G73 ' in text
    groups.write_text(text.replace('_DRILLING = "G73 ', '_DRILLING = "G85.5 G73 '), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", CYCLES_STORY], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(copy)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout)
    hole = [["rapid", 2.0], ["line", -10.0], ["dwell", -10.0]]
    assert found["Klartext"][1:] == [*hole, ["line", 2.0], ["rapid", 20.0]]
    assert found["Sinumerik"][1:] == [*hole, ["rapid", 20.0]]
    assert found["G code"][1:] == [*hole, ["line", 2.0], ["rapid", 50.0]]
    assert abs(found["macro"] - 1.0) < 1e-9
