"""Compute the blocks of a job in this process, in several processes, or on a Dask cluster.

A job is a function of (payload, item) that depends on nothing else; results come as they are finished, so the caller
must add them up in a way that does not depend on the order. A worker that is killed costs the blocks it had in hand.
"""

from __future__ import annotations

import copyreg
import os
import pickle
import re
import signal
import socket
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from threading import Thread
from time import perf_counter
from types import MappingProxyType
from typing import Any

from vcmm import __version__
from vcmm.core.errors import Environment, UsageError

Portion = list[tuple[int, Any]]  # number and item
FinishedPortion = tuple[float, list[Any]]  # s, results
Crew = Callable[[Callable[[Any, Any], Any], Any, Sequence[Any]], Iterator[tuple[int, Any]]]
MOST_WORKERS = 4  # for every core; each takes memory, and more than one gains nothing
CONNECT_TIMEOUT_S, MOST_PORT = 3.0, 65535  # s for somebody to listen at the address of a scheduler
CLIENT_TIMEOUT_S = 10.0  # s, with what listens there and does not answer
SPAN = 1.0  # s of work that is sent at a time: sending some blocks costs as much as sending one, milliseconds of every process
AHEAD = 2  # portions in hand per worker: it never waits, and results do not pile up
LOOK = 5.0  # s between two looks at how many workers a cluster has
DEATHS = 3  # of workers in a row without a finished block, before it is the work that kills them


def mapping(items: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    """Return a read-only view, by a name that pickle finds."""
    return MappingProxyType(items)


copyreg.pickle(MappingProxyType, lambda view: (mapping, (dict(view),)))


def crew_of(workers: int | None = None, cluster: str | None = None) -> Crew:
    """Return the crew for these options: this process, `workers` processes here, or the Dask scheduler at `cluster`.

    Raises UsageError, and Environment where nothing answers at that address, before any work begins.
    """
    if workers is not None and cluster is not None:
        raise UsageError("workers are processes here, a cluster has its own; name one of the two")
    cores = os.cpu_count() or 1
    most = max(8, MOST_WORKERS * cores)
    if workers is not None and not 1 <= workers <= most:
        raise UsageError(f"{workers} workers on {cores} cores; use 1 to {most}, usually one per core")
    if cluster is not None:
        _check_address(cluster)
        return on_cluster(cluster)
    return in_process if workers in (None, 1) else processes(int(workers or 1))


def in_process(
    work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]
) -> Iterator[tuple[int, Any]]:
    """Yield (number of the item, result) one after another, computed in this process."""
    for i, item in enumerate(items):
        yield i, work(payload, item)


_current_job: Any = None  # (work, payload) of this worker


def _initialise_worker(packed: bytes, lifeline: Any) -> None:
    """Take the payload; end with the process that started this one, even where that was killed, and with `lifeline`.

    A key that interrupts reaches every process of a terminal: here it does nothing, the process that started this one decides.
    """
    global _current_job
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, args=(lifeline,), daemon=True).start()
    _current_job = pickle.loads(packed)


def _end_with_parent(lifeline: Any) -> None:
    from multiprocessing import parent_process
    from multiprocessing.connection import wait

    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel, lifeline])  # nothing is ever sent: it is ready when the other end is closed
        os._exit(1)


def _work_on_worker(items: Sequence[Any]) -> FinishedPortion:
    work, payload = _current_job
    return _work_portion(work, payload, items)


