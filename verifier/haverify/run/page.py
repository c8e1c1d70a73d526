"""`index.html` of a report folder; its figures are drawn once for the same facts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from haverify.report.as_html import as_html
from haverify.report.figures.material import Figure, Material
from haverify.report.report import Report
from haverify.run import cache
from haverify.run.keys import code_hash, digest
from haverify.run.material import material

_SCHEMA = "haverify.figures/1"
_TIMES = re.compile(r'"(?:wall|cpu)_s": [^\n]*')


def page(report: Report, folder: Path, text: str, use_cache: bool) -> str:
    """The page of a report whose `report.json` is `text`; with `use_cache`, figures are kept between runs.

    They are drawn from the report's facts (its hash covers the core), the cells and haverify's own code: the same key
    means the same figures. Nothing rests on them.
    """
    drawn_from = material(folder)
    if not use_cache:
        return as_html(report, drawn_from)
    key = digest([_SCHEMA, code_hash(), _TIMES.sub("", text), drawn_from.cells, drawn_from.flowpipes])
    known = _known(cache.load(key))
    drawn_from.figures.update(known or {})
    html = as_html(report, drawn_from)
    if known is None:
        cache.store(key, {"schema": _SCHEMA, "figures": _plain(drawn_from)})
    return html


def _plain(drawn: Material) -> dict[str, list[list[str | None]]]:
    return {k: [[f.name, f.title, f.caption, f.svg, f.claim] for f in fs] for k, fs in drawn.figures.items()}


def _known(value: Any) -> dict[str, list[Figure]] | None:
    """The figures that a file of the cache holds; None where it is no such file."""
    if not isinstance(value, dict) or value.get("schema") != _SCHEMA:
        return None
    try:
        return {key: [_figure(f) for f in figures] for key, figures in value["figures"].items()}
    except (KeyError, TypeError, ValueError, AttributeError):
        return None


def _figure(value: Any) -> Figure:
    name, title, caption, svg, claim = value
    if not all(isinstance(x, str) for x in (name, title, caption, svg)) or not isinstance(claim, str | None):
        raise ValueError(value)
    return Figure(name, title, caption, svg, claim)
