"""Completion of verbs, options and their values in three shells."""

from __future__ import annotations

import shutil
import subprocess
from functools import cache

import pytest

from vcmm.face.cli import VERBS, build_app

CHECK = {"bash": ["bash", "-n"], "zsh": ["zsh", "-n"], "fish": ["fish", "--no-execute"]}


@cache
def script(shell: str) -> str:
    return str(build_app().generate_completion(shell=shell))


@pytest.mark.parametrize("shell", CHECK)
def test_every_verb_is_offered(shell: str) -> None:
    assert [verb for verb in VERBS if verb not in script(shell)] == []


@pytest.mark.parametrize("shell", CHECK)
def test_the_shell_reads_its_script(shell: str) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    done = subprocess.run(CHECK[shell] + ["/dev/stdin"], input=script(shell), capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (["unc"], "uncertainty"),
        (["schema", "mach"], "machine"),
        (["uncertainty", "plate.toml", "--tri"], "--trials"),
        (["demo", "--twin", "xcz"], "xcz_lathe"),
    ],
)
def test_bash_completes(words: list[str], offered: str) -> None:
    if shutil.which("bash") is None:
        pytest.skip("bash is not installed")
    given = " ".join(["vcmm", *words])
    asks = f'\nCOMP_WORDS=({given}); COMP_CWORD={len(words)}; COMP_LINE="{given}"; COMP_POINT=${{#COMP_LINE}}; _vcmm; echo "${{COMPREPLY[*]}}"\n'
    done = subprocess.run(["bash"], input=script("bash") + asks, capture_output=True, text=True)
    assert done.stdout.split() == [offered], done.stderr


def test_it_is_written_where_the_shell_looks(tmp_path, monkeypatch) -> None:
    from vcmm.face.cli import run

    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("SHELL", "/bin/bash")
    run(["--install-completion", "--shell", "bash"])
    assert any("_vcmm" in p.read_text() for p in tmp_path.rglob("*") if p.is_file())
