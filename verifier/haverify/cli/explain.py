"""`haverify explain`: the manual page of a code or of an analysis."""

from __future__ import annotations

import argparse
import re
from importlib import import_module
from pathlib import Path

from haverify.cli.output import put
from haverify.diagnostics.codes import CATALOGUE, page, pages
from haverify.errors import UsageError


def run(called: argparse.Namespace) -> int:
    """Print a page; exit code 2 if there is none."""
    topic = called.topic.strip()
    if topic.upper() in CATALOGUE:
        put(_code(topic.upper()))
        return 0
    analyses = _analyses()
    name = topic.lower().replace("-", "_")
    if name in analyses:
        put(f"# {name.replace('_', '-')}\n\n{_docstring(name)}\n")
        return 0
    raise UsageError(_unknown(topic, [*CATALOGUE, *(a.replace("_", "-") for a in analyses)]))


def _code(code: str) -> str:
    if code in pages():
        return page(code).rstrip() + "\n"
    entry = CATALOGUE[code]
    return f"# {code}: {entry.name}\n\nSeverity: {entry.severity.value}. This version of haverify does not report it.\n"


def _analyses() -> list[str]:
    """The analyses: modules of their folder whose name has no underscore in front."""
    folder = Path(__file__).parents[1] / "analyses"
    return sorted(path.stem for path in folder.glob("[a-z]*.py"))


def _docstring(name: str) -> str:
    return (import_module(f"haverify.analyses.{name}").__doc__ or "").strip()


def _unknown(topic: str, names: list[str]) -> str:
    if re.fullmatch(r"HA\d{3}", topic.upper()):
        return f"no such code: {topic.upper()}"
    from difflib import get_close_matches

    near = get_close_matches(topic.upper(), names, 1) or get_close_matches(topic.lower(), names, 1)
    hint = f"; did you mean '{near[0]}'?" if near else "; codes are HA001 and so on"
    return f"nothing is known of '{topic}'{hint}"
