"""The table of results: the file keeps its schema, the documents are current, and one entry is enough."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import beadband
from beadband import observables
from beadband.analysis.fits import Measured
from beadband.cli import main
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.reporting import summary
from beadband.runs import folder as files
from beadband.runs import rear_run
from beadband.runs.results import Run

DOCS = Path(__file__).parents[2] / "docs"
KINDS: dict[str, type | tuple[type, ...]] = {
    **{"number": (int, float), "integer": int, "string": str, "boolean": bool},
    **{"object": dict, "array": list, "null": type(None)},
}


def violations(value: Any, schema: dict[str, Any], place: str = "") -> list[str]:
    """Where a value departs from a schema, as far as ours go: types, required keys, properties and items."""
    kinds = schema.get("type", list(KINDS))
    kinds = [kinds] if isinstance(kinds, str) else kinds
    fits = any(isinstance(value, KINDS[kind]) for kind in kinds)
    if not fits or (isinstance(value, bool) and "boolean" not in kinds):
        return [f"{place} is no {' or '.join(kinds)}"]
    if isinstance(value, list):
        return [found for one in value for found in violations(one, schema.get("items", {}), f"{place}[]")]
    if not isinstance(value, dict):
        return []
    known = schema.get("properties", {})
    found = [f"{place}.{name} is missing" for name in schema.get("required", []) if name not in value]
    for name in value.keys() & known.keys():
        found += violations(value[name], known[name], f"{place}.{name}")
    return found


@pytest.fixture
def height() -> Iterator[str]:
    """A result of one's own, in one place."""

    @observables.observable("rise.tip_way_m", "way of the tip", unit="m", error=True)
    def tip_way(run: Any) -> Measured:
        return Measured(float(run.rear.tip_x_m[-1]), 1e-5)

    yield "rise.tip_way_m"
    observables.forget("rise.tip_way_m")


def test_results_keep_the_published_schema(default_run: tuple[Run, Path]) -> None:
    schema = json.loads((DOCS / "results.schema.json").read_text())
    values = json.loads((default_run[1] / files.RESULTS).read_text())
    assert violations(values, schema) == []
    assert values["schema_version"] == observables.SCHEMA_VERSION
    assert len(values["warning_codes"]) == len(values["warnings"]) == 1
    launch = beadband.run(until="launch", beads=120).as_dict()
    assert violations(launch, schema) == []
    assert violations({**values, "alpha": None, "plan": {}}, schema)
    assert set(values) | set(launch) <= set(schema["properties"])


def test_columns_of_a_sweep_come_from_the_table() -> None:
    found = rear_run.rear_run(plan_of(scene_of({}), "leg"))
    row = observables.row(found)
    assert set(row) <= {one.name for one in observables.columns()}
    assert row["rebound_speed_error_m_s"] == found.speed.error
    assert row["alpha_rest_error"] == found.alphas["rest"].error
    assert row["within_tolerance"] == "yes"
    assert len({one.name for one in observables.columns()}) == len(observables.columns())


def test_a_result_of_ones_own_is_added_in_one_place(
    height: str, default_run: tuple[Run, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    run, folder = default_run
    exact = float(run.rear.tip_x_m[-1])
    assert run.as_dict()["rise"] == {"tip_way_m": exact, "tip_way_error_m": 1e-5}
    assert main(["analyze", str(folder), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rise"]["tip_way_m"] == pytest.approx(exact)
    assert dict(summary.result_rows(run.as_dict()))["way of the tip"] == f"{Measured(exact, 1e-5)} m"
    assert {"rise_tip_way_m", "rise_tip_way_error_m"} <= {one.name for one in observables.columns()}
    assert observables.row(run)["rise_tip_way_m"] == exact
    assert "| `rise.tip_way_m`, `rise.tip_way_error_m` | m | way of the tip" in observables.as_markdown()
    assert "tip_way_m" in observables.json_schema()["properties"]["rise"]["properties"]
    with pytest.raises(ValueError, match="already"):
        observables.observable(height, "again")(lambda run: 1.0)


def test_every_observable_says_what_it_is() -> None:
    for one in observables.table():
        assert one.sentence
        assert one.kind in ("number", "series") or not one.unit
    assert observables.error_key("rebound_speed_m_s") == "rebound_speed_error_m_s"
    assert observables.error_key("efficiency") == "efficiency_error"
