"""Claims that are refuted as expected while `haverify.lock` does not say in which parts."""

from __future__ import annotations

from haverify.report.report import Claim, Report

_NOTE = "a new violation beside these would pass unseen"


def note(entry: str) -> str:
    """The note on such a claim, with the entry that is missing."""
    return f"{_NOTE}; record them by `haverify accept`, or in haverify.lock:\n{entry.rstrip()}"


def is_note(text: str) -> bool:
    """Whether a note is one of these."""
    return text.startswith(_NOTE)


def is_so(c: Claim) -> bool:
    """Whether a claim has such a note."""
    return any(map(is_note, c.notes))


def advice(report: Report) -> str:
    """What to do about all such claims of a spec."""
    names = [c.name for c in report.claims if is_so(c)]
    of = names[0] if len(names) == 1 else f"these {len(names)} claims"
    return (
        f"A new violation beside the known ones of {of} would pass unseen. Once they are reviewed, record them with\n"
        f'  haverify accept {report.spec} --reason "..."'
    )
