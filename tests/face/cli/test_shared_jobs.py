"""Jobs shared out as a user does it, by processes of their own: killed, taken up again, on a cluster, in shards."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.hostile.judge import ask, inside
from vcmm.files.own.library import example as shipped

RUN = "from vcmm.face.cli import main; main()"


def machine(folder: Path, name: str, u: float) -> str:
    axes = "".join(f'[axes.{a}]\ntravel = ["{lo} mm", "{hi} mm"]\n' for a, lo, hi in (("X", 0, 800), ("Y", 0, 800), ("Z", -600, 0)))  # fmt: skip
    text = f'vcmm = "machine/1"\nname = "{name}"\nstructure = "w b Y X Z t"\n{axes}[repeatability]\nlaw = "normal"\nu = "{u} um"\n'
    (folder / f"{name}.toml").write_text(text)
    return f"{name}.toml"


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Iterator[Path]:
    """A ring gauge, which is quickly counted, and two machines."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "ring.toml").write_text(shipped("ring_gauge").read_text())
    (tmp_path / "shop").mkdir()
    for name, u in (("coarse", 1.0), ("fine", 0.2)):
        machine(tmp_path / "shop", name, u)
    with inside(tmp_path):
        yield tmp_path


@pytest.mark.thorough
def test_shards_of_an_audit_put_together_are_the_audit(folder):
    words = ("audit", "ring.toml", "--parts", "600", "--json")
    whole = ask(words)
    assert whole.code in (0, 1), whole.err
    for k in (1, 2, 3):
        assert ask(("audit", "ring.toml", "--parts", "600", "--shard", f"{k}/3")).code == 0
    files = [f"ring.shard-{k}-of-3.json" for k in (1, 2, 3)]
    assert ask(("merge", *files, "--json")).out == whole.out
    assert not list((folder / "cache").rglob("*.json"))


@pytest.mark.thorough
def test_audit_of_a_folder_has_a_row_of_every_task(folder):
    (folder / "bad.toml").write_text('vcmm = "scenario/1"\n[part]\nfeatures = 3\n')
    asked = ask(("audit", ".", "--parts", "100", "--json", "--out", "table"))
    found = json.loads(asked.out)
    tasks = {t["file"]: t for t in found["tasks"]}
    assert set(tasks) == {"bad.toml", "ring.toml"}
    assert "bad.toml" in tasks["bad.toml"]["problem"]
    alone = json.loads(ask(("audit", "ring.toml", "--parts", "100", "--json")).out)
    assert tasks["ring.toml"]["audit"] == alone["audit"]
    rows = (folder / "table" / "audit.csv").read_text().splitlines()
    assert len(rows) == 1 + len(alone["audit"])
    assert rows[1].startswith("ring.toml,")


@pytest.mark.thorough
def test_a_shop_is_shared_out(folder):
    fast = ("--evaluations", "60", "--scan", "40", "--trials", "2000")
    (folder / "shop" / "bad.toml").write_text('vcmm = "machine/1"\nname = "bad"\n')
    alone = ask(("place", "ring.toml", "--machines", "shop/bad.toml", *fast))
    assert (alone.code, "bad.toml:1" in alone.err) == (2, True)  # where none can be read that is the answer
    words = ("place", "ring.toml", "--machines", "shop", *fast)
    whole = ask((*words, "--json"))
    assert whole.code == 0, whole.err
    found = json.loads(whole.out)
    assert found["machine"] == "shop/fine.toml"
    assert [m["machine"] for m in found["machines"]] == [
        "shop/fine.toml",
        "shop/coarse.toml",
        "shop/bad.toml",
    ]
    assert "bad.toml:1" in found["machines"][2]["why"]
    for k in (1, 2):
        assert ask((*words, "--shard", f"{k}/2")).code == 0
    assert ask(("merge", "ring.shard-1-of-2.json", "ring.shard-2-of-2.json", "--json")).out == whole.out


def test_only_what_can_be_shared_takes_workers(folder):
    for words in (("place", "ring.toml", "--workers", "0"), ("place", "ring.toml", "--shard", "1/2")):
        answer = ask(words)
        assert answer.code == 2
        assert "only the machines of --machines are shared out" in answer.err


# -------------------------------------------------------------------- minutes: make test-all


