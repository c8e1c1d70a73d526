"""What a report folder holds for figures: its core, and the cells of its certificates."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from haverify.report.figures.material import Material

_CELLS = 2_000_000  # bytes of a file of cells that is still read
_CORE = 50_000_000


def material(folder: Path) -> Material:
    """The core and the cells of a report folder; what is missing, too large or no JSON is left out."""
    cells: dict[str, Any] = {}
    for file in sorted((folder / "certificates" / "cells").glob("*.json")):
        found = _read(file, _CELLS)
        if isinstance(found.get("automaton"), str):
            cells.setdefault(found["automaton"], found)
    return Material(_read(folder / "core.json", _CORE), cells)


def _read(file: Path, most: int) -> dict[str, Any]:
    try:
        if not file.is_file() or file.stat().st_size > most:
            return {}
        found = json.loads(file.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}
