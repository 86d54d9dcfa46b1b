"""Chunks of tasks on any executor: handed out as there is room, and done again where a worker dies, hangs or raises.

A task is done again at most :data:`AGAIN` times. Where one lost worker breaks the whole executor, as in a pool of
processes, the tasks that were out are repeated one at a time with nothing else handed out, to find the one to blame.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib import import_module
from itertools import islice
from multiprocessing import get_context
from queue import Empty, SimpleQueue
from typing import Any

from beadband.errors import RunError, UsageError, explain

Chunk = list[tuple[int, Any]]
"""Tasks that are handed over at once, each with its number."""
Work = Callable[[Any, Chunk, int], list[tuple[int, Any]]]
"""Called with the function, a chunk, and how often its first task was lost; gives an outcome for each task."""

AGAIN = 2
"""Times that a task is done again after its worker was lost over it."""
PATIENCE_S = 60.0
"""Seconds beyond the expected ones after which a worker counts as hung."""
WORKER_DIED, WORKER_HUNG, RAISED = "worker-died", "worker-hung", "raised"
"""Codes of a task that was lost too often; the first also of an executor that broke."""
_END_S = 10.0
"""Seconds after which workers that are to end count as hung."""
_MOST_LOSSES = 100
"""Chunks lost in a row, without one that came back, after which the engine itself counts as broken."""
_LEAST_AHEAD = 64
"""Chunks handed to an executor at once, at least: more than enough to keep workers of an unknown number busy."""


@dataclass(frozen=True)
class Fault:
    """An exception of a task that is no answer; with its traceback where it happened in another process."""

    error: Exception
    trace: str

    def __str__(self) -> str:
        return f"{type(self.error).__name__}: {' '.join(str(self.error).split())}"


def fault_of(error: Exception) -> Fault:
    """An exception as it can be handed to another process."""
    trace = traceback.format_exc()
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # noqa: BLE001  whatever stands in the way, its text is left
        return Fault(RuntimeError(f"{type(error).__name__}: {error}"), trace)
    return Fault(error, trace)


@dataclass(frozen=True)
class Lost:
    """Why a task has no outcome."""

    code: str
    reason: str


@dataclass(frozen=True)
class Engine:
    """Where chunks are worked on."""

    open: Callable[[int], Executor]
    """Gives an executor of so many workers."""
    close: Callable[[Executor], None]
    workers: int
    ahead: int
    """Most chunks that are out at a time."""
    replaces: bool = False
    """Whether one that broke can be opened again."""
    kill: Callable[[Executor], None] | None = None
    """Ends or restarts its workers, where that is the way to be rid of a hung one."""


class _Here(Executor):
    """Works in this process, at once."""

    def submit(self, call: Callable[..., Any], /, *args: Any, **more: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(call(*args, **more))
        except Exception as error:  # noqa: BLE001  handed to whoever asks for the result
            future.set_exception(error)
        return future


def here() -> Engine:
    """This process."""
    return Engine(lambda _: _Here(), lambda _: None, 1, 1)


def given(executor: Executor, workers: int | None) -> Engine:
    """An executor that stays open, of so many workers, None where it is not known."""
    known = workers or _workers_of(executor)
    ahead = max(_LEAST_AHEAD, 3 * (known or 1))
    restart = _restart if hasattr(getattr(executor, "_client", None), "restart_workers") else None
    return Engine(lambda _: executor, lambda _: None, known or 1, ahead, kill=restart)


def _restart(executor: Any) -> None:
    """Restart the workers of a Dask client, which would give tasks to a hung one for minutes yet."""
    client = executor._client
    client.restart_workers(list(client.nthreads()), raise_for_error=False)


def _workers_of(executor: Any) -> int | None:
    """Workers of an executor as far as it says: threads and processes, ranks of MPI, a Dask client."""
    for name in ("_max_workers", "num_workers"):
        if isinstance(number := getattr(executor, name, None), int):
            return number
    client: Any = getattr(executor, "_client", None)
    return len(client.nthreads()) if hasattr(client, "nthreads") else None


def processes(jobs: int) -> Engine:
    """Spawned processes of this machine."""
    # More threads than cores slow small systems down; a setting of the user's stays.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    return Engine(_spawned, _close, jobs, 2 * jobs, True, _kill)


def _spawned(jobs: int) -> Executor:
    # Spawned, for LAMMPS and MPI do not survive a fork.
    return _Pool(jobs, mp_context=get_context("spawn"), initializer=_watch_interrupts)


class _Pool(ProcessPoolExecutor):
    """Processes that know whether they ever started."""

    first: Future[None]

    def start(self, function: Any) -> None:
        """Hand out a first task, which fails only where the processes can't start; what others need is imported."""
        self.first = self.submit(_started, function)


