"""The engines of docs/engines.md, as they are printed there: the same table from each, whatever dies or hangs."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

import beadband
from beadband.errors import UsageError
from beadband.lammps.engine import program
from beadband.studies.engines import engine_of
from beadband.studies.sweep.store import TABLE
from conftest import REQUIRE_ALL

PAGE = (Path(__file__).parents[2] / "docs" / "engines.md").read_text(encoding="utf-8")
FLAGS = ["--strain", "0.2:1.0:40", "--tolerance", "0.02", "--by", "runs"]


def needs(*packages: str) -> None:
    for package in packages if not REQUIRE_ALL else ():
        pytest.importorskip(package)


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("one job")
    beadband.sweep(strain="0.2:1.0:40", tolerance=0.02, by="runs", out=folder)
    return (folder / TABLE).read_bytes()


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A folder with the files of the page."""
    for block in PAGE.split("```python\n")[1:]:
        text = block.split("```")[0]
        (tmp_path / text.split()[1]).write_text(text, encoding="utf-8")
    return tmp_path


def swept(place: Path, *words: str) -> bytes:
    """The table of a sweep that is started in a folder with these words before its flags."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path}
    done = subprocess.run(
        [*words, *FLAGS, "--out", "out"], cwd=place, env=environment, capture_output=True, text=True, timeout=120.0
    )
    assert done.returncode == 0, done.stderr
    return (place / "out" / TABLE).read_bytes()


SWEEP = (sys.executable, "-m", "beadband", "sweep")


def test_dask_gives_the_same_table(place: Path, table: bytes) -> None:
    needs("distributed")
    assert swept(place, *SWEEP, "--executor", "dask_engine:workers") == table


def test_parsl_gives_the_same_table(place: Path, table: bytes) -> None:
    needs("parsl")
    assert swept(place, *SWEEP, "--executor", "parsl_engine:workers") == table


def test_ranks_as_a_pool_give_the_same_table(place: Path, table: bytes) -> None:
    needs("mpi4py")
    mpirun = program("mpirun")
    assert mpirun is not None
    words = (mpirun, "-np", "2", sys.executable, "-m", "mpi4py.futures", *SWEEP[1:])
    assert swept(place, *words, "--executor", "mpi4py.futures:MPIPoolExecutor") == table


def test_the_slurm_example_runs_its_jobs(place: Path, table: bytes) -> None:
    """Slurm's commands are stand-ins: sbatch starts the job at once, srun runs one task of it."""
    needs("parsl")
    stand_ins = {
        "sbatch": 'setsid bash "${!#}" >/dev/null 2>&1 & echo Submitted batch job $!',
        "squeue": 'kill -0 "${!#}" && echo "${!#} R" || echo "${!#} CD"',
        "scancel": 'for job in "$@"; do kill -- -$job; done',
        "srun": 'while [[ $1 != bash ]]; do shift; done; exec "$@"',
    }
    for name, text in stand_ins.items():
        (place / name).write_text(f"#!/bin/bash\n{text}\n", encoding="utf-8")
        (place / name).chmod(0o755)
    engine = place / "slurm_engine.py"
    changed = engine.read_text(encoding="utf-8").replace("source ~/band/.venv/bin/activate; ", "")
    changed = changed.replace("max_workers_per_node=64", "max_workers_per_node=2").replace("=4,", "=1,")
    engine.write_text(changed.replace("address_by_hostname()", '"127.0.0.1"'), encoding="utf-8")
    words = ("env", f"PATH={place}:{Path(sys.executable).parent}:{os.environ['PATH']}", *SWEEP)
    assert swept(place, *words, "--executor", "slurm_engine:workers") == table


@pytest.mark.parametrize("name", ["nowhere:pool", "os:nothing", "os:getcwd", "json"])
def test_an_executor_that_can_not_be_made_is_one_line(name: str) -> None:
    with pytest.raises(UsageError, match="the executor can't be made"), engine_of(name):
        pass


def test_executors_are_found_in_the_current_folder(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    (place / "threads_here.py").write_text(
        "from concurrent.futures import ThreadPoolExecutor\ndef two():\n    return ThreadPoolExecutor(2)\n"
    )
    importlib.invalidate_caches()
    with engine_of("threads_here:two") as executor:
        assert executor is not None
        assert executor.submit(len, "four").result() == 4
    assert str(place) not in sys.path
