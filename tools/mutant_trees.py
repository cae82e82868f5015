"""Trees of their own, in which files may be broken, and how pytest runs in them."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from mutant_sites import Site

ROOT = Path(__file__).resolve().parents[1]
PYTEST = [
    "-p",
    "no:cacheprovider",
    "-q",
    "-x",
    "--no-header",
    "--tb=line",
    "-W",
    "ignore::pytest.PytestWarning",
]
_workers: dict[Path, subprocess.Popen[str]] = {}


@dataclass(frozen=True)
class Copy:
    """A tree of its own, in which files may be broken."""

    folder: Path
    caches: Path

    def run(self, arguments: list[str], seconds: int, **more: str) -> subprocess.CompletedProcess[str]:
        """pytest in this tree, ended after so many seconds of computing, however busy the machine is."""
        limited = ["/bin/sh", "-c", f'ulimit -t {seconds}; exec "$@"', "sh"]
        command = [*limited, sys.executable, "-m", "pytest", *PYTEST, *arguments]
        return subprocess.run(
            command, cwd=self.folder, env=self.settings(**more), capture_output=True, text=True
        )

    def start(self) -> None:
        """A worker for this tree; ready before a file is broken, since it must know the files as they are."""
        worker = _workers[self.folder] = subprocess.Popen(
            [sys.executable, str(self.folder / "tools" / "mutant_worker.py")],
            cwd=self.folder, env=self.settings(), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=(self.folder.parent / f"{self.folder.name}.log").open("w"), text=True,
        )  # fmt: skip
        if worker.stdout is None or worker.stdout.readline().strip() != "ready":
            raise SystemExit(
                "the worker could not load package and tests: run tools/mutant_worker.py by hand"
            )

    def fork(self, site: Site, tests: list[str], seconds: int) -> subprocess.CompletedProcess[str] | None:
        """The tests in a fork of the worker; None where the function cannot be exchanged in memory."""
        worker = _workers[self.folder]
        assert worker.stdin is not None
        assert worker.stdout is not None
        order = {
            "file": site.file,
            "owner": site.owner,
            "tests": tests,
            "arguments": PYTEST,
            "seconds": seconds,
        }
        worker.stdin.write(json.dumps(order) + "\n")
        worker.stdin.flush()
        answer = json.loads(worker.stdout.readline())
        if answer["code"] is None:
            return None
        return subprocess.CompletedProcess([], answer["code"], answer["output"])

    def settings(self, **more: str) -> dict[str, str]:
        path = f"{self.folder}{os.pathsep}{self.folder / 'tools'}"
        return dict(
            os.environ,
            PYTHONPATH=path,
            OPENBLAS_NUM_THREADS="1",
            NUMBA_CACHE_DIR=str(self.numba()),
            **more,
        )

    def numba(self) -> Path:
        """A cache per state of the compiled loops: numba does not see that a loop called by another has changed."""
        every = sorted(self.folder.glob("vcmm/**/*_kernels.py"))
        return self.caches / hashlib.sha256(b"".join(p.read_bytes() for p in every)).hexdigest()[:16]


def copied(out: Path, number: int) -> Copy:
    """The tree as it is now; what has not changed keeps its time, so that caches stay good."""
    folder = out / f"tree-{number}"
    ignored = shutil.ignore_patterns(
        ".git", "__pycache__", ".*_cache", ".venv", ".hypothesis", "_build", "dist"
    )
    for entry in folder.iterdir() if folder.exists() else ():
        shutil.rmtree(entry) if entry.is_dir() else entry.unlink()
    shutil.copytree(ROOT, folder, ignore=ignored, dirs_exist_ok=True)
    return Copy(folder.resolve(), (out / "numba").resolve())


def end_workers() -> None:
    for worker in _workers.values():
        worker.communicate()
