"""The pool: the same outcomes wherever tasks run, and one clear end for tasks and workers that fail."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pytest

from beadband.errors import BeadbandError, RunError, UsageError
from beadband.studies.pool import Failed, Together, jobs_of, run_all, run_numbered, run_tasks

NUMBERS = list(range(10))


def inverse(number: int) -> float:
    if number == 0:
        raise UsageError("no inverse", "zero")
    if number < 0:
        raise RunError("a negative number", "negative")
    return 1.0 / number


def process_of(_: int) -> int:
    return os.getpid()


def deadly(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def deadly_once(flag: Path, number: int) -> int:
    if number == 3 and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def slow(number: int) -> int:
    time.sleep(0.01)
    return number


EXPECTED = [Failed("zero", "no inverse", refused=True), *(1.0 / number for number in NUMBERS[1:])]


@pytest.mark.parametrize("jobs", [1, 2])
def test_outcomes_do_not_depend_on_the_number_of_processes(jobs: int) -> None:
    seen: list[tuple[int, int]] = []
    found = run_all(inverse, NUMBERS, jobs=jobs, chunk=3, progress=lambda done, total: seen.append((done, total)))
    assert found == EXPECTED
    assert seen == [(done, 10) for done in range(1, 11)]
    assert run_all(inverse, [-1], jobs=jobs) == [Failed("negative", "a negative number")]
    assert run_all(inverse, [], jobs=jobs) == []


def test_one_job_stays_in_this_process_and_more_leave_it() -> None:
    assert set(run_all(process_of, NUMBERS, jobs=1)) == {os.getpid()}
    assert os.getpid() not in run_all(process_of, NUMBERS, jobs=2)


@pytest.mark.parametrize("kind", [ThreadPoolExecutor, partial(ProcessPoolExecutor, mp_context=get_context("spawn"))])
def test_a_given_executor_runs_the_tasks_and_stays_open(kind: type[Executor]) -> None:
    with kind(2) as executor:
        assert run_all(inverse, NUMBERS, executor=executor, jobs=2) == EXPECTED
        assert executor.submit(inverse, 2).result() == 0.5


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_fault_names_its_item(jobs: int) -> None:
    with pytest.raises(TypeError) as caught:
        run_all(inverse, [1, "a word"], jobs=jobs)  # type: ignore[list-item]
    assert caught.value.__notes__ == ["in task 1: 'a word'"]


def test_a_fault_cancels_what_has_not_begun() -> None:
    with ThreadPoolExecutor(1) as executor:
        begun: list[int] = []

        def task(number: int) -> None:
            begun.append(number)
            slow(number)
            raise ValueError("a fault")

        with pytest.raises(ValueError, match="a fault"):
            run_all(task, NUMBERS, executor=executor)
    assert len(begun) < 4


def test_a_task_that_kills_its_process_fails_and_no_other_does() -> None:
    found = run_all(deadly, NUMBERS, jobs=2)
    assert isinstance(found[3], Failed)
    assert found[3].code == "worker-died"
    assert [number for number in found if not isinstance(number, Failed)] == [0, 1, 2, *range(4, 10)]


def test_a_process_that_dies_once_is_replaced(tmp_path: Path) -> None:
    assert run_all(partial(deadly_once, tmp_path / "flag"), NUMBERS, jobs=2, chunk=2) == NUMBERS


def test_an_executor_that_breaks_is_one_error() -> None:
    class Broken(Executor):
        def submit(self, *_: object, **__: object) -> Future[None]:  # type: ignore[override]
            raise BrokenExecutor("all workers are gone")

    with pytest.raises(RunError, match="all workers are gone") as caught:
        run_all(inverse, NUMBERS, executor=Broken())
    assert caught.value.code == "worker-died"


def test_a_script_without_its_guard_is_one_error(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text("from beadband.studies.pool import run_all\nrun_all(abs, [1, 2, 3], jobs=2)\n")
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60.0, check=False)
    assert "RunError: the worker processes did not start" in done.stderr


@pytest.mark.parametrize("jobs", [1, 2])
def test_work_that_is_left_early_stops(jobs: int) -> None:
    work = run_tasks(slow, list(range(10_000)), jobs=jobs)
    next(work)
    start = time.perf_counter()
    work.close()
    assert time.perf_counter() - start < 5.0


def test_ctrl_c_ends_all_processes_at_once(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import time\nfrom beadband.studies.pool import run_all\n"
        "if __name__ == '__main__':\n    print('up', flush=True)\n    run_all(time.sleep, [0.0] + 8 * [60.0], jobs=2, "
        "progress=lambda *_: print('begun', flush=True))\n"
    )
    process = subprocess.Popen(
        [sys.executable, script], start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "up\n"
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)
    _, complaints = process.communicate(timeout=20.0)
    assert process.returncode != 0
    assert "SpawnProcess" not in complaints


def test_numbers_of_jobs() -> None:
    assert jobs_of(None) >= 1
    assert jobs_of(3) == 3
    for jobs in (0, 1025):
        with pytest.raises(UsageError, match="--jobs"):
            jobs_of(jobs)


def inverses(numbers: list[int]) -> list[float | BeadbandError]:
    """Of many at once, with errors in their places."""
    assert 1 <= len(numbers) <= 3
    return [1.0 / number if number else UsageError("no inverse", "zero") for number in numbers]


@pytest.mark.parametrize("jobs", [1, 2])
def test_tasks_that_are_done_together_have_the_same_outcomes(jobs: int) -> None:
    assert run_all(Together(inverses), NUMBERS, jobs=jobs, chunk=3) == EXPECTED


def raises_twice(folder: Path, number: int) -> int:
    """Two is raised over for ever, three twice."""
    tries = len(list(folder.glob(f"{number}-*")))
    if number == 2 or (number == 3 and tries < 2):
        (folder / f"{number}-{tries}").touch()
        raise ValueError("a fault")
    return number


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_task_that_raises_is_done_again_at_most_twice_where_that_is_asked_for(tmp_path: Path, jobs: int) -> None:
    found = run_all(partial(raises_twice, tmp_path), NUMBERS, jobs=jobs, chunk=4, forgiving=True)
    assert found[2] == Failed("raised", "ValueError: a fault")
    assert [number for number in found if not isinstance(number, Failed)] == [0, 1, *range(3, 10)]
    assert len(list(tmp_path.glob("2-*"))) == 3


def hangs(folder: Path, number: int) -> int:
    """Two hangs for ever, five once."""
    tries = len(list(folder.glob(f"{number}-*")))
    if number == 2 or (number == 5 and tries == 0):
        (folder / f"{number}-{tries}").touch()
        time.sleep(1000.0)
    return number


def test_a_worker_that_hangs_is_replaced_and_its_tasks_are_done_again(tmp_path: Path) -> None:
    found = run_all(partial(hangs, tmp_path), NUMBERS, jobs=2, chunk=2, patience_s=1.0)
    assert isinstance(found[2], Failed)
    assert found[2].code == "worker-hung"
    assert [number for number in found if not isinstance(number, Failed)] == [0, 1, *range(3, 10)]
    assert len(list(tmp_path.glob("2-*"))) <= 3


class Engine(Executor):
    """Threads that lose some calls, and say so in an error of their own."""

    def __init__(self, lost: int) -> None:
        self.threads, self.lost = ThreadPoolExecutor(2), lost

    def submit(self, *arguments: object, **more: object) -> Future[object]:  # type: ignore[override]
        if self.lost:
            self.lost -= 1
            gone: Future[object] = Future()
            gone.set_exception(OSError("the node is gone"))
            return gone
        return self.threads.submit(*arguments, **more)  # type: ignore[arg-type]


def test_what_an_engine_loses_is_done_again_and_an_engine_that_loses_all_is_an_error() -> None:
    assert run_all(inverse, NUMBERS, executor=Engine(lost=7)) == EXPECTED
    with pytest.raises(RunError, match="the node is gone"):
        run_all(inverse, list(range(1000)), executor=Engine(lost=10_000))


@pytest.mark.parametrize("jobs", [1, 2])
def test_tasks_are_taken_as_there_is_room_for_them(jobs: int) -> None:
    taken = []

    def tasks() -> Iterator[tuple[int, int]]:
        for number in range(10_000):
            taken.append(number)
            yield number, number

    for done, _ in enumerate(run_numbered(slow, tasks(), 10_000, jobs=jobs, chunk=5), 1):
        assert len(taken) - done <= 5 * (2 * jobs + 1)
        if done == 50:
            break
