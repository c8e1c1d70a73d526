"""`report.json`: the report's facts as they are, keys sorted, the same bytes for the same facts."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict

from haverify.report.report import Finding, Report


def as_json(report: Report) -> str:
    """The text of `report.json`."""
    return json.dumps(asdict(report), indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def as_line(report: Report) -> str:
    """The report on one line: several specs make several lines."""
    return json.dumps(asdict(report), sort_keys=True, ensure_ascii=False) + "\n"


def findings_as_json(findings: Iterable[Finding]) -> str:
    """Findings alone, for `lint --format json`."""
    return json.dumps([asdict(f) for f in findings], indent=1, sort_keys=True, ensure_ascii=False) + "\n"