def _started(_: Any) -> None:
    pass


def _close(pool: Any) -> None:
    """End the processes; those that have not ended by themselves after a while are killed: an idle one may hang too."""
    late = threading.Timer(_END_S, _kill_these, [list((pool._processes or {}).values())])
    late.daemon = True
    late.start()
    pool.shutdown(cancel_futures=True)
    late.cancel()


def _kill_these(processes: list[Any]) -> None:
    for process in processes:
        process.kill()


def _kill(pool: Any) -> None:
    _kill_these(list((pool._processes or {}).values()))


_busy = _interrupted = False


def _watch_interrupts() -> None:
    """Ctrl-C reaches all processes of a terminal: it ends the task of this one, and an idle one stays silent."""

    def interrupt(*_: object) -> None:
        global _interrupted
        _interrupted = True
        if _busy:
            raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)


def until_interrupted(work: Work, function: Any, chunk: Chunk, lost: int) -> list[tuple[int, Any]]:
    """Work on a chunk, unless Ctrl-C has reached this process before."""
    global _busy
    if _interrupted:
        raise KeyboardInterrupt
    _busy = True
    try:
        return work(function, chunk, lost)
    finally:
        _busy = False


_hung: list[Chunk] = []


def left_behind() -> bool:
    """Whether workers of an executor hang, so that nothing is to wait for them."""
    return bool(_hung)


def end(shutdown: Callable[[], object]) -> None:
    """Shut an executor down, on another thread that is left to itself where a worker does not end."""
    closing = threading.Thread(target=shutdown, daemon=True)
    closing.start()
    closing.join(_END_S)
    if closing.is_alive():
        _hung.append([])


@dataclass
class Ledger:
    """What is out, what is to be done again, and how often each task was lost."""

    chunks: Iterator[Chunk]
    forgiving: bool
    again: deque[Chunk] = field(default_factory=deque)
    suspects: deque[Chunk] = field(default_factory=deque)
    """Single tasks, one of which may have broken the executor."""
    losses: Counter[int] = field(default_factory=Counter)

    def take(self) -> Chunk | None:
        """What to hand out next."""
        return self.again.popleft() if self.again else next(self.chunks, None)

    def suspect(self) -> Chunk | None:
        return self.suspects.popleft() if self.suspects else None

    def lose(self, chunk: Chunk, why: Lost, queue: deque[Chunk]) -> list[tuple[int, Any, Any]]:
        """Put tasks in a queue to be done again, each alone; return those that were lost too often."""
        failed = []
        for index, item in chunk:
            self.losses[index] += 1
            if self.losses[index] > AGAIN:
                failed.append((index, item, why))
            else:
                queue.append([(index, item)])
        return failed

    def settle(self, chunk: Chunk, outcomes: list[tuple[int, Any]]) -> list[tuple[int, Any, Any]]:
        """Outcomes with their items; tasks that raised are done again, or raise here."""
        settled = []
        for (index, item), (_, outcome) in zip(chunk, outcomes, strict=True):
            if not isinstance(outcome, Fault):
                settled.append((index, item, outcome))
            elif self.forgiving:
                settled += self.lose([(index, item)], Lost(RAISED, str(outcome)), self.again)
            else:
                raise outcome.error from (outcome.error.__cause__ or RuntimeError(outcome.trace))
        return settled


