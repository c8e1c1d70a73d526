"""Certificates, cells and runs as JSON values (docs/core.md section 5); every number is an exact string."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from haverify.evidence.run import Run
from haverify.maths.digits import rational_text

Json = Any


def certificate(claim: str, verdict: str, goals: Sequence[Json], rounding: Json) -> dict[str, Json]:
    """A certificate: one entry per goal, and what is shown about rounding (None where nothing is)."""
    return {
        "schema": "haverify.certificate/1",
        "claim": claim,
        "verdict": verdict,
        "goals": list(goals),
        "rounding": rounding,
    }


def cells_goal(name: str, start: Json, parts: Sequence[Json]) -> dict[str, Json]:
    """A goal decided part by part on cells."""
    return {"kind": "cells", "cells": name, "start": start, "parts": list(parts)}


def inevitable_goal(name: str, start: Json, digest: str) -> dict[str, Json]:
    """A `reach` goal that every cell leads to."""
    return {"kind": "inevitable", "cells": name, "start": start, "hash": digest}


def run_goal(run: Run, digest: str) -> dict[str, Json]:
    """A goal decided by one run."""
    return {"kind": "run", "run": run_json(run), "hash": digest}


def start_json(mode: str, values: Mapping[str, Fraction], params: Mapping[str, Fraction]) -> dict[str, Json]:
    """An admissible initial state."""
    return {"mode": mode, "values": _numbers(values), "params": _numbers(params)}


def run_json(run: Run) -> dict[str, Json]:
    """A run."""
    steps = [{"dwell": rational_text(s.dwell), "edge": s.edge, "values": _numbers(dict(s.values))} for s in run.steps]
    return {
        **start_json(run.mode, dict(run.values), dict(run.params)),
        "steps": steps,
        "last": rational_text(run.last),
    }


def end_json(q: Fraction | None) -> str | None:
    """The end of an interval; None is infinite."""
    return None if q is None else rational_text(q)


def _numbers(values: Mapping[str, Fraction]) -> dict[str, str]:
    return {n: rational_text(q) for n, q in values.items()}
