"""LAMMPS' messages as typed errors, and the cause of a divergence."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest

from beadband.lammps.divergence import Divergence, DivergenceError, find
from beadband.lammps.failures import failure
from beadband.lammps.scripts import assignments
from beadband.notices import notice


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("ERROR on proc 0: Bond length > table outer cutoff: type 1 length 2 (src/bond.cpp:1)", "diverged"),
        ("ERROR on proc 0: Pair distance < table inner cutoff: ijtype 3 3 dist 1", "diverged"),
        ("ERROR: Lost atoms: original 240 current 239", "lost"),
        ("ERROR on proc 0: Bond atoms 4 5 missing on proc 0 at step 7", "lost"),
        ("ERROR: Fix halt condition for fix-id guard met on step 200 with value 0", "energy-rose"),
        ("ERROR: Particle outside surface of region used in fix wall/region", "broke-through-finger"),
        ("ERROR: cannot open file band.data: No such file or directory", "disk"),
        ("ERROR: Unknown command: no_such_command", "refused-script"),
    ],
)
def test_a_message_has_a_code(text: str, code: str) -> None:
    error = failure(text)
    assert error.code == code
    assert isinstance(error, DivergenceError) == (code in ("diverged", "lost", "energy-rose"))
    assert error.complaint is not None
    assert "\n" not in str(error)
    assert ".cpp" not in str(error)
    assert ("--timestep" in error.complaint.advice) == (
        code in ("diverged", "lost", "energy-rose", "broke-through-finger")
    )


def test_a_divergence_passes_between_processes() -> None:
    cause = notice("step-beyond-limit", value=1.2)
    error = DivergenceError("the run diverged", "energy-rose", Divergence(3, 4, 1e-3, 10, 0.5, cause))
    again = pickle.loads(pickle.dumps(error))
    assert (again.code, again.found, str(again)) == ("energy-rose", error.found, "the run diverged")


def test_causes_are_read_from_the_pattern() -> None:
    count = 40
    bonds = np.stack([np.arange(1, count), np.arange(2, count + 1)], axis=1)

    def chain(stretches: np.ndarray) -> np.ndarray:
        return np.stack([np.concatenate([[0.0], np.cumsum(stretches)]), np.zeros(count)], axis=1)

    def found(positions: np.ndarray, share: float) -> Divergence:
        divergence = find(positions, bonds, 1.0, 100, share * 1e-6, 1e-6)
        assert divergence is not None
        return divergence

    zigzag = chain(1.0 + 0.3 * (-1.0) ** np.arange(count - 1) * np.exp(-0.1 * (np.arange(count - 1) - 20) ** 2))
    at_limit = found(zigzag, 0.95)
    assert abs(at_limit.bead - 21) <= 1
    assert at_limit.time_s == pytest.approx(0.95e-4)
    assert (at_limit.cause.code, at_limit.cause.values["way"]) == ("step-at-limit", "length")
    beyond = found(zigzag, 1.2).cause
    assert (beyond.code, beyond.values["value"]) == ("step-beyond-limit", pytest.approx(1.2))
    assert found(zigzag, 0.5).cause.code == "bead-scale-ringing"
    torn = np.ones(count - 1)
    torn[7] = 3.0
    overstretched = found(chain(torn), 0.5)
    assert (overstretched.bead, overstretched.other) == (8, 9)
    assert overstretched.strain == pytest.approx(2.0)
    assert overstretched.cause.code == "overstretched"
    lost = chain(torn)
    lost[10:] = math.nan
    assert not math.isfinite(found(lost, 1.0).strain)


def test_only_plain_text_becomes_a_variable() -> None:
    assert assignments({"k": 0.1, "style": "table spline 2001"}).endswith('index "table spline 2001"\n')
    for text in ('a" ; shell rm', "${x}", "a\nb", "a # b", "a & b"):
        with pytest.raises(ValueError, match="variable"):
            assignments({"style": text})
