"""The same work by one process, by several, by Dask workers; workers that are killed cost nothing but time."""

from __future__ import annotations

import os
import signal
import socket
import time
from concurrent.futures import CancelledError
from pathlib import Path
from types import MappingProxyType

import pytest

from vcmm.core import crew as crews
from vcmm.core.crew import Portions, crew_of, in_process, processes
from vcmm.core.errors import Environment, UsageError


def tripled(payload, item):
    return payload["factor"] * item


def killed_once(marker: str, item: int) -> int:
    """The first worker that meets item 3 is killed in the middle of it."""
    if item == 3:
        try:
            Path(marker).touch(exist_ok=False)
        except FileExistsError:
            return item * 10
        os.kill(os.getpid(), signal.SIGKILL)
    return item * 10


def always_killed(payload, item):
    os.kill(os.getpid(), signal.SIGKILL)


def slow(payload, item):
    time.sleep(0.05)
    return item


def process_number(payload, item):
    time.sleep(0.2)
    return os.getpid()


def test_alone_and_together_give_the_same():
    payload = MappingProxyType({"factor": 3})  # as frozen objects hold them
    expected = {i: 3 * item for i, item in enumerate(range(10, 16))}
    assert dict(in_process(tripled, payload, range(10, 16))) == expected
    assert dict(processes(2)(tripled, payload, range(10, 16))) == expected


def test_a_killed_worker_costs_only_time(tmp_path):
    marker = tmp_path / "killed"
    assert dict(processes(2)(killed_once, str(marker), range(6))) == {i: 10 * i for i in range(6)}
    assert marker.exists()


def asleep(_, seconds):
    time.sleep(seconds)
    return os.getpid()


def test_workers_end_at_once_when_nothing_more_is_asked_of_them():
    # one result is taken, a sleep of 60 s is in hand: without an end of their own the workers would sleep it out, and
    # a second interrupt would find Python waiting for them
    results = processes(2)(asleep, None, [0.0, 60.0, 60.0, 60.0])
    _, worker = next(results)
    began = time.monotonic()
    results.close()
    assert time.monotonic() - began < 20.0
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_work_that_kills_every_worker_ends():
    with pytest.raises(Environment, match="fewer --workers"):
        list(processes(1)(always_killed, None, [1, 2]))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"workers": 0}, "use 1 to"),
        ({"workers": 10**9}, "1000000000 workers on [0-9]+ cores; use 1 to [0-9]+, usually one per core"),
        ({"workers": 2, "cluster": "tcp://x"}, "name one of the two"),
    ],
)
def test_crews_that_do_not_exist(options, words):
    with pytest.raises(UsageError, match=words):
        crew_of(**options)


def test_a_single_item_is_done_here():
    assert [*processes(2)(process_number, None, [0])] == [(0, os.getpid())]


def test_portions_are_a_second_of_work_and_smaller_towards_the_end():
    portions, sizes = Portions(dict.fromkeys(range(100)), workers=2), []
    while portion := portions.next():
        sizes.append(len(portion))
        assert [*portions.results(portion, (0.125 * len(portion), portion))] == [
            (i, (i, None)) for i, _ in portion
        ]
    # one to see how long it takes; then 1 s / 0.125 s = 8, or a quarter of what is left where that is less: 99 - 9 x 8 = 27 // 4 = 6 ...
    assert sizes == [1, *[8] * 9, 6, 5, 4, 3, 2, 1, 1, 1, 1, 1, 1, 1]
    assert len(Portions({0: None, 1: None}, workers=1).next()) == 1  # of unknown length: one


def test_what_a_portion_did_not_reach_is_sent_again():
    portions = Portions(dict.fromkeys("abcdefgh", 0), workers=1)
    first = portions.next()
    assert [*portions.results(first, (0.01, ["A"]))] == [("a", "A")]
    second = portions.next()  # by the first it would be a hundred, of seven the half
    assert [i for i, _ in second] == ["b", "c", "d"]
    assert [*portions.results(second, (9.0, ["B"]))] == [("b", "B")]  # 4.5 s each by now: one at a time
    assert [[i for i, _ in portions.next()] for _ in range(3)] == [["c"], ["d"], ["e"]]


