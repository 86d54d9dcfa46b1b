"""The methods that are compared: how each family varies the production method, and at which sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from beadband.errors import UsageError, explain
from beadband.lammps.bond_table import LEG_TABLE_POINTS
from beadband.model.scene import Scene
from beadband.planning.plan import STEP_SHARE, Plan, plan_of

BEADS = (24, 34, 48, 68, 96, 136, 192, 272, 384, 544, 768, 1088, 1536, 2176)
"""Beads of the whole ring, over two decades; each other is twice the one before."""
_INNER_SHARE = 0.5
"""Inner step of rRESPA over the largest stable one of Verlet's method."""
_MOST_FOR_LEPTON = 400
"""Expressions are evaluated some forty times slower than tables: finer runs would take longer than all others."""


@dataclass(frozen=True)
class Extent:
    """How many variants are run at which sizes (beads of the whole ring, unless said), and how often."""

    beads: tuple[int, ...] = BEADS
    """Of the production runs."""
    variants: tuple[int, ...] = BEADS[2:-3]
    steps: tuple[int, ...] = (96, 272, 768)
    step_shares: tuple[float, ...] = (0.1, 0.2, 0.35, 0.5, 0.8, 0.95, 1.1, 1.3)
    """Steps over the largest stable one."""
    respa: tuple[int, ...] = BEADS[4:-1:2]
    respa_inner: tuple[int, ...] = (2, 3, 4, 6)
    """Inner steps in one outer step."""
    rings: tuple[int, ...] = BEADS[4:-3:2]
    spline_points: tuple[int, ...] = (21, 51, 501, 2001)
    linear_points: tuple[int, ...] = (51, 201, 2001, 20001)
    losses: tuple[float, ...] = (0.05, 0.1, 0.4, 0.8)
    """Numerical losses other than the production one, in times of the front from bead to bead."""
    repeats: int = 7
    cores: tuple[int, ...] = (100, 316, 1_000, 3_162, 10_000, 31_623, 100_000, 1_000_000)
    """Beads of the leg."""
    core_rounds: int = 3
    core_runs: int = 12
    """Short runs in each process, of which the quickest counts; the processes of the three ways take turns."""


FULL = Extent()
QUICK = Extent(
    beads=(24, 48, 96, 192, 384, 768),
    variants=(96, 192, 384),
    steps=(96, 384),
    step_shares=FULL.step_shares[1:],
    respa=(96, 384),
    respa_inner=(2, 4),
    rings=(96, 384),
    spline_points=(51, 2001),
    linear_points=(201, 2001),
    losses=(0.1, 0.8),
    repeats=3,
    cores=(100, 1_000, 10_000),
    core_rounds=1,
)

MAIN, LINEAR, LOSSY, STRING = "no loss, no spacing", "linear law", "physical loss", "string limit"
"""The limits to which methods may converge."""


@dataclass(frozen=True)
class Method:
    """One way to compute the release."""

    family: str
    variant: str
    plan: Plan
    model: str = "leg"
    """"leg" (leg_variants.in), "ring" (release.in), "ring files" (with all of a run's files), "contact"."""
    choices: dict[str, str | int] = field(default_factory=dict)
    """Choices of leg_variants.in that differ from those of legs.in."""
    table_points: int = LEG_TABLE_POINTS
    level: float = 0.0
    """How fine it is within its variant: bead count, or 1 over the share of the step limit; greater is finer."""
    own: str = MAIN
    """The limit that it converges to by construction."""

    @property
    def label(self) -> str:
        return f"{self.family}: {self.variant}, {self.plan.beads} beads"

    @property
    def inner(self) -> int:
        """Steps of the inner integrator in one of the outer."""
        return int(self.choices.get("inner", 1))

    @property
    def bead_steps(self) -> int:
        """Beads that are integrated, times (outer) steps."""
        return (self.plan.beads if self.model != "leg" else self.plan.leg_bonds + 2) * self.plan.steps


def leg_plan(scene: Scene, beads: int, loss_beads: float | None = None, loss_time_s: float | None = None) -> Plan:
    """The plan of one leg for its speed with so many beads, with its numerical loss or another.

    ``loss_beads`` is a numerical loss in times of the front from bead to bead. UsageError for a scene whose rear is
    affected by the finger before the front's arrival, so that one leg can't model it.
    """
    if loss_beads is not None:
        front = scene.band.density_kg_m3 * scene.string.front_speed_m_s / scene.band.modulus_pa
        loss_time_s = loss_beads * scene.strand(beads).spacing_m * front
    plan = plan_of(_open(scene, beads, loss_time_s), "leg")
    if plan.model != "leg":
        raise UsageError(
            explain(
                "the study compares models of one leg, and this scene is too stiff for one",
                f"band {scene.band.name} at the strain {scene.strain:g}",
                "scenes whose bending layer is short against the leg",
                "lower --bending-scale or --thickness",
            )
        )
    return plan


