"""The tool that breaks one place at a time: what it breaks, what it leaves alone, which tests it asks first."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from mutant_map import Coverage  # noqa: E402
from mutant_sites import Site, shown, sites  # noqa: E402
from mutant_worker import code_of, functions_in_memory  # noqa: E402
from mutants import ROOMS, Nearest, equivalents, interval, sample  # noqa: E402

SOURCE = '''"""Half of 3 + 4 is no formula here."""

LIMIT = 0.5  # a constant of the module


def area(a: float, b: float = 2.0) -> float:
    """a + b is only said."""
    if a < LIMIT and b:
        raise ValueError(f"{a - 1} is too small; " + "add 3")
    total = (a * 2.5 + max(a, b)) - 1
    return -total / values[1 + 2]
'''


@pytest.fixture
def found(tmp_path):
    """Changes of SOURCE as (kind, formula, the line afterwards)."""
    file = tmp_path / "vcmm" / "room" / "part.py"
    file.parent.mkdir(parents=True)
    file.write_text(SOURCE, encoding="utf-8")
    every = [shown(tmp_path, site) for site in sites(tmp_path, "vcmm/room/part.py")]
    return {(s.kind, s.formula, s.after_line) for s in every if s is not None}


def test_formulas_by_hand(found):
    formulas = {(kind, line) for kind, formula, line in found if formula}
    assert formulas == {
        ("operator", "total = (a / 2.5 + max(a, b)) - 1"),
        ("operator", "total = (a * 2.5 - max(a, b)) - 1"),
        ("operator", "total = (a * 2.5 + max(a, b)) + 1"),
        ("operator", "return -total * values[1 + 2]"),
        ("term", "total = (a * 2.5) - 1"),
        ("term", "total = (a * 2.5 + max(a, b))"),
        ("number", "total = (a * 5.0 + max(a, b)) - 1"),
        ("number", "total = (a * 2.5 + max(a, b)) - 2"),
        ("extreme", "total = (a * 2.5 + min(a, b)) - 1"),
        ("sign", "return total / values[1 + 2]"),
    }


def test_the_rest_by_hand(found):
    """Thresholds, tests, defaults and indices count apart; words of messages, annotations and docstrings not at all."""
    others = {(kind, line) for kind, formula, line in found if not formula}
    assert others == {
        ("number", "LIMIT = 1.0 # a constant of the module"),
        ("number", "def area(a: float, b: float = 4.0) -> float:"),
        ("comparison", "if a >= LIMIT and b:"),
        ("logic", "if a < LIMIT or b:"),
        ("operator", "return -total / values[1 - 2]"),
        ("term", "return -total / values[1]"),
    }


def test_layout_is_left_alone(tmp_path):
    file = tmp_path / "vcmm" / "show" / "report" / "bars.py"
    file.parent.mkdir(parents=True)
    file.write_text("def bar(x):\n    return 12 * x + 4\n", encoding="utf-8")
    kinds = {(s.kind, s.formula) for s in sites(tmp_path, "vcmm/show/report/bars.py")}
    assert kinds == {("operator", False), ("term", False)}


def test_the_nearest_and_quickest_tests_come_first(tmp_path):
    """Callers of the function before those that only import its file; own name, own room, others, the house last."""
    calls = ["vcmm/room/part.py:area"]
    record = {
        "tests/house/test_all.py::test_docs": {"seconds": 0.1, "passed": True, "calls": calls},
        "tests/face/cli/test_x.py::test_a": {"seconds": 0.2, "passed": True, "calls": calls},
        "tests/room/test_y.py::test_b": {"seconds": 9.0, "passed": True, "calls": calls},
        "tests/room/test_part.py::test_slow": {"seconds": 5.0, "passed": True, "calls": calls},
        "tests/room/test_part.py::test_quick": {"seconds": 0.3, "passed": True, "calls": calls},
        "tests/room/test_part.py::test_fails": {"seconds": 0.3, "passed": False, "calls": calls},
        "tests/room/test_part.py::test_other": {
            "seconds": 0.3,
            "passed": True,
            "calls": ["vcmm/room/part.py:volume"],
        },
    }
    (tmp_path / "map-1.json").write_text(json.dumps(record), encoding="utf-8")
    assert Coverage.read(tmp_path, tmp_path).noticing("vcmm/room/part.py", "area") == [
        "tests/room/test_part.py::test_quick", "tests/room/test_part.py::test_slow", "tests/room/test_y.py::test_b",
        "tests/face/cli/test_x.py::test_a", "tests/house/test_all.py::test_docs", "tests/room/test_part.py::test_other",
    ]  # fmt: skip


def test_without_a_map_the_sources_say_which_tests_are_nearest(tmp_path):
    """area <- whole <- test_whole: two steps; test_area names it itself: one. Own file and folder are preferred, slow tests never asked."""
    texts = {
        "vcmm/room/__init__.py": "from vcmm.room.part import area",
        "vcmm/room/part.py": "def area(a): ...\ndef other(a): ...",
        "vcmm/room/sum.py": "from vcmm.room import area\nclass Sum:\n    def whole(self):\n        return area(1)",
        "tests/room/test_part.py": "from vcmm.room.part import area, other\n"
        "def test_other(): other(1)\ndef test_area(): area(1)\n@pytest.mark.thorough\ndef test_long(): area(2)",
        "tests/face/conftest.py": "from vcmm.room import sum\ndef total(): return sum.Sum().whole()",
        "tests/face/test_x.py": "from vcmm.room import area\ndef test_near(): area(1)",
        "tests/face/test_y.py": "def test_whole(total): ...\ndef test_nothing(): ...",
        "tests/house/test_style.py": "from vcmm.room import area\ndef test_style(): area(1)",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert Nearest(tmp_path).noticing("vcmm/room/part.py", "area") == [
        "tests/room/test_part.py::test_area", "tests/face/test_x.py::test_near", "tests/face/test_y.py::test_whole",
        "tests/room/test_part.py::test_other",
    ]  # fmt: skip


def test_a_sample_has_so_many_of_either_class():
    """Three and two take turns: at 1/6, 3/6, 5/6 and at 1/4, 3/4 of the way."""
    chosen = sample(1, 3, 2, "core")
    assert [site.formula for site in chosen] == [True, False, True, False, True]
    assert all(site.file.startswith("vcmm/core/") for site in chosen)


def test_the_interval_of_a_share_by_hand():
    """All of n seen: low = 0.025^(1/n), 0.025^(1/10) = 10^(-1.602 / 10) = 0.6915; none seen: high = 1 - that."""
    assert interval(10, 10) == (pytest.approx(0.6915, abs=5e-5), 1.0)
    assert interval(0, 10) == (0.0, pytest.approx(0.3085, abs=5e-5))


def test_a_function_in_memory_gets_the_code_of_the_broken_file(tmp_path):
    """area(2) is 2 * 2.5 + 2 - 1 = 6, so -6 / 4 = -1.5; with the last sign dropped 1.5. What is imported elsewhere changes with it."""
    file = tmp_path / "part.py"
    file.write_text(SOURCE.replace("values[1 + 2]", "4"), encoding="utf-8")
    names: dict = {}
    exec(compile(file.read_bytes(), str(file), "exec"), names)
    area = names["area"]
    assert area(2.0) == -1.5
    file.write_text(file.read_text(encoding="utf-8").replace("-total", "total"), encoding="utf-8")
    (function,) = functions_in_memory(tmp_path)[str(file), "area"]
    function.__code__ = code_of(file, "area")
    assert area(2.0) == 1.5
    assert code_of(file, "volume") is None


def _line_after(source: bytes, site: Site) -> str:
    """The changed line as it stands afterwards, blanks as one."""
    first, last = source.rfind(b"\n", 0, site.start) + 1, source.find(b"\n", site.end)
    return " ".join(
        (source[first : site.start] + site.after.encode() + source[site.end : last]).decode().split()
    )


def test_every_change_that_means_nothing_can_still_be_drawn():
    """A file that has moved, or a line that is written anew, would leave an entry that excuses nothing."""
    stale = []
    for one in equivalents():
        source = (ROOT / one["file"]).read_bytes()
        if not any(one["after"] in _line_after(source, site) for site in sites(ROOT, one["file"])):
            stale.append(f"{one['file']}: {one['after']}")
    assert not stale, "tools/mutants_equivalent.toml: take these out or write them as the line is now"


def test_the_modules_that_the_count_names_are_there():
    """`program/roughing` of the paragraph in CONTRIBUTING.md is vcmm/program/roughing.py."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    count = text.split("## Tests")[1].split("`make test-all`")[0]
    named = set(re.findall(rf"`((?:{'|'.join(ROOMS)})/[a-z0-9_/]+)`", count))
    assert named
    assert not [name for name in sorted(named) if not (ROOT / "vcmm" / f"{name}.py").is_file()]
