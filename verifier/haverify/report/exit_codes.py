"""Exit codes: what they mean, which of several counts, and what findings alone earn."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.diagnostics.codes import is_error, is_meaningless
from haverify.diagnostics.diagnostic import Diagnostic

OK, WRONG, UNREADABLE, UNDECIDED, FAULT, NOTHING = 0, 1, 2, 3, 4, 5
INTERRUPTED = 130

_PRECEDENCE = (INTERRUPTED, FAULT, UNREADABLE, WRONG, UNDECIDED, NOTHING, OK)

MEANING = {
    OK: "every claim has the verdict it expects and there is no new error finding",
    WRONG: "a claim is decided otherwise than expected, or there is a new error finding",
    UNREADABLE: "the call or an input cannot be understood",
    UNDECIDED: "a claim that was to be decided is unknown",
    FAULT: "a fault of haverify itself: please report it",
    NOTHING: "nothing was checked",
    INTERRUPTED: "interrupted; what is shown is incomplete",
}


def worst(codes: Iterable[int]) -> int:
    """The exit code of several: 130, then 4, 2, 1, 3, 5, 0; 5 of none."""
    return min(codes, key=_PRECEDENCE.index, default=NOTHING)


def finding_code(found: Iterable[Diagnostic], accepted: Iterable[Diagnostic]) -> int:
    """The exit code that findings alone earn: 2 where meaning is lost, 1 for another error nobody accepted."""
    known = set(accepted)
    codes = [UNREADABLE if is_meaningless(d) else WRONG for d in found if is_error(d) and d not in known]
    return worst([OK, *codes])