def ring_plan(scene: Scene, beads: int) -> Plan:
    """The plan of the whole ring, to the front's arrival."""
    return plan_of(_open(scene, beads, None))


def _open(scene: Scene, beads: int, loss_time_s: float | None) -> Scene:
    return replace(
        scene,
        beads=beads,
        timestep_s=None,
        loss_time_s=loss_time_s,
        frames=None,
        steps=None,
        rear_steps=None,
        planned=(),
        purpose="speed",
    )


def with_step(plan: Plan, share: float, inner: int = 1) -> Plan:
    """The same run with another step: ``share`` of the largest stable one, or of ``inner`` of them."""
    end, interval = plan.steps * plan.timestep_s, plan.rear_steps * plan.timestep_s
    target = share * inner * plan.largest_timestep_s
    rear_steps = max(1, int(interval / target * (1.0 + 1e-9)))
    steps = rear_steps * math.ceil(end / (rear_steps * target) * (1.0 - 1e-12))
    return replace(plan, timestep_s=end / steps, steps=steps, rear_steps=rear_steps)


def methods(scene: Scene, extent: Extent) -> list[Method]:
    """Every method of the study; Richardson pairs are made of their runs, and cores are timed separately."""
    bare = replace(scene, bending_scale=0.0)
    found = [Method("beads", "production", leg_plan(scene, n), level=n) for n in extent.beads]
    for n in extent.steps:
        plan = leg_plan(scene, n)
        for share in extent.step_shares:
            found.append(Method("step", f"{n} beads", with_step(plan, share), level=1.0 / share))
        found.append(Method("step", f"{n} beads", plan, level=1.0 / STEP_SHARE))
    found += _bonds(scene, extent)
    for n in extent.variants:
        plan = leg_plan(scene, n)
        for angle in ("harmonic", "cosine", "rod", "rod_table"):
            if angle != "rod" or n <= _MOST_FOR_LEPTON:
                found.append(Method("angle", angle.replace("_", " "), plan, choices={"angle": angle}, level=n))
        found.append(Method("loss", "dpd/ext/tstat", plan, choices={"dashpot_by": "dpd"}, level=n))
        found.append(Method("loss", "none", leg_plan(scene, n, loss_beads=0.0), level=n))
        for loss in extent.losses:
            found.append(Method("loss", f"numerical {loss:g}", leg_plan(scene, n, loss_beads=loss), level=n))
        physical = leg_plan(scene, n, loss_time_s=physical_loss_s(scene))
        found.append(Method("loss", "physical", physical, level=n, own=LOSSY))
        if scene.bending_scale > 0.0:
            found.append(Method("model", "leg without bending", leg_plan(bare, n), level=n, own=STRING))
        for output in ("samples", "dump", "nothing"):
            found.append(Method("output", _OUTPUT[output], plan, choices={"output": output}, level=n))
    found += _integrators(scene, extent)
    for n in extent.rings:
        plan = ring_plan(scene, n)
        for model in ("ring", "ring files", "contact"):
            found.append(Method("model", _MODEL[model], plan, model=model, level=n))
    return found


_OUTPUT = {"samples": "samples, not means", "dump": "text dump", "nothing": "numpy, step by step"}
_MODEL = {"ring": "ring, rear alone written", "ring files": "ring, all files", "contact": "ring with contact"}


def physical_loss_s(scene: Scene) -> float:
    """A loss time typical of the material: that of a bar wave over a third of the thickness."""
    return scene.band.thickness_m / (3.0 * scene.band.bar_speed_m_s)


def _bonds(scene: Scene, extent: Extent) -> Iterator[Method]:
    linear = scene.with_law("linear")
    for n in extent.variants:
        plan = leg_plan(scene, n)
        for points in extent.spline_points:
            yield Method("bond", f"spline, {points} points", plan, table_points=points, level=n)
        for points in extent.linear_points:
            choice: dict[str, str | int] = {"interpolation": "linear"}
            yield Method("bond", f"linear, {points} points", plan, choices=choice, table_points=points, level=n)
        if n <= _MOST_FOR_LEPTON:
            yield Method("bond", "lepton", plan, choices={"bond": "lepton"}, level=n)
        straight = leg_plan(linear, n)
        own = MAIN if scene.law == "linear" else LINEAR
        yield Method("bond", "harmonic", straight, choices={"bond": "harmonic"}, level=n, own=own)
        if own == LINEAR:
            yield Method("bond", "spline of linear law", straight, level=n, own=own)


def _integrators(scene: Scene, extent: Extent) -> Iterator[Method]:
    for n in extent.respa:
        plan = leg_plan(scene, n)
        for inner in extent.respa_inner:
            for inside in ("bonds", "angles"):
                yield Method(
                    "integrator",
                    f"{inside} inside, {inner} a step",
                    with_step(plan, _INNER_SHARE, inner),
                    choices={"stepping": f"{inside}_inside", "inner": inner},
                    level=n,
                )
