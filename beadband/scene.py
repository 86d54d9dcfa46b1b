"""A scene: which band is pulled how far and how, by which law, and how well the answer must be known."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace

from beadband.band import PROPERTIES, Band, band_of
from beadband.errors import UsageError, explain
from beadband.law import LAWS, Law, law_of
from beadband.strand import Strand
from beadband.wedge import StringLimit, Wedge, published_ratio, string_limit, wave_speeds, wedge_of

CHOICES = {
    "law": tuple(LAWS),
    "until": ("release", "launch"),
    "for": ("curvature", "speed"),
    "bending_modulus": ("table", "rest"),
    "finger": ("stays", "clears"),
}
COUNTS = {"beads": 2_000_000, "frames": 100_000, "steps": 2_000_000_000, "rear_steps": 2_000_000_000}
"""Whole numbers of a scene, and the most that each may be."""
PLANNED = ("beads", "timestep_s", "loss_time_s", "frames", "steps", "rear_steps")
"""What a plan chooses where a scene leaves it open."""


@dataclass(frozen=True)
class Scene:
    """A release, as asked for; None where the plan may choose.

    Build one with :func:`scene_of`, which checks it. Lengths in m, times in s, moduli in Pa.
    """

    band: Band
    strain: float = 0.476
    half_angle_deg: float = 14.0
    law: str = "mooney-rivlin"
    until: str = "release"
    tolerance: float = 0.005
    purpose: str = "curvature"
    bending_modulus: str = "table"
    bending_scale: float = 1.0
    """Factor on EI: 0 leaves bending out."""
    beads: int | None = None
    timestep_s: float | None = None
    loss_time_s: float | None = None
    frames: int | None = None
    """Frames of the whole ring after the first."""
    steps: int | None = None
    rear_steps: int | None = None
    """Steps between frames of the rear; ``steps`` and this one are the plan's, kept so that a run can be repeated."""
    finger: str = "stays"
    """Of a launch: whether the finger stays, or is taken away once it carries nothing."""
    flight_s: float = 0.0
    """Of a launch whose finger clears: time that the band flies on after its rear has come to the finger's place."""
    planned: tuple[str, ...] = ()
    """Which of the values from ``beads`` on were chosen by a plan."""

    @property
    def half_angle_rad(self) -> float:
        return math.radians(self.half_angle_deg)

    @property
    def material(self) -> Law:
        return law_of(self.law, self.band)

    @property
    def bending_stiffness_n_m2(self) -> float:
        """EI, from the table's E or from E0."""
        modulus = self.band.modulus_pa if self.bending_modulus == "table" else self.band.rest_modulus_pa
        return self.bending_scale * modulus * self.band.second_moment_m4

    @property
    def bending_diffusivity_m2_s(self) -> float:
        """a_b = sqrt(EI/(density A)); the same for any number of beads."""
        return self.strand(1).bending_diffusivity_m2_s

    @property
    def wedge(self) -> Wedge:
        return wedge_of(self.band.circumference_m, self.strain, self.half_angle_rad)

    @property
    def string(self) -> StringLimit:
        return string_limit(self.material, self.band.density_kg_m3, self.strain, self.half_angle_rad)

    @property
    def published_ratio(self) -> float:
        return published_ratio(self.strain, self.half_angle_rad)

    def wave_speeds(self, front_speed_m_s: float) -> dict[str, float]:
        return wave_speeds(self.band, front_speed_m_s, self.strain, self.half_angle_rad)

    def strand(self, beads: int) -> Strand:
        """What a chain of so many beads must be made of."""
        band = self.band
        return Strand(
            law=self.material,
            spacing_m=band.circumference_m / beads,
            area_m2=band.area_m2,
            density_kg_m3=band.density_kg_m3,
            modulus_pa=band.modulus_pa,
            bending_stiffness_n_m2=self.bending_stiffness_n_m2,
        )

    def with_beads(self, beads: int) -> Scene:
        """The same scene with another number of beads, and all that a plan chose for it left open again.

        A loss time of the user's is physics and stays; a numerical one goes with the mesh.
        """
        return replace(
            self,
            beads=beads,
            timestep_s=None,
            loss_time_s=None if "loss_time_s" in self.planned else self.loss_time_s,
            frames=None,
            steps=None,
            rear_steps=None,
            planned=(),
        )

    def as_dict(self) -> dict[str, object]:
        """The scene under the names that scene.toml and results.json use, complete with the band's properties."""
        values: dict[str, object] = {
            "band": self.band.name,
            "strain": self.strain,
            "half_angle_deg": self.half_angle_deg,
            "law": self.law,
            "until": self.until,
            "tolerance": self.tolerance,
            "for": self.purpose,
            "bending_modulus": self.bending_modulus,
            "bending_scale": self.bending_scale,
            "beads": self.beads,
            "timestep_s": self.timestep_s,
            "loss_time_s": self.loss_time_s,
            "frames": self.frames,
            "steps": self.steps,
            "rear_steps": self.rear_steps,
            "planned": list(self.planned) or None,
        }
        if self.until == "launch":
            values.update({"finger": self.finger, "flight_s": self.flight_s})
        properties = asdict(self.band)
        values.update({key: properties[key] for key in PROPERTIES})
        return {key: value for key, value in values.items() if value is not None}


KEYS = (
    "band",
    "strain",
    "half_angle_deg",
    *CHOICES,
    "tolerance",
    "bending_scale",
    "timestep_s",
    "loss_time_s",
    "flight_s",
    *COUNTS,
    "planned",
    *PROPERTIES,
)
"""Names under which :func:`scene_of` takes its values."""


