"""Work that takes seconds of processor time, in a process of its own below everything else in priority: live data go on meanwhile."""

from __future__ import annotations

import asyncio
import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from config.errors import DaemonError, LongreachError
from daemon.server.protocol import error_from

_NICE = 10

Answer = dict[str, Any]


class Background:
    """One process, started when it is first needed; one piece of work at a time."""

    def __init__(self, what: str, limit_s: float) -> None:
        """`what` it does, for messages: "planning"."""
        self._what, self._limit_s = what, limit_s
        self._worker: ProcessPoolExecutor | None = None

    async def run(self, work: Callable[..., Answer], *arguments: Any) -> Answer:
        """`work(*arguments)`, a function of a module. Raises its refusals; DaemonError when it takes too long."""
        if self._worker is None:
            self._worker = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), initializer=os.nice, initargs=(_NICE,))
        try:
            job = asyncio.get_running_loop().run_in_executor(self._worker, _refusals_as_answers, work, arguments)
            async with asyncio.timeout(self._limit_s):  # wait_for of Python 3.11 swallows an end that comes together with the answer
                answer = await job
        except TimeoutError as error:
            self.close()
            raise DaemonError(f"{self._what} takes too long", limit=self._limit_s, unit="s") from error
        except BrokenProcessPool as error:
            self.close()
            raise DaemonError(f"the process for {self._what} ended", next_step="Ask again.") from error
        if "refused" in answer:
            raise error_from(answer["refused"])
        return answer

    def close(self) -> None:
        """End the process, whatever it does."""
        worker, self._worker = self._worker, None
        if worker is None:
            return
        processes = list(worker._processes.values())
        worker.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()


def _refusals_as_answers(work: Callable[..., Answer], arguments: tuple[Any, ...]) -> Answer:
    """An exception would lose the parts of its message on the way between processes."""
    try:
        return work(*arguments)
    except LongreachError as error:
        return {"refused": {"class": type(error).__name__, **error.refusal.as_dict()}}
