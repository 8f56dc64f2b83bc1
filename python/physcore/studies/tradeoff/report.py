"""Reports of a trade-off: a table, an explanation, and a document of plain values."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict
from html import escape
from typing import Any

from physcore.markup import text_table
from physcore.numerics.integrators import Integrator
from physcore.studies.tradeoff.labels import differences, labels, parameters
from physcore.studies.tradeoff.reference import Reference
from physcore.studies.tradeoff.restarts import Windows
from physcore.studies.tradeoff.result import CERTAIN, Measurements, Row

KINDS = {
    "trajectory": "the largest distance of any point from the reference over the whole run",
    "restart": "the largest distance at the end of short windows that start on the reference: trajectories are chaotic",
    "until the horizon": "the largest distance from the reference until its trajectories are lost to chaos",
}


def machine(simd: str) -> dict[str, Any]:
    """Description of the machine and the software."""
    from importlib.metadata import version

    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "vector instructions": simd,
        "system": platform.platform(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "physcore": version("physcore"),
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


FRONT = 6
"""Largest number of rows of a summary."""


def summary(trade: Measurements) -> str:
    """The table of the Pareto front, the fastest row first, evenly thinned out to `FRONT` rows."""
    front = trade.front
    shown = min(len(front), FRONT)
    rows = [front[round(index * (len(front) - 1) / max(shown - 1, 1))] for index in range(shown)]
    heading, *lines = table(trade, rows).splitlines()[: 2 + shown]
    remark = f"{shown} of {len(trade.rows)} rows, on the Pareto front; print shows all"
    return "\n".join([heading, *lines, *_lower_orders(trade), remark])


def table(trade: Measurements, rows: Sequence[Row] | None = None) -> str:
    """The table of rows, by default all. Marks: * on the Pareto front, ~ error near the reference's uncertainty,
    ? noisy time.
    """
    front = set(map(id, trade.front))
    units, lines = trade.scene.units, [_header(trade, "")]
    lines += [*(_cells(row, id(row) in front) for row in (trade.rows if rows is None else rows))]
    text = text_table(lines, {0, 1, 3, len(lines[0]) - 1})
    return "\n".join(
        [
            f"Error: {KINDS[trade.measure]}; {trade.duration:g}{units.suffix('s')} simulated",
            *text,
            "* on the Pareto front   ~ below ten times the reference's uncertainty   "
            "? the median time is 5 % above the least",
            *_lower_orders(trade),
        ]
    )


def _lower_orders(trade: Measurements) -> list[str]:
    """A line on the integrators whose order in this scene is below their nominal order; none without them."""
    lowered = {row.label: (row.order, row.integrator.order) for row in trade.rows if row.order < row.integrator.order}
    words = [f"{label} ({order}, not {nominal})" for label, (order, nominal) in lowered.items()]
    return [f"of lower order in this scene: {', '.join(words)}"] if words else []


def html(trade: Measurements) -> str:
    """The table as HTML, for notebooks."""
    front = set(map(id, trade.front))
    lines = [_cells(row, id(row) in front) for row in trade.rows]
    units = trade.scene.units
    top = "".join(f"<th>{escape(head)}</th>" for head in _header(trade, "precision"))
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in line)}</tr>" for line in lines)
    caption = f"Error: {KINDS[trade.measure]}; {trade.duration:g}{units.suffix('s')} simulated. * on the Pareto front"
    return f"<table><caption>{escape(caption)}</caption><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _header(trade: Measurements, precision: str) -> list[str]:
    """The headings of the columns of `_cells`."""
    first, units = trade.rows[:1], trade.scene.units
    compared = [name for row in first for name in row.methods]
    compared += ["resolution" for row in first if row.resolution is not None]
    last = ["seconds", "evaluations", units.label("error", "m"), "energy drift", "status"]
    return ["", "integrator", units.label("dt", "s"), precision, *compared, *last]


def _cells(row: Row, on_front: bool) -> list[str]:
    """The cells of a row of the table."""
    return [
        "*" if on_front else "",
        row.label,
        f"{row.dt:.4g}",
        row.precision,
        *map(differences, row.methods.values()),
        *([f"{row.resolution:g}"] if row.resolution is not None else []),
        f"{row.seconds:.3g}{'?' if row.noisy else ' '}",
        str(row.evaluations),
        f"{_error(row)}{' ' if row.certain else '~'}",
        f"{row.energy_drift:.1e}" if math.isfinite(row.energy_drift) else "—",
        row.status,
    ]


def _error(row: Row) -> str:
    return f"{row.total_error:.2e}" if math.isfinite(row.error) else "—"


def explanation(trade: Measurements) -> str:
    """An explanation of the results, of their reference and of their reliability."""
    parts = [_on_chaos(trade), _on_reference(trade), _on_front(trade), _on_divergence(trade), _on_precision(trade)]
    parts += [*_lower_orders(trade), _on_prediction(trade), _on_noise(trade), *trade.notes]
    return "\n".join(part for part in parts if part)


def _on_chaos(trade: Measurements) -> str:
    chaos, second = trade.chaos[-1], trade.scene.units.suffix("s")
    if not chaos.chaotic:
        return (
            f"A twin that starts 1e-10 off moves {chaos.growth[-1]:.2g} times as far off within "
            f"{trade.duration:g}{second}: trajectories can be compared, and are."
        )
    how = (
        "Errors are therefore taken over short windows that start on a reference, and averages over ensembles of "
        "neighboring runs show whether a method is biased."
        if trade.measure == "restart"
        else "Errors are therefore taken until then; observe something that chaos does not touch to compare whole runs."
    )
    return (
        f"The motion is chaotic: neighbors part by e every {1.0 / chaos.exponent:.3g}{second}, and after "
        f"{chaos.horizon:.3g}{second} no trajectory means anything. {how}"
    )


def _on_reference(trade: Measurements) -> str:
    experiment, reference = trade.experiments[-1], trade.references[-1]
    names = labels([*(row.integrator for row in trade.rows), *_integrators(reference)])
    meter, dt = experiment.scene.units.suffix("m"), experiment.dt(reference.choice)
    name = f"{names[reference.choice.integrator]} with dt = {dt:.3g}{experiment.scene.units.suffix('s')}"
    if not isinstance(reference, Reference):
        doubt = "" if reference.agrees else ", because a method of another family is that far from them"
        return f"The reference windows are those of {name}, uncertain by {reference.uncertainty:.1e}{meter}{doubt}."
    order = f"observed order {reference.order:.2f}" if math.isfinite(reference.order) else "no order to be seen"
    how = "extrapolated" if reference.extrapolated else "not extrapolated, because its errors do not follow its order"
    text = f"The reference is {name} ({order}, {how}), uncertain by {reference.uncertainty:.1e}{meter}"
    if reference.check is None:
        return f"{text}; no method of another family can compute this scene, so nothing has checked it."
    other = names[reference.check.integrator]
    if reference.agrees:
        return f"{text}; {other} agrees with it to {reference.disagreement:.1e}{meter}."
    return (
        f"{text}: that is how far {other} is from it, which is more than their own uncertainties allow. Do not trust "
        f"errors below {CERTAIN * reference.uncertainty:.1e}{meter}."
    )


def _integrators(reference: Reference | Windows) -> list[Integrator]:
    """The integrators of a reference and of its check."""
    check = reference.check if isinstance(reference, Reference) else None
    return [choice.integrator for choice in (reference.choice, check) if choice is not None]


def _on_front(trade: Measurements) -> str:
    front = trade.front
    if not front:
        return "No row came to an end that can be used."
    if len(front) == 1:
        return f"One row is both the fastest and the most accurate: {front[0]}."
    return f"The fastest is {front[0]}; the most accurate is {front[-1]}; {len(front)} rows are on the Pareto front."


def _on_divergence(trade: Measurements) -> str:
    blown = [row for row in trade.rows if row.status == "diverged"]
    biased = [row for row in trade.rows if row.status == "biased" and row.bias is not None]
    parts, second = [], trade.scene.units.suffix("s")
    if blown:
        least = {_name(row): min(other.dt for other in blown if _name(other) == _name(row)) for row in blown}
        listed = "; ".join(f"{name} down to dt = {dt:.3g}{second}" for name, dt in least.items())
        parts.append(f"Blew up: {listed}.")
    if biased:
        listed = "; ".join(
            f"{_name(row)} at dt = {row.dt:.3g}{second}, whose {row.bias.quantity} is off by {row.bias.relative:+.1%} "
            f"± {row.bias.interval:.1%}"
            for row in biased
            if row.bias is not None
        )
        parts.append(f"Biased: {listed}.")
    return " ".join(parts)


def _name(row: Row) -> str:
    return f"{row.label} {row.precision}"


def _on_precision(trade: Measurements) -> str:
    """A sentence on the accuracy limit of single precision."""
    single = [row for row in trade.rows if row.precision == "f32" and row.status == "ok"]
    double = [row for row in trade.rows if row.precision == "f64" and row.status == "ok"]
    if not single or not double:
        return ""
    meter = trade.scene.units.suffix("m")
    floor, best = min(row.total_error for row in single), min(row.total_error for row in double)
    if floor <= 2.0 * best:
        return f"Single precision gets as far as double, to {floor:.1e}{meter}."
    return f"Single precision gets no closer than {floor:.1e}{meter}, double to {best:.1e}{meter}."


def _on_prediction(trade: Measurements) -> str:
    misses = [
        max(row.error / row.prediction.error, row.prediction.error / row.error)
        for row in trade.held_out
        if row.prediction is not None and row.error > 0.0 and row.prediction.error > 0.0 and math.isfinite(row.error)
    ]
    if not misses:
        return ""
    return (
        f"{len(misses)} of the rows {'was' if len(misses) == 1 else 'were'} predicted from those around before being "
        f"run; the errors were missed by a factor of {max(misses):.2f} at most."
    )


def _on_noise(trade: Measurements) -> str:
    noisy = sum(row.noisy for row in trade.rows)
    if not noisy:
        return ""
    return (
        f"Of {len(trade.rows)} times {noisy} are noisy (median more than 5 % above the least of their repetitions): "
        "where rows are close, compare evaluations."
    )


def document(trade: Measurements) -> dict[str, Any]:
    """All results as plain values."""
    return {
        "duration": trade.duration,
        **({} if trade.scene.units.is_si else {"units": asdict(trade.scene.units)}),
        "error": KINDS[trade.measure],
        "seed": trade.seed,
        "machine": trade.machine,
        "chaos": [
            {"chaotic": chaos.chaotic, "exponent": chaos.exponent, "horizon": _plain(chaos.horizon)}
            for chaos in trade.chaos
        ],
        "references": [
            {
                **_method(reference.choice.integrator),
                "dt": experiment.dt(reference.choice),
                "uncertainty": _plain(reference.uncertainty),
                **(
                    {"order": _plain(reference.order), "extrapolated": reference.extrapolated}
                    | {"disagreement": reference.disagreement, "agrees": reference.agrees}
                    if isinstance(reference, Reference)
                    else {}
                ),
            }
            for experiment, reference in zip(trade.experiments, trade.references, strict=True)
        ],
        "notes": list(trade.notes),
        "rows": [
            {
                **{name: _plain(value) for name, value in asdict(row).items() if name != "units"},
                **_method(row.integrator),
                "fluids": None if row.fluids is None else differences(row.fluids),
                "contacts": None if row.contacts is None else differences(row.contacts),
            }
            for row in trade.rows
        ],
    }


def _method(integrator: Integrator) -> dict[str, Any]:
    """An integrator as plain values."""
    return {"integrator": type(integrator).__name__, "parameters": parameters(integrator)}


def _plain(value: Any) -> Any:
    """A value with None in place of numbers that JSON cannot represent."""
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
