"""What holds on every stretch of every tree holds on every run: boxes of starts are split until it does."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import takewhile
from math import floor

from haverify.analyses.hybrid import shared
from haverify.analyses.hybrid.options import cuts
from haverify.analyses.hybrid.question import Piece, Question, follow, grow_all
from haverify.analyses.hybrid.starts import cut, halves, is_point
from haverify.evidence.verdict import Unknown
from haverify.solvers.kernel import Stage, Stretch
from haverify.text.record import record, replace

Q = Fraction
PIECES = 512  # boxes looked at for one claim, at most
WORK = 24_000  # steps of all their trees together; one in more than `FEW` variables counts as several
FEW = 4
LINE = Q(1, 3)  # what a step counts for where only one variable is uncertain at the start
DEEPEST = 24  # how often a box is halved, at most
LEAST = 16  # steps that a stretch between jumps counts for, at least


@record
class Failed:
    """A piece that does not show the goal: up to when it does, and what is in the way."""

    piece: Piece
    reached: float
    trouble: str
    is_hopeless: bool


def proved_at_once(question: Question) -> list[Piece] | None:
    """The trees from whole boxes of starts, if they show the goal."""
    found, failed = _tried(
        question, [Piece(s, b) for s in question.model.starts for b in cut(s.box, cuts(question.claim))]
    )
    question.shown = found if not failed else question.shown
    return None if failed else found


def _wholes(question: Question) -> list[Piece]:
    return [Piece(s, b) for s in question.model.starts for b in cut(s.box, cuts(question.claim))]


def proved_by(question: Question) -> list[Piece] | None:
    """Trees from pieces that cover all starts and show the goal; None if too many are needed.

    What fails for whole boxes of starts is tried once more with finer steps before they are cut, those first of which
    the least is shown.
    """
    found, failed = _tried(question, _wholes(question))
    if failed and _is_worth_it(question, failed):
        more, less = _tried(question, [replace(f.piece, is_finer=True) for f in failed if not f.trouble])
        found, failed = found + more, [f for f in failed if f.trouble] + less
    while failed and _is_worth_it(question, failed):
        worst = min(range(len(failed)), key=lambda i: failed[i].reached)
        piece = failed.pop(worst).piece
        more, less = _tried(question, [Piece(piece.start, b, cuts=piece.cuts + 1) for b in halves(piece.box)[1:]])
        found, failed = found + more, failed + less
    if failed:
        _note(question, failed)
        return None
    question.shown = found
    return found


def _is_worth_it(question: Question, failed: Iterable[Failed]) -> bool:
    """Whether to go on: there is work left, and smaller sets may help."""
    is_over = question.pieces >= PIECES or question.work >= WORK * question.budget
    return not is_over and not any(f.is_hopeless or f.piece.cuts >= DEEPEST or is_point(f.piece.box) for f in failed)


def _tried(question: Question, pieces: Iterable[Piece]) -> tuple[list[Piece], list[Failed]]:
    """The pieces of which the goal is shown, and the others, all followed."""
    found, failed = list[Piece](), list[Failed]()
    for piece in _all_followed(question, list(pieces)):
        trouble = [s for s in piece.tree if not _shows(question, s)]
        if trouble:
            failed.append(_failed(question, piece, trouble))
        else:
            found.append(piece)
    return found, failed


def _all_followed(question: Question, pieces: Sequence[Piece]) -> Iterator[Piece]:
    """The pieces with their trees, as many of which are grown at the same time as there are threads."""
    for at in range(0, len(pieces), shared.THREADS):
        some = pieces[at : at + shared.THREADS]
        if len(some) > 1 and question.asked.kind != "reach":
            grow_all(question, some)
        yield from (_followed(question, wanted) for wanted in some)


def _followed(question: Question, wanted: Piece) -> Piece:
    until = "met" if question.asked.kind == "reach" else "horizon"
    piece = replace(wanted, tree=follow(question, wanted.start, wanted.box, until, wanted.is_finer))
    least = LEAST if question.model.jumps else 1
    steps = sum(max(least, len(s.stages)) for s in piece.tree)
    question.pieces += 1
    is_line = sum(low < high for low, high in piece.box) <= 1
    question.work += steps * max(Q(1), Q(len(piece.box) - 1, FEW) ** 2) * (LINE if is_line else 1)
    question.shown = question.shown or [piece]
    return piece


def _shows(question: Question, s: Stretch) -> bool:
    """Whether a stretch leaves nothing open that its successors do not settle."""
    if question.asked.kind == "reach":
        return _is_met(s) or (s.end in ("jumped", "cut") and all(map(_is_followed, s.stages)))
    held = all(map(_is_held, s.stages)) and (s.jump is None or s.jump.claim.holds)
    last = "jumps" if question.asked.last_jump else "horizon"
    if question.asked.to_the_end and not all(g.stays for g in s.stages):
        return False
    return held and (s.end in (last, "jumped", "cut") or (s.end == "left" and not question.asked.to_the_end))


def _is_held(g: Stage) -> bool:
    return g.claim.holds and g.keeps_window


def _is_followed(g: Stage) -> bool:
    """Whether no run leaves the declared ranges (LANGUAGE S4) or is stuck."""
    return g.keeps_window and g.stays


def _is_met(s: Stretch) -> bool:
    """Whether all runs in the stretch meet the goal before they may leave the declared ranges or be stuck."""
    followed = takewhile(_is_followed, s.stages)
    return (s.jump is not None and s.jump.claim.met is not None) or any(g.claim.met is not None for g in followed)


def _failed(question: Question, piece: Piece, open_ones: Iterable[Stretch]) -> Failed:
    """The first instant up to which it is not shown, and why."""
    found = [_open(question, piece.tree, s) for s in open_ones]
    return Failed(piece, *min(found, key=lambda f: f[0]))


def _open(question: Question, tree: Sequence[Stretch], s: Stretch) -> tuple[float, str, bool]:
    open_at = next((g for g in s.stages if not _is_held(g)), None)
    reached = max(open_at.time[0] if open_at is not None else _end(tree, s), 0.0)
    if s.end == "jumps" and not question.asked.last_jump:
        return reached, f"a run may jump more than {question.asked.jumps} times", True
    if s.end not in ("horizon", "jumped", "jumps", "cut", "left"):
        return reached, s.end, False
    is_out = open_at is not None and not open_at.keeps_window
    return reached, "a run may leave the declared ranges" if is_out else "", False


def _end(tree: Sequence[Stretch], s: Stretch) -> float:
    """The instant up to which a stretch was followed, at least."""
    if s.stages:
        return s.stages[-1].time[0]
    if s.jump is not None:
        return s.jump.time[0]
    return 0.0 if s.parent is None else _end(tree, tree[s.parent])


def _note(question: Question, failed: Iterable[Failed]) -> None:
    """How far it is shown of all starts, and what is in the way of the first."""
    first = min(failed, key=lambda f: f.reached)
    # That a stretch was followed far enough for some of its runs says nothing of the others.
    question.reached, question.trouble = first.reached, first.trouble if first.trouble != "answered" else ""


def undecided(question: Question) -> Unknown:
    """What is said where nothing decides."""
    at = None if question.asked.kind == "reach" else question.reached
    reached = "" if at is None else f"shown up to t = {floor(at * 10**6) / 10**6:.6f} s"
    why = f" ({question.trouble})" if question.trouble else ""
    count = f"{question.pieces} flowpipes" if question.pieces > 1 else "a flowpipe"
    reason = f"{count} did not show it{why}, and no run that decides it was found"
    return Unknown("budget", reason, reached, next_step="a smaller initial set or a shorter horizon")
