"""One check: a measured number beside an exact one."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """A number measured on the beads, the exact one, and how far apart they may be."""

    rung: str
    name: str
    """What is compared, with its unit."""
    measured: float
    exact: float
    bound: float
    """Largest error that passes: a few times that of a sound chain at this resolution."""
    note: str = ""
    code: str | None = None
    """Code of the error that kept it from being made."""
    skipped: bool = False
    """Could not be made here: neither passed nor failed."""

    @property
    def error(self) -> float:
        """Deviation over the exact value; the deviation itself where the exact value is 0."""
        deviation = abs(float(self.measured) - float(self.exact))
        return deviation / abs(float(self.exact)) if self.exact != 0.0 else deviation

    @property
    def relative(self) -> bool:
        """Whether :attr:`error` is relative to the exact value."""
        return self.exact != 0.0

    @property
    def passed(self) -> bool:
        """Whether the check was made and its error is within the bound; NaN is not."""
        return not self.skipped and math.isfinite(self.error) and self.error <= self.bound

    @property
    def failed(self) -> bool:
        """Whether the check was made and did not pass."""
        return not self.skipped and not self.passed
