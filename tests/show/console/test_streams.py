"""stdout that is closed, full or knows few letters."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys

import pytest

from vcmm.show.console.documents import print_json
from vcmm.show.console.streams import in_plain_letters, writes_utf8

VCMM = [sys.executable, "-c", "from vcmm.face.cli import main; main()"]


@pytest.mark.parametrize(
    ("encoding", "written"),
    [
        ("ascii", b"0.5 um +/- 20 deg \\u65e5 -"),
        ("latin-1", b"0.5 \xb5m \xb1 20 \xb0 \\u65e5 -"),
        ("utf-8", "0.5 µm ± 20 ° 日 –".encode()),
    ],
)
def test_letters(monkeypatch, encoding, written):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    in_plain_letters()
    print("0.5 µm ± 20 ° 日 –", end="")
    sys.stdout.flush()
    assert raw.getvalue() == written.replace(b"20 deg", b"20 deg")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_documents_are_json_on_every_terminal(monkeypatch, encoding):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    in_plain_letters()
    assert writes_utf8() == (encoding == "utf-8")
    print_json({"name": "µ-Bohrung \udc80"})
    sys.stdout.flush()
    assert json.loads(raw.getvalue()) == {"name": "µ-Bohrung \udc80"}


def test_a_full_stdout_is_the_computers_fault():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [*VCMM, "list", "units"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert (done.returncode, done.stderr) == (
        3,
        "vcmm: the computer refuses: No space left on device; nothing was half-written\n",
    )


def test_a_closed_stdout_is_the_computers_fault():
    done = subprocess.run([*VCMM, "list", "units"], preexec_fn=lambda: os.close(1), stderr=subprocess.PIPE, text=True, check=False)  # fmt: skip
    assert done.returncode == 3
    assert "stdout is closed" in done.stderr


@pytest.mark.parametrize(("scenario", "code"), [("units", 0), ("nonsense", 2)])
def test_a_closed_stderr_loses_the_messages_only(scenario, code):
    done = subprocess.run([*VCMM, "list", scenario], preexec_fn=lambda: os.close(2), stdout=subprocess.PIPE, text=True, check=False)  # fmt: skip
    assert done.returncode == code
    assert bool(done.stdout) == (code == 0)