def test_a_worker_ends_a_portion_that_takes_too_long(monkeypatch):
    """What was quick at first and slow later, a folder that begins with files that cannot be read, is not sent as one portion."""
    monkeypatch.setattr(crews, "SPAN", 0.02)  # s
    assert len(crews._work_portion(slow, None, [1, 2, 3, 4])[1]) == 1
    assert crews._work_portion(slow, None, [])[1] == []
    found = dict(crews.processes(2)(tripled, {"factor": 2}, range(40)))
    assert found == {i: 2 * i for i in range(40)}


def test_one_worker_is_this_process():
    assert crew_of(workers=1) is in_process
    assert [pid for _, pid in crew_of()(process_number, None, [0])] == [os.getpid()]


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed")
    import dask

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None, processes=True, silence_logs=50
        ) as local,
    ):
        yield local


def test_dask_workers_one_of_them_killed(cluster, tmp_path):
    marker = tmp_path / "killed"
    found = dict(crew_of(cluster=cluster.scheduler_address)(killed_once, str(marker), range(6)))
    assert found == {i: 10 * i for i in range(6)}
    assert marker.exists()


def test_other_versions_on_the_workers_are_named(cluster, monkeypatch):
    monkeypatch.setattr(crews, "__version__", "9.9.9")
    with pytest.raises(Environment, match=r"vcmm is 9\.9\.9 here and 0\.\S+ on the worker tcp"):
        list(crew_of(cluster=cluster.scheduler_address)(tripled, {"factor": 1}, [1]))


def test_a_scheduler_that_goes_in_the_middle_is_said(cluster, monkeypatch):
    distributed = pytest.importorskip("distributed")
    for gone in (CancelledError(), distributed.comm.CommClosedError()):
        monkeypatch.setattr(crews, "_by_client", lambda *_, error=gone: (_ for _ in ()).throw(error))
        with pytest.raises(Environment, match=r"scheduler at tcp.* has gone; .* it goes on where it was"):
            list(crew_of(cluster=cluster.scheduler_address)(tripled, {"factor": 1}, [1]))


@pytest.mark.parametrize(
    ("address", "words", "error"),
    [
        (
            "tcp://127.0.0.1:9",
            r"no Dask scheduler answers at tcp://127\.0\.0\.1:9 .*dask scheduler",
            Environment,
        ),
        ("tcp://no.such.host.invalid:8786", "no Dask scheduler answers at tcp://no.such.host", Environment),
        ("scheduler", '--cluster "scheduler"; write .* tcp://scheduler:8786', UsageError),
        ("http://scheduler:8786", "write the address that dask scheduler tells", UsageError),
        ("tcp://scheduler:99999", "write the address that dask scheduler tells", UsageError),
        ("", '--cluster ""; write', UsageError),
    ],
)
def test_no_scheduler_there_is_said_at_once_and_before_any_work(address, words, error):
    began = time.monotonic()
    with pytest.raises(error, match=words):
        crew_of(cluster=address)
    assert time.monotonic() - began < 2 * crews.CONNECT_TIMEOUT_S


def test_what_listens_there_is_no_scheduler(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(crews, "CLIENT_TIMEOUT_S", 0.5)
    monkeypatch.setattr(crews, "CONNECT_TIMEOUT_S", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        crew = crew_of(cluster=f"127.0.0.1:{silent.getsockname()[1]}")
        with pytest.raises(Environment, match="no Dask scheduler answers at"):
            list(crew(tripled, {"factor": 1}, [1]))


@pytest.mark.thorough
def test_work_that_kills_every_dask_worker_ends(cluster):
    with pytest.raises(Environment, match="ended in the middle of the same work"):
        list(crew_of(cluster=cluster.scheduler_address)(always_killed, None, [1, 2]))


@pytest.mark.parametrize(
    ("cores", "words"),
    [(3, "13 workers on 3 cores; use 1 to 12,"), (None, "13 workers on 1 cores; use 1 to 8,")],
)
def test_four_workers_for_every_core_and_eight_at_least(monkeypatch, cores, words):
    """4 * 3 = 12; where the system does not say how many cores there are, one is taken: max(8, 4 * 1) = 8."""
    monkeypatch.setattr(os, "cpu_count", lambda: cores)
    with pytest.raises(UsageError, match=words):
        crew_of(workers=13)
