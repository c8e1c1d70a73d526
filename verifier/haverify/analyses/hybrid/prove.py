"""What holds on every stretch of every tree holds on every run: boxes of starts are split until it does."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import takewhile
from math import floor

from haverify.analyses.flow_model import Box
from haverify.analyses.hybrid.question import Question, follow
from haverify.evidence.verdict import Margin, Unknown
from haverify.model.expression import nodes
from haverify.solvers.kernel import Stretch

Q = Fraction
PIECES = 128  # boxes looked at for one claim, at most
STRETCHES = 1500  # of all their trees together


def proved_by(question: Question) -> list[list[Stretch]] | None:
    """Trees from pieces that cover all starts and show the goal; None if too many are needed."""
    waiting = [(s, s.box) for s in question.model.starts]
    until = "met" if question.asked.kind == "reach" else "horizon"
    found: list[tuple[Box, list[Stretch]]] = []
    stretches = 0
    while waiting:
        start, box = waiting.pop()
        if question.pieces >= PIECES or stretches >= STRETCHES:
            return None
        question.pieces += 1
        tree = follow(question, start, box, until)
        stretches += len(tree)
        question.shown = question.shown or [(box, tree)]
        trouble = next((s for s in tree if not _shows(question, s)), None)
        if trouble is None:
            found.append((box, tree))
            continue
        _note(question, trouble)
        halves = halved(box)
        if halves is None or (trouble.end == "jumps" and not question.asked.last_jump):
            return None
        waiting += [(start, half) for half in halves]
    question.shown = found
    return [tree for _, tree in found]


def _shows(question: Question, s: Stretch) -> bool:
    """Whether a stretch leaves nothing open that its successors do not settle."""
    if question.asked.kind == "reach":
        return _is_met(s) or (s.end in ("jumped", "cut") and all(g.keeps_window for g in s.stages))
    held = all(g.claim.holds and g.keeps_window for g in s.stages) and (s.jump is None or s.jump.claim.holds)
    last = "jumps" if question.asked.last_jump else "horizon"
    return held and (s.end in (last, "jumped", "cut") or (s.end == "left" and not question.asked.to_the_end))


def _is_met(s: Stretch) -> bool:
    """Whether all runs in the stretch meet the goal before they may leave the declared ranges (LANGUAGE S4)."""
    followed = takewhile(lambda g: g.keeps_window, s.stages)
    return (s.jump is not None and s.jump.claim.met is not None) or any(g.claim.met is not None for g in followed)


def _note(question: Question, s: Stretch) -> None:
    """How far it was shown, and what was in the way."""
    open_at = next((g for g in s.stages if not (g.claim.holds and g.keeps_window)), None)
    last = open_at or (s.stages[-1] if s.stages else None)
    question.reached = max(last.time[0] if last is not None else s.jump.time[0] if s.jump is not None else 0.0, 0.0)
    if s.end == "jumps" and not question.asked.last_jump:
        question.trouble = f"a run may jump more than {question.asked.jumps} times"
    elif s.end not in ("horizon", "jumped", "cut", "left"):
        question.trouble = s.end
    elif open_at is not None and not open_at.keeps_window:
        question.trouble = "a run may leave the declared ranges"


def halved(box: Box) -> list[Box] | None:
    """The box cut in two across its widest side; None if it is a point."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    if widths[v] == 0:
        return None
    low, high = box[v]
    middle = (low + high) / 2
    return [(*box[:v], (middle, high), *box[v + 1 :]), (*box[:v], (low, middle), *box[v + 1 :])]


def undecided(question: Question) -> Unknown:
    at = question.reached
    reached = "" if at is None else f"shown up to t = {floor(at * 10**6) / 10**6:.6f} s"
    why = f" ({question.trouble})" if question.trouble else ""
    reason = f"{question.pieces} sets of starts did not show it{why}, and no run that decides it was found"
    return Unknown("budget", reason, reached, next_step="a smaller initial set or a shorter horizon")


def margin(question: Question, proof: Sequence[Sequence[Stretch]]) -> Margin | None:
    """For one bound in all modes: at least how far all enclosures stay from it."""
    asked = question.asked.condition
    if question.asked.kind != "always" or asked.op not in ("<", "<=", ">", ">=") or question.asked.first > 0:
        return None
    unit = asked.children[0].unit
    if unit is None or any(n.op in ("abs", "jump", "jumped", "pre", "at") for n in nodes(asked)):
        return None
    claimed = [next(iter(atoms), None) for atoms in question.compared]
    bounds = {(c[0], c[1]) for c in claimed if c is not None}
    if None in claimed or len(bounds) != 1 or _is_bare(proof):
        return None
    ((_, op),) = bounds
    sign = 1 if op in (">", ">=") else -1
    places = [c[2] for c in claimed if c is not None]
    stages = [(g, places[s.mode]) for tree in proof for s in tree for g in s.stages if g.time[0] <= question.asked.last]
    ends = [(Q(g.watched[place][0 if sign > 0 else 1]) * sign, g.time[0]) for g, place in stages if g.watched]
    if not ends:
        return None
    low, at = min(ends)
    return Margin(low, low, str(unit), f"t = {max(at, 0.0):.6g} s")


def _is_bare(proof: Sequence[Sequence[Stretch]]) -> bool:
    """Whether some landing is in no stage, so that how far it stays from the bound is not known."""
    return any(s.jump is not None and not s.stages and s.end != "cut" for tree in proof for s in tree)
