"""What a report folder holds for figures: its core, the cells of its certificates, its flowpipes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from haverify.report.figures.material import Material

_CELLS = 2_000_000  # bytes of a file of cells that is still read
_CORE = 50_000_000
_FILES = 100


def material(folder: Path) -> Material:
    """The core, the cells and the flowpipes of a report folder; what is missing, too large or no JSON is left out."""
    cells: dict[str, Any] = {}
    for file in sorted((folder / "certificates" / "cells").glob("*.json"))[:_FILES]:
        found = _read(file, _CELLS)
        name = found.get("automaton")
        if isinstance(name, str) and (name not in cells or _reach(found) > _reach(cells[name])):
            cells[name] = found
    flowpipes: dict[str, Any] = {}
    for file in sorted((folder / "flowpipes").glob("*.json"))[:_FILES]:
        found = _read(file, _CELLS)
        if isinstance(found.get("claim"), str):
            flowpipes[found["claim"]] = found
    return Material(_read(folder / "core.json", _CORE), cells, flowpipes=flowpipes)


def _reach(cells: dict[str, Any]) -> tuple[int, bool, int]:
    """How much of an automaton some cells show: in how many modes, of all runs or up to a horizon, how finely cut."""
    listed = cells.get("cells")
    known = [c for c in listed if isinstance(c, dict)] if isinstance(listed, list) else []
    is_whole = cells.get("time") is None and cells.get("jumps") is None
    return len({str(c.get("mode")) for c in known}), is_whole, -len(known)


def _read(file: Path, most: int) -> dict[str, Any]:
    try:
        if not file.is_file() or file.stat().st_size > most:
            return {}
        found = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
