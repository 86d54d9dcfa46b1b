"""The findings in words: one sentence for each, its wording chosen from the numbers by stated thresholds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

from beadband.studies.pareto.outcomes import counted

Values = Mapping[str, Any]

_SAME_COST = 1.2
"""Ratio of costs up to which two count as equal."""
_SAME_ERROR = 1.25
"""Ratio of errors up to which two count as equal."""
_SAME_SPEED = 1e-3
"""Relative change of V up to which a variant counts as the same."""
_BUSY = 0.5
"""Load average of other work above which no second core was free to be measured."""
_WINDOWS = {"curvature_01": "around 0.1 t_f", "curvature_03": "around 0.3 t_f"}


def sentences(findings: Iterable[Values]) -> list[str]:
    """The findings of frontier.json as sentences, those of one topic together."""
    topics = groupby(findings, key=lambda one: one["topic"])
    return [" ".join(sentence(one) for one in those) for _, those in topics]


def sentence(finding: Values) -> str:
    """One finding as a sentence."""
    text = SENTENCES[finding["code"]](finding["values"])
    return f"{text[0].upper()}{text[1:]}."


def method_name(family: str, variant: str, step_share: float = 1.0) -> str:
    """A method as a sentence names it."""
    if family == "step":
        return f"a step of {step_share:.2g} of the limit"
    names = {"beads": "production", "pair": "Richardson pair", "integrator": f"rRESPA, {variant}"}
    return names.get(family, f"{family}: {variant}")


def digits(value: float) -> str:
    """A number with two digits, or without decimals."""
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def percent(value: float) -> str:
    """A share as a percentage with two digits."""
    return f"{100.0 * value:.2g} %"


def count(value: float) -> str:
    """A count of beads, its thousands separated."""
    return f"{round(value):,}".replace(",", " ")


def span(values: Sequence[float], unit: str = "times") -> str:
    """A range, or one number where both ends round to it."""
    low, high = map(digits, values)
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"


def _levels(levels: Sequence[Values]) -> str:
    reached = [
        f"to {percent(one['error'])} after {digits(1e3 * one['seconds'])} ms ({one['beads']} beads, "
        f"{method_name(one['family'], one['variant'], one['step_share'])})"
        for one in levels
        if "seconds" in one
    ]
    missed = [percent(one["error"]) for one in levels if "seconds" not in one]
    text = f"is accurate {', '.join(reached)}" if reached else ""
    return " and ".join(
        [text] * bool(text) + ([f"does not reach {', '.join(missed)} with any method"] if missed else [])
    )


def _speed(values: Values) -> str:
    return f"on one leg V {_levels(values['levels'])}"


def _ring(values: Values) -> str:
    error = values["error"]
    if error > _SAME_ERROR:
        accuracy = f"is less accurate (median error {error:.2g} times as large)"
    elif error < 1.0 / _SAME_ERROR:
        accuracy = f"is more accurate (median error {error:.2g} times as large)"
    else:
        accuracy = "is no more accurate"
    return f"the whole ring with all its files takes {span(values['cost'])} as long at equal beads and {accuracy}"


def _curvature(values: Values) -> str:
    parts = [f"{_WINDOWS[name]} {_levels(levels)}" for name, levels in values["levels"].items()]
    return f"the windowed tip curvature {'; that '.join(parts)}"


def _curvature_beads(values: Values) -> str:
    low, high = values["ratio"]
    need = "as many beads as V" if high <= _SAME_COST else f"{span((low, high))} as many beads as V"
    if high < 1.0 / _SAME_COST:
        need = f"fewer beads than V ({span((low, high))} as many)"
    return f"for {percent(values['error'])} the cheapest method for the tip curvature needs {need}"


def _plan_keeps(values: Values) -> str:
    kept, plans, curvature = values["kept"], values["plans"], values["curvature"]
    share = f"all {plans}" if kept == plans else f"none of {plans}" if kept == 0 else f"{kept} of {plans}"
    text = f"the plan keeps V within its tolerance in {share} cases"
    if curvature is None:
        return text
    within = "always" if curvature[1] <= 1.0 else "never" if curvature[0] > 1.0 else "not always"
    large = f"{span(curvature)} as large"
    return f"{text}; in the plans for the curvature its error is {within} within the tolerance ({large})"


def _plan_costs(values: Values) -> str:
    own, every = ("an unknown multiple" if values[key] is None else span(values[key]) for key in ("own", "any"))
    return (
        f"its integration takes {own} as long as the cheapest production run with the same error bound, and {every} as "
        "long as the cheapest run of any method, chosen in hindsight"
    )


def _plan_seconds(values: Values) -> str:
    parts = [
        ", ".join(f"{digits(1e3 * seconds)} ms at {percent(float(error))}" for error, seconds in times.items())
        + f" for the {purpose}"
        for purpose, times in values.items()
    ]
    return f"by tolerance, its relaxation and integration together take {'; '.join(parts)}"


def _effect(what: str, values: Values) -> str:
    change, cost = values["change"], values["cost"]
    same_speed, same_cost = change <= _SAME_SPEED, 1.0 / _SAME_COST <= cost <= _SAME_COST
    speed = f"V (by at most {percent(change)} with {values['beads']} beads)"
    time = f"the time (median {cost:.2f} times as long)"
    if same_speed and same_cost:
        return f"{what} hardly changes {speed} or {time}"
    if same_speed != same_cost:
        return f"{what} changes {time if same_speed else speed}, but hardly {speed if same_speed else time}"
    return f"{what} changes {speed} and {time}"


def _expression(values: Values) -> str:
    low, high = values["cost"]
    if high <= _SAME_COST:
        verb = "costs nothing extra" if low >= 1.0 / _SAME_COST else "saves time"
        return f"an expression for the law (lepton) {verb}: it takes {span((low, high))} as long"
    return f"an expression for the law (lepton) takes {span((low, high))} as long as its table"


def _respa_gain(values: Values) -> str:
    gain = values["gain"]
    if gain is None:
        return "no run of rRESPA has an error similar to that of Verlet's method"
    best = f"{gain:.2g} times as fast ({values['variant']}, {values['beads']} beads)"
    if gain <= _SAME_COST:
        return f"at a similar error rRESPA gains nothing: at best it is {best}"
    return f"at a similar error rRESPA is at best {best}"


def _respa_failures(values: Values) -> str:
    if not values["failed"]:
        return f"none of its {values['runs']} runs failed"
    codes = [code for code, number in values["failed"].items() for _ in range(number)]
    return (
        f"of its {values['runs']} runs {len(codes)} failed ({counted(codes)}), from an outer step of "
        f"{values['from_step_share']:.2g} times the largest stable one of Verlet's method on"
    )


def _bead_step(values: Values) -> str:
    first, last = zip(values["beads"], values["ns"], strict=True)
    text = f"on one core a bead and step cost {first[1]:.0f} ns at {count(first[0])} beads"
    return text if first == last else f"{text} and {last[1]:.0f} ns at {count(last[0])}"


def _not_timed(values: Values) -> str:
    codes = [code for code, number in values["failed"].items() for _ in range(number)]
    return f"{values['way']} could not be timed ({counted(codes) or 'no time of one core to compare with'})"


def second_core_gain(values: Values) -> str:
    """From where on a second core pays, if it does."""
    start, (smallest, largest) = values["from"], values["beads"]
    if start is None:
        return f"{values['way']} do not pay up to {count(largest)} beads"
    if start <= smallest:
        return f"{values['way']} pay at every size from {count(smallest)} beads on"
    return f"{values['way']} pay from about {count(float(f'{start:.1g}'))} beads on"


def _second_core(values: Values) -> str:
    text = (
        f"{second_core_gain(values)}: at best {values['gain']:.2g} times as fast ({count(values['gain_beads'])} beads)"
    )
    if values["load"] > _BUSY:
        text += f", measured while other work was running (load average {values['load']:.1f})"
    return text


def _peers_compared(values: Values) -> str:
    cases, behind, legs = values["cases"], values["behind"], values["leg_ahead"]
    text = f"the same {values['scenes']} scenes were given to every tool in {values['runs']} runs"
    if values["failed"]:
        text += f", of which {values['failed']} failed ({values['failed_own']} of them variants of beadband's own)"
    if not cases:
        return f"{text}; no other program reached any of the tolerances"
    share = f"in all {cases}" if not behind else f"in {cases - behind} of {cases}"
    text += (
        f"; {share} cases of a scene and a tolerance that another program reaches, beadband reaches it in less time, "
        "by its plan or when it is asked"
    )
    if not behind:
        return text
    return text + (
        f". In the other {behind} the program's level, chosen in hindsight, is quicker than levels that are run until "
        f"the error is known; a leg of beadband chosen in hindsight is quicker than the program in {legs} of them"
    )


def _peer_verdict(values: Values) -> str:
    some = "" if values["scenes"] == values["of"] else f", which can be given {values['scenes']} of the scenes,"
    parts = []
    for level in values["levels"]:
        if not level["reached"]:
            continue
        ratios = [
            f"{name} {digits(level[key]['times_as_fast'][1])}"
            + (f", though beyond the tolerance on {level[key]['missed']}" if level[key]["missed"] else "")
            for key, name in (("plan", "the plan"), ("ask", "asking"))
            if key in level
        ]
        where = f"{percent(level['tolerance'])} on {level['reached']} of {level['tried']}"
        parts.append(f"{where} ({'; '.join(ratios)} times as fast in the median)" if ratios else where)
    never = [percent(level["tolerance"]) for level in values["levels"] if not level["reached"]]
    text = f"{values['peer']}{some}"
    if parts:
        text += f" reaches {', '.join(parts)}"
    if never:
        text += (", and does not reach " if parts else " does not reach ") + ", ".join(never)
    return text


def _peer_failures(values: Values) -> str:
    return f"{values['failed']} of its runs failed ({values['reason']})"


def _second_method(values: Values) -> str:
    return (
        f"on {values['scenes']} scenes the finite elements, extrapolated, agree with the reference to "
        f"{percent(values['median'])} in the median, {percent(values['most'])} at most (its own uncertainty is at most "
        f"{percent(values['uncertainty'])})"
    )


SENTENCES: dict[str, Callable[[Values], str]] = {
    "cost-of-speed": _speed,
    "whole-ring": _ring,
    "cost-of-curvature": _curvature,
    "curvature-beads": _curvature_beads,
    "curvature-unknown": lambda _: "the tip curvature is too uncertain in the finest runs to compare methods by it",
    "plan-keeps": _plan_keeps,
    "plan-costs": _plan_costs,
    "plan-seconds": _plan_seconds,
    "table-points": lambda values: _effect("the number of points of the bond table", values),
    "angle-form": lambda values: _effect("the form of the angle energy", values),
    "expression": _expression,
    "respa-gain": _respa_gain,
    "respa-failures": _respa_failures,
    "bead-step": _bead_step,
    "not-timed": _not_timed,
    "second-core": _second_core,
    "peers-compared": _peers_compared,
    "peer-verdict": _peer_verdict,
    "peer-failures": _peer_failures,
    "peer-absent": lambda values: f"{values['peer']} is not installed: {values['install']}",
    "peer-other-laws": lambda values: f"{values['peer']} takes {', '.join(values['laws'])} alone: no scene was for it",
    "second-method": _second_method,
}
"""The sentence of each finding, by its code."""
