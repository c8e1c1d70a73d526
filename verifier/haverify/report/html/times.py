"""What a page says of time: all that differs in it when the same facts are found again."""

from __future__ import annotations

from haverify.report.report import Claim, Report

ROWS = 400  # claims in the table of verdicts


def in_table(r: Report) -> list[Claim]:
    """The claims of the table of verdicts, those first that are not as expected."""
    return sorted(r.claims, key=lambda c: c.ok)[:ROWS]


def of_claim(c: Claim) -> str:
    """What the table says of a claim."""
    return f"{c.wall_s:.2f} s"


def of_report(r: Report) -> str:
    """What the foot of the page says."""
    return f"{r.wall_s:.1f} s, {r.cpu_s:.1f} s of processor time"


def all_of(r: Report) -> list[str]:
    """The times in the order of the page, where each stands in an element of the class `time`."""
    return [*map(of_claim, in_table(r)), of_report(r)]
