"""`index.html` of a report folder; the same facts are told and drawn once."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Iterator
from itertools import chain, zip_longest
from typing import TYPE_CHECKING, Any

from haverify.report.html import times
from haverify.run import kept
from haverify.run.keys import code_hash, digest

if TYPE_CHECKING:
    from pathlib import Path

    from haverify.report.report import Report

_SCHEMA = "haverify.page/1"


def page(report: Report, folder: Path, text: str, use_cache: bool) -> str:
    """The page of a report whose `report.json` is `text`; with `use_cache`, it is kept between runs but for its times.

    It is made of the report's facts (its hash covers the core), cells, flowpipes and haverify's own code: the same key
    means the same page. Nothing rests on it.
    """
    if not use_cache:
        return _made(report, folder)
    facts = re.sub(r'"(?:wall|cpu)_s": [^\n]*', "", text)
    key = digest([_SCHEMA, code_hash(), facts, *_drawn_from(folder)])
    told = times.all_of(report)
    known = _pieces(kept.load(key), len(told))
    if known:
        return "".join(chain.from_iterable(zip_longest(known, told, fillvalue="")))
    html = _made(report, folder)
    kept.store(key, {"schema": _SCHEMA, "page": re.split(r'(?<= class="time">)[^<]*', html)})
    return html


def _made(report: Report, folder: Path) -> str:
    from haverify.report.as_html import as_html
    from haverify.run.material import material

    return as_html(report, material(folder))


def _drawn_from(folder: Path) -> Iterator[list[str]]:
    """The files of cells and flowpipes, by name, with their hashes."""
    for within in ("certificates/cells", "flowpipes"):
        at = os.path.join(folder, within)
        for name in sorted(os.listdir(at)) if os.path.isdir(at) else ():
            with open(os.path.join(at, name), "rb") as file:
                yield [within, name, hashlib.sha256(file.read()).hexdigest()]


def _pieces(value: Any, count: int) -> list[str] | None:
    """What stands around the times, where the cache holds it."""
    pieces = value.get("page") if isinstance(value, dict) and value.get("schema") == _SCHEMA else None
    is_page = isinstance(pieces, list) and len(pieces) == count + 1 and all(isinstance(p, str) for p in pieces)
    return pieces if is_page else None