def work_through(
    engine: Engine,
    work: Work,
    function: Any,
    ledger: Ledger,
    patience_s: float,
    expected_s: Callable[[list[Any]], float],
) -> Generator[list[tuple[int, Any, Any]], None, None]:
    """Yield (number, item, outcome) of tasks as they are completed, a list at a time.

    A worker counts as hung once it has taken ``patience_s`` longer than ``expected_s`` of its items. The outcome of a
    task that was lost too often is :class:`Lost`. RunError when the engine is broken and can't be replaced.
    """
    while True:
        alone = bool(ledger.suspects)
        take = ledger.suspect if alone else ledger.take
        if (chunk := take()) is None:
            return
        (ledger.suspects if alone else ledger.again).appendleft(chunk)
        executor = engine.open(1 if alone else engine.workers)
        clock = _Clock(1 if alone else engine.workers, patience_s, expected_s)
        row, broken = 0, []
        try:
            for chunk, found in _until_broken(engine, executor, work, function, ledger, take, clock, alone):
                if isinstance(found, list):
                    row = 0
                    yield ledger.settle(chunk, found)
                elif isinstance(found, BrokenExecutor):
                    _refuse_broken(engine, executor, found)
                    broken.append(chunk)
                else:
                    row += 1
                    _hung.extend([chunk] * isinstance(found, TimeoutError))
                    if row > _MOST_LOSSES:
                        raise _broken(found)
                    yield ledger.lose(chunk, _why(found), ledger.again)
        finally:
            engine.close(executor)
        if broken:
            why = _why(TimeoutError() if clock.ran_out else BrokenExecutor())
            for chunk in reversed(broken):
                lost: deque[Chunk] = deque()
                failed = ledger.lose(chunk, why, lost)
                ledger.suspects.extendleft(reversed(lost))
                yield failed


def _until_broken(
    engine: Engine, executor: Executor, work: Work, function: Any, ledger: Ledger,
    take: Callable[[], Chunk | None], clock: _Clock, alone: bool,
) -> Generator[tuple[Chunk, list[tuple[int, Any]] | Exception], None, None]:  # fmt: skip
    """Chunks with what came of them; nothing more is handed out once the executor broke."""
    finished: SimpleQueue[Future[Any]] = SimpleQueue()
    out: dict[Future[Any], Chunk] = {}
    ahead = 1 if alone else engine.ahead
    if isinstance(executor, _Pool):
        executor.start(function)
        executor.first.add_done_callback(clock.start)
    try:
        while True:
            while len(out) < ahead and (chunk := take()) is not None:
                lost = ledger.losses[chunk[0][0]]
                try:
                    future = executor.submit(*_call(engine, work, function, chunk, lost))
                except BrokenExecutor as error:
                    future = Future()
                    future.set_exception(error)
                out[future] = chunk
                future.add_done_callback(finished.put)
            if not out:
                return
            late = _wait(finished, out, clock)
            if isinstance(late, Future):
                if late not in out:
                    continue  # given up before
                chunk = out.pop(late)
                clock.forget(late)
                clock.started = True
                failure = late.exception() if not late.cancelled() else BrokenExecutor("the task was cancelled")
                if failure is not None and not isinstance(failure, Exception):
                    raise failure
                if isinstance(failure, BrokenExecutor) and engine.replaces:
                    ahead = 0
                yield chunk, failure if failure is not None else late.result()
                continue
            if engine.kill is not None:
                engine.kill(executor)
            # In a pool of processes all that is out breaks with them, and comes back so.
            if not engine.replaces:
                for future in late:
                    _cancel(future)
                    clock.forget(future)
                    yield out.pop(future), TimeoutError()
    finally:
        for future in out:
            _cancel(future)


def _cancel(future: Future[Any]) -> None:
    with suppress(NotImplementedError):  # Parsl's can't be
        future.cancel()


def _call(engine: Engine, work: Work, function: Any, chunk: Chunk, lost: int) -> tuple[Any, ...]:
    return (until_interrupted, work, function, chunk, lost) if engine.replaces else (work, function, chunk, lost)


