"""Evidence as JSON values and back, for the cache: rationals are strings, a verdict says its kind.

`evidence_from` trusts nothing: anything that is not as `evidence_to` writes it is a ValueError.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.evidence.evidence import Evidence, PartResult, Rounding, Sensitivity
from haverify.evidence.network_run import Moment, NetworkRun
from haverify.evidence.run import Passage, Run, Step
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text

_VERDICTS: dict[str, type[Proved] | type[Refuted]] = {"proved": Proved, "refuted": Refuted}
_TEXTS = ("kind", "reason", "reached", "nearest", "next_step")
_SENSITIVITY = ("constant", "slope", "to_zero", "rounding")


def evidence_to(e: Evidence) -> dict[str, Any]:
    """The JSON value of an evidence without its `cells`, which many claims share."""
    return {
        "verdict": _verdict_to(e.verdict),
        "parts": [_part_to(p) for p in e.parts],
        "method": e.method,
        "certificate": e.certificate,
        "rounding": e.rounding
        and {"verdict": _verdict_to(e.rounding.verdict), "margin": _margin_to(e.rounding.margin)},
        "run": _run_to(e.run),
        "notes": list(e.notes),
        "witness": [list(w) for w in e.witness],
        "trace": _trace_to(e.trace),
        "flowpipe": e.flowpipe,
    }


def evidence_from(value: Any, cells: dict[str, dict[str, Any]]) -> Evidence:
    """The evidence that `evidence_to` wrote, with `cells` put back.

    Raises
    ------
    ValueError      if the value is anything else
    """
    try:
        return Evidence(
            verdict=_verdict_from(value["verdict"]),
            parts=tuple(_part_from(p) for p in value["parts"]),
            method=_text(value["method"]),
            certificate=_optional_dict(value["certificate"]),
            cells=cells,
            rounding=_rounding_from(value["rounding"]),
            run=_run_from(value["run"]),
            notes=_texts(value["notes"]),
            witness=tuple((_text(name), _text(given)) for name, given in value["witness"]),
            trace=_trace_from(value["trace"]),
            flowpipe=_optional_dict(value["flowpipe"]),
        )
    except (KeyError, TypeError, AttributeError, ZeroDivisionError, IndexError) as e:
        raise ValueError(f"not an evidence: {e!r}") from e


def _verdict_to(v: Verdict) -> dict[str, Any]:
    if isinstance(v, Unknown):
        return {"is": "unknown", **{key: getattr(v, key) for key in _TEXTS}}
    return {"is": "proved" if isinstance(v, Proved) else "refuted", "margin": _margin_to(v.margin)}


def _verdict_from(value: Any) -> Verdict:
    if value["is"] == "unknown":
        return Unknown(*(_text(value[key]) for key in _TEXTS))
    return _VERDICTS[value["is"]](_margin_from(value["margin"]))


def _margin_to(m: Margin | None) -> Any:
    return m and [rational_text(m.low), rational_text(m.high), m.unit, m.at, m.strict]


def _margin_from(value: Any) -> Margin | None:
    if value is None:
        return None
    low, high, unit, at, strict = value
    return Margin(_fraction(low), _fraction(high), _text(unit), _text(at), bool(strict))


def _part_to(p: PartResult) -> dict[str, Any]:
    return {
        "goal": p.goal,
        "texts": [p.kind, p.where, p.output, p.text],
        "verdict": _verdict_to(p.verdict),
        "run": _run_to(p.run),
        "facts": list(p.facts),
        "constants": list(p.constants),
        "sensitivities": [[_plain(getattr(s, name)) for name in _SENSITIVITY] for s in p.sensitivities],
    }


def _part_from(value: Any) -> PartResult:
    kind, where, output, text = (_text(t) for t in value["texts"])
    return PartResult(
        goal=int(value["goal"]),
        kind=kind,
        where=where,
        output=output,
        text=text,
        verdict=_verdict_from(value["verdict"]),
        run=_run_from(value["run"]),
        facts=_texts(value["facts"]),
        constants=_texts(value["constants"]),
        sensitivities=tuple(_sensitivity_from(s) for s in value["sensitivities"]),
    )


def _sensitivity_from(value: Any) -> Sensitivity:
    constant, slope, to_zero, rounding = value
    return Sensitivity(_text(constant), _fraction(slope), _maybe(to_zero), _maybe(rounding))


def _rounding_from(value: Any) -> Rounding | None:
    return value and Rounding(_verdict_from(value["verdict"]), _margin_from(value["margin"]))


def _run_to(run: Run | None) -> Any:
    if run is None:
        return None
    steps = [[rational_text(s.dwell), s.edge, _values_to(s.values)] for s in run.steps]
    path = [[p.mode, p.edge, list(p.time), [list(v) for v in p.values]] for p in run.path]
    return [run.mode, _values_to(run.values), _values_to(run.params), steps, rational_text(run.last), path]


def _run_from(value: Any) -> Run | None:
    if value is None:
        return None
    mode, values, params, steps, last, path = value
    walked = tuple(Step(_fraction(dwell), int(edge), _values_from(chosen)) for dwell, edge, chosen in steps)
    passed = tuple(_passage_from(p) for p in path)
    return Run(_text(mode), _values_from(values), _values_from(params), walked, _fraction(last), passed)


def _passage_from(value: Any) -> Passage:
    mode, edge, time, values = value
    ends = tuple((_text(name), float(low), float(high)) for name, low, high in values)
    return Passage(_text(mode), None if edge is None else _text(edge), (float(time[0]), float(time[1])), ends)


def _trace_to(run: NetworkRun | None) -> Any:
    if run is None:
        return None
    moments = [
        [list(m.names), [list(p) for p in m.modes], _values_to(m.values), rational_text(m.dwell)] for m in run.moments
    ]
    return [moments, _values_to(run.end)]


def _trace_from(value: Any) -> NetworkRun | None:
    if value is None:
        return None
    moments = []
    for names, modes, values, dwell in value[0]:
        entered = tuple((_text(part), _text(mode)) for part, mode in modes)
        moments.append(Moment(_texts(names), entered, _values_from(values), _fraction(dwell)))
    return NetworkRun(tuple(moments), _values_from(value[1]))


def _values_to(values: tuple[tuple[str, Fraction], ...]) -> list[list[str]]:
    return [[name, rational_text(value)] for name, value in values]


def _values_from(value: Any) -> tuple[tuple[str, Fraction], ...]:
    return tuple((_text(name), _fraction(q)) for name, q in value)


def _plain(value: Any) -> Any:
    return rational_text(value) if isinstance(value, Fraction) else value


def _fraction(value: Any) -> Fraction:
    """A rational as `rational_text` writes it; `Fraction` alone reads more, at thrice the time."""
    above, _, below = _text(value).partition("/")
    return Fraction(int(above), int(below)) if below else Fraction(int(above))


def _maybe(value: Any) -> Fraction | None:
    return None if value is None else _fraction(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise ValueError(f"{value!r} is no text")
    return value


def _texts(value: Any) -> tuple[str, ...]:
    return tuple(_text(v) for v in value)


def _optional_dict(value: Any) -> dict[str, Any] | None:
    if value is not None and not isinstance(value, dict):
        raise TypeError(f"{value!r} is no object")
    return value
