"""The findings of a spec as the report holds them, each with the reason that accepts it."""

from __future__ import annotations

from haverify.report.allow import allow
from haverify.report.findings import finding
from haverify.report.report import Finding
from haverify.run.examine import Examined


def told(e: Examined) -> list[Finding]:
    """All findings of a spec, accepted ones included, in order."""
    in_source = allow(e.found, e.spec.allowed) if e.spec and e.accepted else {}
    return [finding(d, e.sources, e.accepted.get(d), in_source) for d in e.found]