@contextmanager
def started(*words: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def children(process: subprocess.Popen[str]) -> list[int]:
    found = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text()
    return [int(pid) for pid in found.split()]


def wait_until(true, seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.05)


EXACT = ("uncertainty", "ring.toml", "--engine", "exact", "--trials", "6000", "--json")


@pytest.mark.thorough
def test_a_client_that_is_killed_leaves_no_worker_and_the_next_call_goes_on(folder):
    whole = ask(EXACT).out
    with started("-c", RUN, *EXACT, "--workers", "2") as client:
        wait_until(lambda: len(list((folder / "cache").rglob("*-500.json"))) >= 3)
        workers = children(client)
        client.kill()
    kept = len(list((folder / "cache").rglob("*-500.json")))
    assert 3 <= kept < 12
    wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers), 10)
    with started("-c", RUN, *EXACT, "--workers", "2") as again:
        out, err = again.communicate()
    assert (again.returncode, out) == (0, whole), err
    assert not list((folder / "cache").rglob("*-500.json"))


@pytest.mark.thorough
def test_a_worker_that_is_killed_costs_only_time(folder):
    whole = ask(EXACT).out
    with started("-c", RUN, *EXACT, "--workers", "2") as client:
        wait_until(lambda: len(list((folder / "cache").rglob("*-500.json"))) >= 2)
        os.kill(children(client)[-1], signal.SIGKILL)
        out, err = client.communicate()
    assert (client.returncode, out) == (0, whole), err


@pytest.mark.thorough
def test_workers_audit_and_place_as_one_process_does(folder):
    for words in (("audit", "ring.toml", "--parts", "600"), ("audit", "ring.toml", "shop/../ring.toml", "--parts", "250"),
                  ("place", "ring.toml", "--machines", "shop", "--evaluations", "60", "--scan", "40", "--trials", "2000")):  # fmt: skip
        whole = ask((*words, "--json"))
        assert whole.code == 0, whole.err
        assert ask((*words, "--json", "--workers", "2")).out == whole.out


@contextmanager
def cluster(folder: Path, workers: int) -> Iterator[tuple[str, list[subprocess.Popen[str]]]]:
    """A scheduler and workers as a user starts them: `dask scheduler`, `dask worker ADDRESS`."""
    plan, quiet = folder / "scheduler.json", ("--no-dashboard",)
    with started(
        "-m", "dask", "scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(plan), *quiet
    ):
        wait_until(lambda: plan.exists() and plan.read_text().strip().endswith("}"))
        address = json.loads(plan.read_text())["address"]
        own = ("-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", *quiet)
        hands = [started(*own, "--local-directory", str(folder / f"w{k}")) for k in range(workers)]
        try:
            yield address, [h.__enter__() for h in hands]
        finally:
            for hand in hands:
                hand.__exit__(None, None, None)


@pytest.mark.thorough
def test_a_cluster_one_worker_of_which_is_killed(folder):
    pytest.importorskip("distributed")
    whole = ask(EXACT).out
    with cluster(folder, 2) as (address, workers):
        with started("-c", RUN, *EXACT, "--cluster", address) as client:
            wait_until(lambda: len(list((folder / "cache").rglob("*-500.json"))) >= 3)
            workers[0].kill()
            out, err = client.communicate()
        assert (client.returncode, out) == (0, whole), err
        audit = ("audit", "ring.toml", "shop/../ring.toml", "--parts", "250", "--json")
        assert ask((*audit, "--cluster", address)).out == ask(audit).out


@pytest.mark.thorough
def test_the_only_worker_that_held_the_job_is_killed_and_one_that_came_later_ends_it(folder):
    pytest.importorskip("distributed")
    job = ("uncertainty", "ring.toml", "--engine", "exact", "--trials", "2000", "--json")
    whole = ask(job).out
    with (
        cluster(folder, 1) as (address, first),
        started("-c", RUN, *job, "--cluster", address) as client,
    ):
        wait_until(lambda: len(list((folder / "cache").rglob("*-500.json"))) >= 1)
        first[0].kill()
        late = ("-m", "dask", "worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        with started(*late, "--local-directory", str(folder / "late")):
            out, err = client.communicate()
    assert (client.returncode, out) == (0, whole), err
