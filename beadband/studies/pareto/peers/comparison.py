"""Every method of beadband and every peer on the same scenes, in the same process: error against the whole time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.model.scene import Scene, scene_of
from beadband.runs.ask import ask
from beadband.studies.pareto.convergence import STALLED, Row, pairs, with_errors
from beadband.studies.pareto.methods import BEADS, MAIN, QUICK, Extent, Method, methods
from beadband.studies.pareto.outcomes import OK, OTHER_LIMIT, Outcome, noticed, outcome_of
from beadband.studies.pareto.peers.protocol import Peer, Trace, answer_of, installed
from beadband.studies.pareto.peers.registry import PEERS
from beadband.studies.pareto.reference import Reference, references, richardson_limit
from beadband.studies.pareto.runs import Answer

SCENES: dict[str, dict[str, Any]] = {
    "linear, common": {"law": "linear"},
    "linear, thin and wide": {"law": "linear", "thickness_m": 0.6e-3, "strain": 0.8, "half_angle_deg": 28.0},
    "linear, thick and slim": {"law": "linear", "thickness_m": 3e-3, "strain": 0.3, "half_angle_deg": 7.0},
    "rubber, common": {},
    "rubber, thin and wide": {"band": "II", "thickness_m": 0.7e-3, "strain": 0.9, "half_angle_deg": 25.0},
    "rubber, thick and slim": {"thickness_m": 3e-3, "strain": 0.6, "half_angle_deg": 8.0},
}
"""The scenes by their names: inputs that differ from the defaults (Band III, Mooney-Rivlin, 0.476, 14 degrees)."""

OURS, PLAN, ASK, PAIR, OTHER = "beadband, one leg", "plan", "ask", "pairs", "other methods"
TOLERANCES = (0.02, 0.005, 0.001, 0.0002)
"""At which `beadband ask` is asked, and peers are compared."""
_SLOW = ("lepton", "rod", "ring, all files")
"""Variants of beadband that cost many times more for the same answer; the study of one scene has them."""
_LONGEST_S = 2.0
"""Time after which a run of a peer is not repeated."""

SCENES_FULL = replace(
    QUICK,
    beads=BEADS[:-2],
    steps=(),
    variants=(96, 192, 384),
    respa=(96, 384),
    respa_inner=(2, 4),
    rings=(96,),
    spline_points=(51,),
    linear_points=(201,),
    losses=(0.1, 0.4),
    repeats=3,
)
SCENES_QUICK = replace(SCENES_FULL, beads=(24, 48, 96, 192, 384), variants=(96,), respa=(96,), rings=(), repeats=2)


@dataclass(frozen=True)
class Point:
    """One run of one tool on one scene; errors are relative, of V and of the curvature at 0.1 and 0.3 t_f."""

    scene: str
    tool: str
    level: float
    """Elements or beads; the tolerance of a plan and of an ask."""
    errors: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    bounds: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    """The largest error of this run and of all finer ones, not below the uncertainty of the reference."""
    loop_s: float = math.nan
    whole_s: float = math.nan
    """Quickest repeat of each."""
    status: str = OK
    reason: str = ""
    variant: str = ""

    def as_dict(self) -> dict[str, Any]:
        """As frontier.json has it."""
        return asdict(self)


@dataclass(frozen=True)
class Comparison:
    """All points, the scenes with their references, and what could not be compared."""

    points: tuple[Point, ...]
    scenes: dict[str, Scene]
    references: dict[str, Reference]
    peers: tuple[Peer, ...]
    second: dict[str, float]
    """V of the second method, extrapolated, over that of the reference, less 1, by scene."""

    @property
    def absent(self) -> list[str]:
        """Names of the peers that are not installed."""
        return [peer.name for peer in self.peers if not installed(peer)]


def compare(
    quick: bool = False,
    scenes: dict[str, dict[str, Any]] | None = None,
    peers: Iterable[Peer] | None = None,
    extent: Extent | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Comparison:
    """Run everything on every scene, one after the other; RunError when a reference fails."""
    extent = extent or (SCENES_QUICK if quick else SCENES_FULL)
    chosen = {name: scene_of(values) for name, values in (SCENES if scenes is None else scenes).items()}
    others = tuple(PEERS.values()) if peers is None else tuple(peers)
    points: list[Point] = []
    limits: dict[str, Reference] = {}
    second: dict[str, float] = {}
    with Session() as session:
        for done, (name, scene) in enumerate(chosen.items(), 1):
            limits[name] = references(scene, max(extent.beads), session, [MAIN])[MAIN]
            points += _ours(name, scene, extent, session, limits[name])
            points += _asked(name, scene, extent.repeats, session, limits[name])
            for peer in others:
                if not installed(peer) or (peer.laws is not None and scene.law not in peer.laws):
                    continue
                found, speeds = climbed(peer, name, scene, quick, extent.repeats, limits[name])
                points += found
                if peer.name == "finite elements" and len(speeds) >= 2:
                    (coarse, first), (fine, last) = list(speeds.items())[-2:]
                    order = 1 if scene.string.wave.shocks else 2
                    second[name] = richardson_limit(coarse, first, fine, last, order) / limits[name].values[0] - 1.0
            if progress:
                progress(done, len(chosen))
    return Comparison(tuple(points), chosen, limits, others, second)


def _ours(name: str, scene: Scene, extent: Extent, session: Session, limit: Reference) -> list[Point]:
    """The production runs, their pairs, the plans, and the other methods that solve the same problem."""
    from beadband.studies.pareto.repeats import measured, plans

    compared: list[Method] = [*methods(scene, extent), *plans(scene)]
    compared = [one for one in compared if one.own == MAIN and one.variant not in _SLOW]
    measured(compared[:1], session, repeats=1)  # what only the first run of a session pays
    rows = measured(compared, session, repeats=extent.repeats)
    rows = with_errors([*rows, *pairs(rows)], {MAIN: limit})
    return [_of_row(name, row, limit) for row in rows]


def _of_row(name: str, row: Row, limit: Reference) -> Point:
    tool = {"beads": OURS, "plan": PLAN, "pair": PAIR}.get(row.family, OTHER)
    floors = [limit.relative(i) for i in range(3)]
    first, second, third = (max(bound, floor) for bound, floor in zip(row.error_bounds, floors, strict=True))
    return Point(
        name,
        tool,
        row.level,
        row.errors,
        (first, second, third),
        row.least_s,
        row.whole_s,
        row.outcome.code,
        row.outcome.brief if row.outcome.code != OK else "",
        f"{row.family}: {row.variant}, {row.beads} beads",
    )


def _asked(name: str, scene: Scene, repeats: int, session: Session, limit: Reference) -> list[Point]:
    """What `beadband ask` answers at each tolerance, in a warm process."""
    found = []
    for tolerance in TOLERANCES:
        wanted = replace(scene, tolerance=tolerance, purpose="speed")
        answers = [ask(wanted, "speed", session) for _ in range(repeats + 1)]
        best = min(answers[1:], key=lambda one: one.seconds)
        error = abs(best.value / limit.values[0] - 1.0)
        bound = max(error, limit.relative(0))
        unknown = math.nan
        found.append(
            Point(
                name,
                ASK,
                tolerance,
                (error, unknown, unknown),
                (bound, unknown, unknown),
                best.seconds,
                best.seconds,
                OK if best.within_tolerance else "ladder-ends",
                "" if best.within_tolerance else f"states {best.error / abs(best.value):.2g} and says so",
                best.model if not best.runs else f"{best.model}, {best.runs} runs, {best.beads} beads at most",
            )
        )
    return found


def climbed(
    peer: Peer, name: str, scene: Scene, quick: bool, repeats: int, limit: Reference
) -> tuple[list[Point], dict[int, float]]:
    """The ladder of a peer on a scene, coarse to fine, and V by elements; a failure is a point without an error."""
    answers: dict[int, tuple[Answer, Trace]] = {}
    failures: dict[int, Outcome] = {}
    ladder = peer.quick if quick else peer.ladder
    _attempt(peer, scene, ladder[0])  # what only the first run of a process pays
    for elements in ladder:
        for _ in range(repeats):
            one = _attempt(peer, scene, elements)
            if isinstance(one, Outcome):
                failures[elements] = one
                break
            before = answers.get(elements, one)
            answers[elements] = (one[0], min(before[1], one[1], key=lambda trace: trace.whole_s))
            if one[1].whole_s > _LONGEST_S:
                break
    errors = {elements: limit.errors(answer) for elements, (answer, _) in answers.items()}
    common = _where_to(answers, errors, limit)
    points = []
    for elements in ladder:
        if elements in failures:
            outcome = failures[elements]
            points.append(Point(name, peer.name, elements, status=outcome.code, reason=outcome.brief))
            continue
        trace = answers[elements][1]
        first, second, third = (
            max(limit.relative(i), *(error[i] for finer, error in errors.items() if finer >= elements))
            for i in range(3)
        )
        points.append(
            Point(
                name,
                peer.name,
                elements,
                errors[elements],
                (first, second, third),
                trace.loop_s,
                trace.whole_s,
                common.code,
                common.brief if common.code != OK else "",
                f"{elements} elements",
            )
        )
    return points, {elements: answer.speed_m_s for elements, (answer, _) in answers.items()}


def _attempt(peer: Peer, scene: Scene, elements: int) -> tuple[Answer, Trace] | Outcome:
    try:
        trace = peer.run(scene, elements)
        return answer_of(scene, trace), trace
    except BeadbandError as error:
        return outcome_of(error)
    except Exception as error:  # noqa: BLE001  a peer raises what it likes; its failure is listed
        return Outcome("run-failed", f"{type(error).__name__}: {' '.join(str(error).split())[:200]}")


def _where_to(answers: dict[int, Any], errors: dict[int, Any], limit: Reference) -> Outcome:
    """Whether the two finest runs have settled away from the reference."""
    if len(answers) < 2:
        return Outcome()
    before, last = list(answers)[-2:]
    error = errors[last][0]
    moved = abs(answers[last][0].speed_m_s - answers[before][0].speed_m_s) / limit.values[0]
    if error > 2e-3 and moved < STALLED * error:
        return noticed(OTHER_LIMIT, "stalled-off-limit", change=moved, value=error)
    return Outcome()


def tools(points: Sequence[Point]) -> list[str]:
    """Names of the tools in the order in which they come."""
    return list(dict.fromkeys(point.tool for point in points))
