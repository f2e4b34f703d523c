"""Where many searches run: any `concurrent.futures.Executor`. Processes of this machine by default, a Dask cluster at an address.

Tasks are module-level functions of picklable arguments that return all they have to say, so that the place they run at cannot matter.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from threading import Thread
from typing import Any, TypeVar

from config.errors import ConfigError, Mend
from config.progress import Progress

Task = TypeVar("Task")
Answer = TypeVar("Answer")

THREADS_OF_LIBRARIES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")  # the searches bring their own threads
CONNECT_S = 5.0
SOON_S = 3.0  # after which a scheduler without a worker is told
WORKER_S = 60.0  # after which it is given up


def _to_stderr(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


@contextmanager
def executor(workers: int | None = None, dask: str | None = None, progress: Progress = _to_stderr) -> Iterator[Executor]:
    """`workers` processes (default: one a processor), or the workers of the Dask scheduler at `dask` ("tcp://host:8786").

    Leaving the context waits for nothing: what has not begun is cancelled, processes of this machine end whatever they do, as they do
    when this one is killed. ConfigError without the extra `longreach[dask]`, when the scheduler does not answer, or when no worker joins
    it within a minute; `progress` is told while it waits for one.
    """
    if dask is not None:
        with _dask_executor(dask, progress) as pool:
            yield pool
        return
    # spawn: a forked copy of a process with threads and compiled code may hang
    pool_of_processes = ProcessPoolExecutor(workers or os.cpu_count() or 1, multiprocessing.get_context("spawn"), _begin_worker)
    others = set(multiprocessing.active_children())
    try:
        yield pool_of_processes
    finally:
        pool_of_processes.shutdown(wait=False, cancel_futures=True)
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()


def each(pool: Executor, work: Callable[[Task], Answer], tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
    """Number and answer of every task, in the order in which they are finished. A task's exception is raised here."""
    waiting = {pool.submit(work, task): number for number, task in enumerate(tasks)}
    for future in as_completed(waiting):
        yield waiting[future], future.result()


_WITHOUT: Mend = {"--dask": None}  # on this computer alone


@contextmanager
def _dask_executor(address: str, progress: Progress) -> Iterator[Executor]:
    try:
        from distributed import Client  # optional: only who asks for a cluster needs it
    except ImportError as error:
        advice = 'Install it with: pip install "longreach[dask]"'
        raise ConfigError("a Dask cluster needs the library distributed", where="--dask", next_step=advice, mend=_WITHOUT) from error
    _refuse_unless_scheduler(address)
    client: Any = Client(address, timeout=CONNECT_S, set_as_default=False)
    try:
        _await_worker(client, address, progress)
        yield client.get_executor(pure=False)
    finally:
        client.close()


def _await_worker(client: Any, address: str, progress: Progress) -> None:
    start_one = f"Start one: dask worker {address}"
    with suppress(TimeoutError):
        client.wait_for_workers(1, timeout=SOON_S)
        return
    progress(f"the Dask scheduler {address} has no worker; waiting {WORKER_S:g} s for one. {start_one}")
    try:
        client.wait_for_workers(1, timeout=WORKER_S)
    except TimeoutError as error:
        what, advice = f"no worker joined the Dask scheduler within {WORKER_S:g} s", f"{start_one}, or leave --dask away."
        raise ConfigError(what, value=address, where="--dask", next_step=advice, mend=_WITHOUT) from error


def _refuse_unless_scheduler(address: str) -> None:
    """Asks who is there before a Client is made: one without a scheduler tries on by itself and ends in tracebacks of its threads."""
    advice = "Write tcp://HOST:PORT as `dask scheduler` shows it, or leave --dask away to use this machine's processes."
    try:
        kind = asyncio.run(asyncio.wait_for(_identity(address), CONNECT_S))["type"]
    except ValueError as error:
        raise ConfigError("no address of a Dask scheduler", value=repr(address), where="--dask", next_step=advice, mend=_WITHOUT) from error
    except Exception as error:  # silence, and whatever the bytes of a stranger break in the library
        what = f"no Dask scheduler answers within {CONNECT_S:g} s"
        raise ConfigError(what, value=address, where="--dask", next_step=advice, mend=_WITHOUT) from error
    if kind != "Scheduler":
        raise ConfigError(f"a Dask {kind} answers, no scheduler", value=address, where="--dask", next_step=advice, mend=_WITHOUT)


async def _identity(address: str) -> dict[str, Any]:
    from distributed.core import rpc
    from distributed.security import Security

    async with rpc(address, timeout=CONNECT_S, connection_args=Security().get_connection_args("client")) as remote:
        answer: dict[str, Any] = await remote.identity()
    return answer


def _begin_worker() -> None:
    for name in THREADS_OF_LIBRARIES:
        os.environ[name] = "1"
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """A search goes on for minutes after whoever asked for it was killed, beside a rig's loop."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