def _work_portion(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> FinishedPortion:
    """Compute a portion on a worker: return its time in s, and the results of the items begun within 2 SPAN, at least of the first."""
    began, results = perf_counter(), list[Any]()
    for item in items:
        if results and perf_counter() - began > 2 * SPAN:
            break
        results.append(work(payload, item))
    return perf_counter() - began, results


class Portions:
    """Portions of items for the workers: about SPAN of work each, one item where that takes longer, less towards the end.

    workers: number of workers. Each of the last portions is half of one worker's share of the remaining items, so that all workers end together.
    """

    def __init__(self, items: dict[int, Any], workers: int) -> None:
        self.left, self.workers = [*items.items()][::-1], workers
        self.seconds, self.counted = 0.0, 0

    def next(self) -> Portion:
        """Return the next portion, empty at the end."""
        each = self.seconds / self.counted if self.counted else SPAN
        most = min(SPAN / max(each, 1e-9), len(self.left) / (2 * self.workers))
        return [self.left.pop() for _ in range(min(max(1, int(most)), len(self.left)))]

    def results(self, portion: Portion, done: FinishedPortion) -> Iterator[tuple[int, Any]]:
        """Yield (number, result) of the finished items; the rest of a portion that took too long waits again."""
        seconds, values = done
        self.seconds, self.counted = self.seconds + seconds, self.counted + len(values)
        self.left += portion[len(values) :][::-1]
        return zip([i for i, _ in portion], values)


def processes(workers: int) -> Crew:
    """Return a crew of processes on this computer; each takes the payload once. A single item is computed here, since starting a process
    takes longer."""

    def run(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        if len(items) == 1:
            yield 0, work(payload, items[0])
            return
        packed, left, deaths = pickle.dumps((work, payload)), dict(enumerate(items)), 0
        while left:
            before = len(left)
            for i, result in _until_a_death(min(workers, len(left)), packed, left):
                del left[i]
                yield i, result
            deaths = 0 if len(left) < before else deaths + 1
            if left and deaths == DEATHS:
                raise Environment(
                    f"{deaths * workers} workers ended without a result, most likely for want of memory; use fewer --workers"
                )

    return run


def _until_a_death(workers: int, packed: bytes, left: dict[int, Any]) -> Iterator[tuple[int, Any]]:
    """Yield results until all are there or a worker was killed, which ends the whole pool.

    Interrupted or not asked any further: workers end at once. Else a second interrupt would find Python waiting for workers
    that wait for work, without end.
    """
    from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import Pipe, get_context

    there, here = Pipe(duplex=False)
    pool = ProcessPoolExecutor(workers, get_context("spawn"), _initialise_worker, (packed, there))
    portions, running = Portions(left, workers), dict[Future[FinishedPortion], Portion]()
    try:
        with suppress(BrokenProcessPool):
            while True:
                while len(running) < AHEAD * workers and (portion := portions.next()):
                    running[pool.submit(_work_on_worker, [item for _, item in portion])] = portion
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield from portions.results(running.pop(future), future.result())
    except BaseException:
        here.close()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        here.close()
        there.close()


def _check_address(address: str) -> None:
    match = re.fullmatch(r"(?:(?:tcp|tls|ws|wss)://)?(\[[0-9a-fA-F:.]+\]|[^\s/:]+):([0-9]{1,5})", address)
    if not match or int(match[2]) > MOST_PORT:
        raise UsageError(
            f'--cluster "{address}"; write the address that dask scheduler tells, for example tcp://scheduler:8786'
        )
    try:
        socket.create_connection((match[1].strip("[]"), int(match[2])), timeout=CONNECT_TIMEOUT_S).close()
    except (OSError, UnicodeError) as error:
        raise Environment(_silent(address, error)) from None


def _silent(address: str, error: Exception | str) -> str:
    return f"no Dask scheduler answers at {address} ({error}); start one with: dask scheduler"


def on_cluster(address: str) -> Crew:
    """Return a crew of Dask workers. Raises Environment: no Dask, no scheduler there or no more, other versions on the workers."""

    def run(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        distributed = _import_distributed()
        client = _client(distributed, address)
        try:
            _check_versions(client, address)
            yield from _by_client(client, work, payload, dict(enumerate(items)))
        except (CancelledError, distributed.KilledWorker, distributed.comm.CommClosedError) as error:
            raise Environment(_lost_worker_text(address, error)) from None
        finally:
            client.close()  # lets go of all futures: what is not finished is cancelled

    return run


def _client(distributed: Any, address: str) -> Any:
    """Return a client that answers within CLIENT_TIMEOUT_S: Dask itself waits for ever for a program that listens there and is no scheduler."""
    outcomes: list[Any] = []

    def meet() -> None:
        try:
            outcomes.append(distributed.Client(address, timeout=CLIENT_TIMEOUT_S, set_as_default=False))
        except Exception as error:
            outcomes.append(error)

    meeting = Thread(target=meet, daemon=True)
    meeting.start()
    meeting.join(CLIENT_TIMEOUT_S + CONNECT_TIMEOUT_S)
    if not outcomes or isinstance(outcomes[0], Exception):
        raise Environment(_silent(address, outcomes[0] if outcomes else "what listens there is none"))
    return outcomes[0]


def _lost_worker_text(address: str, error: Exception) -> str:
    if type(error).__name__ == "KilledWorker":
        return f"several workers at {address} ended in the middle of the same work, most likely for want of memory; give them more"
    return (
        f"the Dask scheduler at {address} has gone; start it and call the job again: it goes on where it was"
    )


def _by_client(
    client: Any, work: Callable[[Any, Any], Any], payload: Any, items: dict[int, Any]
) -> Iterator[tuple[int, Any]]:
    from distributed import as_completed

    # the result of a task, which the scheduler makes again where the workers that held it are gone; scattered data would be lost
    shared = client.submit(_share_work, versions(), work, payload, retries=DEATHS, pure=False)
    portions, running = Portions(items, 1), dict[Any, Portion]()
    finished, looked = as_completed(loop=client.loop), -LOOK

    def hand_out() -> None:
        nonlocal looked
        if perf_counter() - looked > LOOK:
            portions.workers, looked = max(1, sum(client.nthreads().values())), perf_counter()
        while len(running) < AHEAD * portions.workers and (portion := portions.next()):
            some = [item for _, item in portion]
            future = client.submit(_on_worker, shared, some, retries=DEATHS, pure=False)
            running[future] = portion
            finished.add(future)

    hand_out()
    for future in finished:
        yield from portions.results(running.pop(future), future.result())
        hand_out()


def _share_work(due: dict[str, str], work: Callable[[Any, Any], Any], payload: Any) -> tuple[Any, ...]:
    """Return what all blocks of a job need, on a worker."""
    return due, work, payload


def _on_worker(shared: Any, items: Sequence[Any]) -> FinishedPortion:
    """Compute a portion on a Dask worker, and check the versions of a worker that came later than the others."""
    from distributed import get_worker

    due, work, payload = shared
    _same_versions(due, versions(), get_worker().address)
    return _work_portion(work, payload, items)


def _import_distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise Environment('--cluster needs Dask: pip install "vcmm[cluster]"') from None
    return distributed


def versions() -> dict[str, str]:
    """Return the versions that must agree on the client and on every worker for the same numbers to the last bit."""
    import platform
    from importlib.metadata import version

    others = {name: version(name) for name in ("numpy", "scipy", "numba")}
    return {"vcmm": __version__, "Python": platform.python_version(), **others}


def _check_versions(client: Any, address: str) -> None:
    mine = versions()
    try:
        theirs = client.run(versions)
    except Exception as error:
        raise Environment(
            f"the workers at {address} cannot load vcmm ({type(error).__name__}: {error}); install vcmm {__version__} there"
        ) from None
    if not theirs:
        raise Environment(f"the scheduler at {address} has no workers; start one with: dask worker {address}")
    for worker, other_versions in theirs.items():
        _same_versions(mine, other_versions, worker)


def _same_versions(mine: dict[str, str], theirs: dict[str, str], worker: str) -> None:
    for name, version in mine.items():
        if theirs.get(name) != version:
            raise Environment(
                f"{name} is {version} here and {theirs.get(name)} on the worker {worker}; install the same on both"
            )
