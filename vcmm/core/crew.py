"""Work shared out: the same blocks of a job in this process, in several processes, or on a Dask cluster.

A job is a function of (payload, item) that depends on nothing else; results come as they are finished, so the caller
must add them up in a way that does not depend on the order. A worker that is killed costs the blocks it had in hand.
"""

from __future__ import annotations

import copyreg
import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import islice
from threading import Thread
from types import MappingProxyType
from typing import Any

from vcmm import __version__
from vcmm.core.errors import Environment, UsageError

Crew = Callable[[Callable[[Any, Any], Any], Any, Sequence[Any]], Iterator[tuple[int, Any]]]
MOST_WORKERS = 1024
PATIENCE = "10s"  # with a scheduler that does not answer
AHEAD = 4  # blocks in hand per worker, so that results do not pile up
DEATHS = 3  # of workers in a row without a finished block, before it is the work that kills them


def mapping(items: dict[Any, Any]) -> MappingProxyType[Any, Any]:
    """A read-only view, by a name that pickle finds."""
    return MappingProxyType(items)


copyreg.pickle(MappingProxyType, lambda view: (mapping, (dict(view),)))


def crew_of(workers: int | None = None, cluster: str | None = None) -> Crew:
    """The crew that is asked for: this process, `workers` processes here, or the Dask scheduler at `cluster`.

    Raises UsageError.
    """
    if workers is not None and cluster is not None:
        raise UsageError("workers are processes here, a cluster has its own; name one of the two")
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise UsageError(f"{workers} workers; use 1 to {MOST_WORKERS}, usually one per core")
    if cluster is not None:
        return on_cluster(cluster)
    return alone if workers in (None, 1) else processes(int(workers or 1))


def alone(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
    """(number of the item, result) one after another, here."""
    for i, item in enumerate(items):
        yield i, work(payload, item)


_held: Any = None  # (work, payload) of this worker


def _hold(packed: bytes) -> None:
    """Take the payload; end with the process that started this one, even where that was killed."""
    global _held
    Thread(target=_end_with_parent, daemon=True).start()
    _held = pickle.loads(packed)


def _end_with_parent() -> None:
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _one(item: Any) -> Any:
    work, payload = _held
    return work(payload, item)


def processes(workers: int) -> Crew:
    """A crew of processes on this computer; each takes the payload once."""

    def run(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        packed, left, deaths = pickle.dumps((work, payload)), dict(enumerate(items)), 0
        while left:
            before = len(left)
            for i, result in _until_a_death(workers, packed, left):
                del left[i]
                yield i, result
            deaths = 0 if len(left) < before else deaths + 1
            if left and deaths == DEATHS:
                raise Environment(
                    f"{deaths * workers} workers ended without a result, most likely for want of memory; use fewer --workers"
                )

    return run


def _until_a_death(workers: int, packed: bytes, left: dict[int, Any]) -> Iterator[tuple[int, Any]]:
    """Results until all are there or a worker was killed, which ends the whole pool."""
    from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import get_context

    pool, waiting = (
        ProcessPoolExecutor(workers, get_context("spawn"), _hold, (packed,)),
        iter([*left.items()]),
    )
    running: dict[Future[Any], int] = {}
    try:
        with suppress(BrokenProcessPool):
            while True:
                for i, item in islice(waiting, AHEAD * workers - len(running)):
                    running[pool.submit(_one, item)] = i
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def on_cluster(address: str) -> Crew:
    """A crew of Dask workers. Raises Environment: no Dask, no scheduler there, other versions on the workers."""

    def run(work: Callable[[Any, Any], Any], payload: Any, items: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        distributed = _distributed()
        try:
            client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise Environment(
                f"no Dask scheduler answers at {address} ({error}); start one with: dask scheduler"
            ) from None
        try:
            _check_versions(client, address)
            # the result of a task, which the scheduler makes again where the workers that held it are gone; scattered data would be lost
            shared = client.submit(_shared, versions(), work, payload, retries=DEATHS, pure=False)
            waiting, running = enumerate(items), {}
            finished = distributed.as_completed(loop=client.loop)

            def hand_out(most: int) -> None:
                for i, item in islice(waiting, most):
                    future = client.submit(_on_worker, shared, item, retries=DEATHS, pure=False)
                    running[future] = i
                    finished.add(future)

            hand_out(AHEAD * max(1, sum(client.nthreads().values())))
            for future in finished:
                yield running.pop(future), future.result()
                hand_out(1)
        finally:
            client.close()  # lets go of all futures: what is not finished is cancelled

    return run


def _shared(due: dict[str, str], work: Callable[[Any, Any], Any], payload: Any) -> tuple[Any, ...]:
    """What all blocks of a job need, on a worker."""
    return due, work, payload


def _on_worker(shared: Any, item: Any) -> Any:
    """One block; a worker that came later than the others is looked at as well."""
    from distributed import get_worker

    due, work, payload = shared
    _same_versions(due, versions(), get_worker().address)
    return work(payload, item)


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise Environment('--cluster needs Dask: pip install "vcmm[cluster]"') from None
    return distributed


def versions() -> dict[str, str]:
    """What must be the same on the client and on every worker for the same numbers to the last bit."""
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
    for worker, found in theirs.items():
        _same_versions(mine, found, worker)


def _same_versions(mine: dict[str, str], found: dict[str, str], worker: str) -> None:
    for name, version in mine.items():
        if found.get(name) != version:
            raise Environment(
                f"{name} is {version} here and {found.get(name)} on the worker {worker}; install the same on both"
            )