def scene_of(values: dict[str, object]) -> Scene:
    """Check the values of a scene (see :data:`KEYS`) and put them together; UsageError for what has no answer."""
    for key in values:
        if key not in KEYS:
            raise UsageError(explain("unknown scene option", repr(key), ", ".join(KEYS), "correct its name"))
    overrides = {key: _number(values, key) for key in PROPERTIES if key in values}
    name = values.get("band", "III")
    band = band_of(name if isinstance(name, str) else repr(name), overrides)
    chosen: dict[str, str] = {}
    for key, allowed in CHOICES.items():
        value = values.get(key)
        if value is None:
            continue
        if value not in allowed:
            raise UsageError(explain(f"unknown {key}", repr(value), " or ".join(allowed), f"mend {_flag(key)}"))
        chosen["purpose" if key == "for" else key] = str(value)
    numbers = {
        key: _number(values, key)
        for key in ("strain", "half_angle_deg", "tolerance", "bending_scale", "timestep_s", "loss_time_s", "flight_s")
        if values.get(key) is not None
    }
    counts = {key: _count(values, key, most) for key, most in COUNTS.items() if values.get(key) is not None}
    scene = Scene(band=band, planned=_planned(values), **chosen, **numbers, **counts)  # type: ignore[arg-type]
    _check(scene)
    return scene


def _number(values: dict[str, object], key: str) -> float:
    value = values[key]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise UsageError(explain(f"{key} is not a number", repr(value), "a number", f"mend {_flag(key)}"))
    return float(value)


def _count(values: dict[str, object], key: str, most: int) -> int:
    value = values[key]
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= most:
        raise UsageError(
            explain(f"{key} is out of range", repr(value), f"a whole number from 1 to {most}", f"mend {_flag(key)}")
        )
    return value


def _planned(values: dict[str, object]) -> tuple[str, ...]:
    names = values.get("planned") or []
    if not isinstance(names, list) or not all(name in PLANNED for name in names):
        raise UsageError(
            explain("planned lists what is no choice of a plan", repr(names), ", ".join(PLANNED), "remove the line")
        )
    return tuple(names)


def _flag(key: str) -> str:
    for unit in ("_kg_m3", "_deg", "_pa", "_m", "_s"):
        key = key.removesuffix(unit)
    return "--" + key.replace("_", "-")


def _within(name: str, value: float, low: float, high: float, allowed: str, flag: str) -> None:
    if not low < value < high:  # also catches NaN
        raise UsageError(explain(name, value, allowed, f"mend {flag}"))


def _check(scene: Scene) -> None:
    """Refuse what has no answer, with the number that decides."""
    _within("the strain is out of range", scene.strain, 0.0, 10.0, "above 0 and below 10", "--strain")
    _within(
        "the wedge's half-angle is out of range",
        scene.half_angle_deg,
        0.0,
        90.0,
        "above 0 and below 90 degrees",
        "--half-angle",
    )
    _within("the tolerance is out of range", scene.tolerance, 0.0, 0.5, "above 0 and below 0.5", "--tolerance")
    if not 0.0 <= scene.bending_scale < math.inf:
        raise UsageError(
            explain(
                "the factor on the bending stiffness is out of range",
                scene.bending_scale,
                "0 (no bending) or more",
                "mend --bending-scale",
            )
        )
    if scene.timestep_s is not None:
        _within("the time step is out of range", scene.timestep_s, 0.0, math.inf, "above 0 s", "--timestep")
    if scene.loss_time_s is not None and not 0.0 <= scene.loss_time_s < math.inf:
        raise UsageError(explain("the loss time is out of range", scene.loss_time_s, "0 s or more", "mend --loss-time"))
    if not 0.0 <= scene.flight_s < math.inf:
        raise UsageError(explain("the flight's time is out of range", scene.flight_s, "0 s or more", "mend --flight"))
    if scene.until != "launch" and (scene.finger, scene.flight_s) != ("stays", 0.0):
        given = f"--finger {scene.finger} --flight {scene.flight_s:g}"
        raise UsageError(explain("a release has no flight", given, "both with a launch", "add --until launch"))
    if scene.flight_s > 0.0 and scene.finger != "clears":
        given = f"--flight {scene.flight_s:g} with a finger that stays"
        raise UsageError(explain("the band can't fly on through the finger", given, "0 s", "add --finger clears"))
    closing = (1.0 + scene.strain) * math.sin(scene.half_angle_rad)
    if closing >= 1.0:
        raise UsageError(
            explain(
                "the wedge is too wide for its strain",
                f"(1 + strain) sin(half-angle) = {closing:.4g}",
                "below 1",
                "lower --strain or --half-angle",
            )
        )
    _check_material(scene)


def _check_material(scene: Scene) -> None:
    scene.band.rest_speed_m_s  # noqa: B018  refuses a band that is soft at rest: every result is divided by it
    peak = scene.material.peak_stretch()
    if peak is not None and 1.0 + scene.strain >= peak:
        raise UsageError(
            explain(
                f"band {scene.band.name} can't be held at this strain: its tension peaks at a stretch of {peak:.4g} "
                "and falls beyond, so a uniform stretch does not exist",
                f"strain {scene.strain:g}",
                f"below {peak - 1.0:.4g}",
                "lower --strain or use --law linear",
            )
        )
