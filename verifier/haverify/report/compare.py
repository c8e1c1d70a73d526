"""Two reports on one spec compared: what got worse, what else changed, and what explains it.

Worse is: a claim that is gone or no longer shown, a verdict lost, a trust weakened, a margin that shrank by more than
is allowed, an error finding that is new. Margins are compared exactly, as shares of the old one.
"""

from __future__ import annotations

from fractions import Fraction

from haverify.report.numbers import decimal, ends
from haverify.report.report import Claim, Finding, Report
from haverify.report.terminal import with_unit
from haverify.text.record import record

_TRUST = {"checked": 2, "enclosed": 1, "solver": 0, None: -1}


@record
class Change:
    """One difference; `kind` is claim, verdict, trust, margin, text, finding or cause."""

    kind: str
    name: str
    text: str
    is_worse: bool
    path: str | None = None
    line: int | None = None


def compare(old: Report, new: Report, most: Fraction | None) -> list[Change]:
    """The changes from `old` to `new`, those for the worse first; `most` is the share of a margin that may be lost."""
    before, after = {c.name: c for c in old.claims}, {c.name: c for c in new.claims}
    changes = [_gone(before[n]) for n in before if n not in after]
    changes += [_new(after[n]) for n in after if n not in before]
    changes += [c for n in after if n in before for c in _claim(before[n], after[n], most)]
    changes += _findings(old, new)
    changes = sorted(changes, key=lambda c: not c.is_worse)
    return changes + _causes(old, new, bool(changes))


def _gone(c: Claim) -> Change:
    return Change("claim", c.name, f"gone; it was {c.verdict}", True, c.path, c.line)


def _new(c: Claim) -> Change:
    return Change("claim", c.name, f"new: {c.verdict}", False, c.path, c.line)


def _claim(a: Claim, b: Claim, most: Fraction | None) -> list[Change]:
    changes = []
    if a.verdict != b.verdict:
        is_worse = a.verdict == "proved" or b.verdict == "unknown"
        changes.append(Change("verdict", b.name, f"{b.verdict}, was {a.verdict}", is_worse, b.path, b.line))
    elif _TRUST[a.trust] != _TRUST[b.trust]:
        is_worse = _TRUST[b.trust] < _TRUST[a.trust]
        said = f"trust {b.trust or 'none'}, was {a.trust or 'none'}"
        changes.append(Change("trust", b.name, said, is_worse, b.path, b.line))
    if a.expected != b.expected:
        said = f"expects {b.expected}, expected {a.expected}"
        changes.append(Change("text", b.name, said, False, b.path, b.line))
    if _plain(a.text) != _plain(b.text):
        changes.append(Change("text", b.name, "another text than before", False, b.path, b.line))
    return changes + (_margin(a, b, most) if a.verdict == b.verdict != "unknown" else [])


def _plain(text: str) -> str:
    return " ".join(text.split())


def _margin(a: Claim, b: Claim, most: Fraction | None) -> list[Change]:
    """How the margin changed; worse where certainly more is lost than `most`, or nothing can be compared."""
    if a.margin == b.margin:
        return []
    old, new = (ends(c.margin) if c.margin else None for c in (a, b))
    if a.margin is None or b.margin is None or old is None or new is None or a.margin.unit != b.margin.unit:
        return [_incomparable(a, b, most)]
    if old == new:
        return []
    lost = old[0] - new[1]  # at least so much, whatever the enclosures hold
    size = max(abs(old[0]), abs(old[1]))
    is_worse = most is not None and lost > most * size
    share = f" ({decimal(100 * (_middle(new) - _middle(old)) / size)} %)" if size else ""
    said = f"margin {with_unit(b.margin)}, was {with_unit(a.margin)}{share}"
    return [Change("margin", b.name, said, is_worse, b.path, b.line)]


def _incomparable(a: Claim, b: Claim, most: Fraction | None) -> Change:
    texts = [with_unit(m) if m else "none" for m in (b.margin, a.margin)]
    said = f"margin {texts[0]}, was {texts[1]}: not to be compared"
    return Change("margin", b.name, said, a.margin is not None and most is not None, b.path, b.line)


def _middle(ends: tuple[Fraction, Fraction]) -> Fraction:
    return (ends[0] + ends[1]) / 2


def _findings(old: Report, new: Report) -> list[Change]:
    """Findings that are new or gone, verdicts and expectations aside: claims tell of these."""
    before, after = (_by_identity(r) for r in (old, new))
    changes = []
    for key, f in after.items():
        was = before.get(key)
        if was is None or (was.accepted is not None and f.accepted is None):
            is_worse = f.severity == "error" and f.accepted is None
            said = f"new: {f.message}" if was is None else f"no longer accepted: {f.message}"
            changes.append(Change("finding", f.code, said, is_worse, f.path, f.line))
    return changes + [
        Change("finding", f.code, f"gone: {f.message}", False) for k, f in before.items() if k not in after
    ]


def _by_identity(r: Report) -> dict[tuple[str, str], Finding]:
    found = [f for f in r.findings if not f.code.startswith("HA7")]
    return {(f.code, f.fingerprint or f"{f.path}: {f.message}"): f for f in found}


def _causes(old: Report, new: Report, is_changed: bool) -> list[Change]:
    """What differs between the two runs, and so may explain the changes."""
    causes = [Change("cause", "spec", f"{new.spec}, was {old.spec}", False)] if old.spec != new.spec else []
    before, after = ({i.path: i.sha256 for i in r.inputs} for r in (old, new))
    for path in dict.fromkeys([*before, *after]):
        if before.get(path) != after.get(path):
            what = "model" if path.endswith(".ha") else "data"
            said = "changed" if path in before and path in after else "new" if path in after else "no longer read"
            causes.append(Change("cause", what, f"{path} {said}", False))
    options = dict.fromkeys([*old.options, *new.options])
    for name in (n for n in options if old.options.get(n) != new.options.get(n)):
        said = f"{name} is {new.options.get(name) or 'not set'}, was {old.options.get(name) or 'not set'}"
        causes.append(Change("cause", "options", said, False))
    for name, a, b in _versions(old, new):
        causes.append(Change("cause", "tool", f"{name} {b}, was {a}", False))
    if is_changed and not causes:
        said = "model, data, options and tool are the same: the verdicts should be too"
        causes.append(Change("cause", "none", said, False))
    return causes


def _versions(old: Report, new: Report) -> list[tuple[str, str, str]]:
    a, b = old.tool, new.tool
    pairs = [("haverify", a.version, b.version), ("kernel", a.kernel[:12], b.kernel[:12])]
    names = dict.fromkeys([*a.solvers, *b.solvers])
    pairs += [(n, a.solvers.get(n, "none"), b.solvers.get(n, "none")) for n in names]
    return [(n, x, y) for n, x, y in pairs if x != y]