class _Clock:
    """How long each chunk has been worked on, and may be.

    An executor takes chunks in their order: the oldest ones that are out, one a worker, are those in work.
    """

    def __init__(self, workers: int, patience_s: float, expected_s: Callable[[list[Any]], float]) -> None:
        self._workers, self._patience_s, self._expected_s = workers, patience_s, expected_s
        self.started = False
        """No clock runs before the first worker has shown itself: it may wait for its machine."""
        self._since: dict[Future[Any], float] = {}
        self._until: dict[Future[Any], float] = {}
        self.ran_out = False

    def start(self, _: object) -> None:
        self.started = True

    def forget(self, future: Future[Any]) -> None:
        self._since.pop(future, None)
        self._until.pop(future, None)

    def overdue(self, out: dict[Future[Any], Chunk]) -> tuple[list[Future[Any]], float]:
        """Chunks that have had their time, and the seconds until another one may have."""
        now = time.monotonic()
        late: list[Future[Any]] = []
        next_s = self._patience_s
        for future in islice(out, self._workers if self.started else 0):
            since = self._since.setdefault(future, now)
            # What is expected is worked out for chunks that take long, no others.
            if now - since >= self._patience_s and future not in self._until:
                self._until[future] = since + self._patience_s + self._expected_s([item for _, item in out[future]])
            until = self._until.get(future, since + self._patience_s)
            if future in self._until and now >= until:
                late.append(future)
            else:
                next_s = min(next_s, max(until - now, 0.0))
        self.ran_out = self.ran_out or bool(late)
        return late, next_s


def _wait(
    finished: SimpleQueue[Future[Any]], out: dict[Future[Any], Chunk], clock: _Clock
) -> Future[Any] | list[Future[Any]]:
    """The next chunk that comes back, or those that are overdue."""
    while True:
        late, seconds = clock.overdue(out)
        try:
            return finished.get(timeout=0.0 if late else seconds)
        except Empty:
            if late:
                return late


def _why(error: Exception) -> Lost:
    if isinstance(error, TimeoutError):
        reason = explain("the worker hung over this task", f"{AGAIN + 1} tries", "an answer in time", "run it alone")
        return Lost(WORKER_HUNG, str(reason))
    reason = explain("the worker died over this task", f"{AGAIN + 1} tries", "enough memory", "run it alone")
    return Lost(WORKER_DIED, str(reason))


def _broken(error: Exception) -> RunError:
    name = f"{type(error).__name__}: {' '.join(str(error).split())}" if not isinstance(error, BrokenExecutor) else error
    return RunError(explain("a worker of the executor died", name, "workers that live", "start again"), WORKER_DIED)


def _refuse_broken(engine: Engine, executor: Executor, error: BrokenExecutor) -> None:
    """RunError where an executor that broke can't be replaced, or never worked."""
    if not engine.replaces:
        raise _broken(error) from error
    if isinstance(executor, _Pool) and executor.first.exception() is not None:
        raise RunError(
            explain(
                "the worker processes did not start",
                error,
                'a script whose work stands under if __name__ == "__main__"',
                "or use one job",
            ),
            WORKER_DIED,
        ) from error


@contextmanager
def engine_of(name: str | None) -> Iterator[Executor | None]:
    """The executor that a factory gives, "module:factory" or "file.py:factory", for the time of the context.

    UsageError where there is none. None for no name.
    """
    if name is None:
        yield None
        return
    module, _, attribute = name.rpartition(":")
    try:
        sys.path.insert(0, os.getcwd())
        try:
            executor = getattr(import_module(module.removesuffix(".py")), attribute)()
        finally:
            sys.path.remove(os.getcwd())
        if not isinstance(executor, Executor):
            raise TypeError(f"it gives a {type(executor).__name__}")
    except Exception as error:
        text = f"{name} ({type(error).__name__}: {' '.join(str(error).split())})"
        allowed = "MODULE:FACTORY, a function without arguments that returns a concurrent.futures.Executor"
        raise UsageError(explain("the executor can't be made", text, allowed, "change --executor")) from error
    try:
        yield executor
    finally:
        end(lambda: executor.shutdown(wait=not left_behind()))
