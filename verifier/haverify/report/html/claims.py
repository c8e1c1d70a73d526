"""The section of one claim: what it says, what came out in which part, the run or values that decide it."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.report.figures.material import Figure
from haverify.report.html.element import Html, cell, element, joined, table
from haverify.report.html.prose import inline, prose
from haverify.report.markup import clipped
from haverify.report.numbers import decimal
from haverify.report.report import Claim, Margin, Part, Run
from haverify.report.terminal import with_unit
from haverify.report.unrecorded import is_note

_PARTS, _STEPS, _COLUMNS, _LISTED, _TEXT, _SENSITIVITIES = 48, 60, 10, 30, 3000, 5

_ROUNDING = {
    "proved": "holds for every rounding of the printed numbers",
    "refuted": "violated for every rounding of the printed numbers",
    "unknown": "undecided for the numbers that round to the printed ones",
}


def claim_section(c: Claim, anchor: str, figures: Sequence[Figure], again: str) -> Html:
    """Everything about a claim; `again` is the command that repeats it."""
    blocks = [_head(c), prose(c.doc), element("pre", clipped(c.text.strip(), _TEXT)), *_outcome(c)]
    blocks += [figure(f) for f in figures]
    blocks += _parts(c) + _sensitivities(c) + _run(c) + _listed("Notes", [n for n in c.notes if not is_note(n)])
    blocks.append(_facts(c, again))
    return element("section", *blocks, kind="claim" if c.ok else "claim wrong", id=anchor)


def badge(word: str, kind: str = "") -> Html:
    """A word in a coloured field."""
    return element("span", word, kind=f"badge {kind or word}")


def figure(f: Figure) -> Html:
    """A drawing with its caption."""
    return element("figure", element("figcaption", element("b", f.title), f": {f.caption}"), Html(f.svg))


def margin_text(m: Margin | None) -> str:
    """A margin with its instant."""
    return "" if m is None else with_unit(m) + (f" at {m.at}" if m.at else "")


def _head(c: Claim) -> Html:
    place = f"{c.path}:{c.line}" if c.path else ""
    expected = "as expected" if c.ok else f"expected {c.expected}" if c.verdict != c.expected else "not as expected"
    words = [badge(c.verdict), badge(expected, "plain" if c.ok else "alert")]
    words += [badge(f"trust: {c.trust}", "plain")] if c.trust else []
    return element("h3", clipped(c.name, 200), *words, element("span", clipped(place, 200), kind="soft small"))


def _outcome(c: Claim) -> list[Html]:
    """What is not as expected and why, or why it is expected so."""
    lines = [element("p", inline(clipped(p, _TEXT)), kind="problem") for p in c.problems[:_LISTED]]
    why = (("Why it is unknown", c.reason), ("Reached", c.reached), ("Nearest", c.nearest), ("To try", c.next_step))
    pairs = [(name, text) for name, text in why if text]
    pairs += [("Known because", c.because)] if c.because else []
    pairs += [("Margin", margin_text(c.margin))] if c.margin else []
    pairs += [("Rounding", _rounding(c))] if c.rounding else []
    pairs += [("For", ", ".join(f"{k} = {v}" for k, v in c.witness.items()))] if c.witness else []
    return [*lines, *([_pairs(pairs)] if pairs else [])]


def _rounding(c: Claim) -> str:
    if c.rounding is None:
        return ""
    worst = f"; worst margin {margin_text(c.rounding.margin)}" if c.rounding.margin else ""
    return _ROUNDING[c.rounding.verdict] + worst


def _pairs(pairs: Sequence[tuple[str, str]]) -> Html:
    return element("dl", *[e for k, v in pairs for e in (element("dt", k), element("dd", inline(clipped(v, _TEXT))))])


def _parts(c: Claim) -> list[Html]:
    """The parts, violated and undecided ones first where not all are shown."""
    if not c.parts:
        return []
    shown = c.parts
    if len(c.parts) > _PARTS:
        shown = sorted(c.parts, key=lambda p: p.verdict == "proved")[:_PARTS]
    rows = [_part(p) for p in shown]
    if len(rows) == 1 and rows[0].count(_EMPTY) == len(_HEAD) - 2:
        return []  # one part that is the whole claim and of which no more is known
    used = [k for k in range(len(_HEAD)) if any(row[k] != _EMPTY for row in rows)]
    of = [[row[k] for k in used] for row in rows]
    blocks = [element("h4", f"Parts ({len(c.parts)})"), table([_HEAD[k] for k in used], of, "parts")]
    left = len(c.parts) - len(shown)
    text = f"{left} more parts are in report.json, all questions in {_obligations(c)}."
    return blocks + ([element("p", text, kind="soft small")] if left else [])


def _obligations(c: Claim) -> str:
    return f"obligations/{c.name.replace('[', '(').replace(']', ')')}.txt"


_HEAD = ("part", "output", "verdict", "margin", "at", "what is known")
_EMPTY = cell("")


def _part(p: Part) -> list[Html]:
    at = p.margin.at.removeprefix(f"{p.mode}, ") if p.margin else ""
    known = "; ".join([*p.facts, *([p.reason] if p.reason else []), *[f"reads {row}" for row in p.cells]])
    name = p.mode or p.text or f"goal {p.goal}"
    return [
        cell(clipped(name, 120), kind="text" if len(name) > 30 else "n"),
        cell(clipped(p.output, 80)) if p.output else _EMPTY,
        cell(badge(p.verdict)),
        cell(with_unit(p.margin), kind="n") if p.margin else _EMPTY,
        cell(clipped(at, 120), kind="n" if len(at) < 30 else "") if at else _EMPTY,
        cell(inline(clipped(known, 400)), kind="small soft") if known else _EMPTY,
    ]


def _sensitivities(c: Claim) -> list[Html]:
    """What the smallest margin depends on most, within the rounding of the printed numbers."""
    known = [p for p in c.parts if p.margin and p.sensitivities]
    if not known:
        return []
    p = min(known, key=lambda p: _value(p.margin.decimal) if p.margin else 0.0)
    unit = p.margin.unit if p.margin else ""
    ordered = sorted(p.sensitivities, key=lambda s: -abs(Fraction(s.rounding or 0)))[:_SENSITIVITIES]
    rows = [
        [
            cell(s.constant),
            cell(s.place or ""),
            cell(_decimal(s.slope), kind="n"),
            cell(_decimal(s.to_zero), kind="n"),
            cell(_decimal(s.rounding), kind="n"),
        ]
        for s in ordered
    ]
    head = ["number", "cell", "margin per unit", "change to margin 0", f"rounding moves it by [{unit}]"]
    where = ", ".join(x for x in (p.mode, p.output) if x)
    return [element("h4", f"What the margin in {where} depends on"), table(head, rows, "numbers")]


def _value(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0


def _decimal(text: str | None) -> str:
    return "" if text is None else decimal(Fraction(text))


def _run(c: Claim) -> list[Html]:
    """The run as a table: when each mode is entered, with the state there."""
    run = c.run
    if run is None or not run.mode_path:
        return []
    names = list(run.states_decimal[0])[:_COLUMNS] if run.states_decimal else []
    head = ["t [s]", "mode", *[_with(run, n) for n in names]]
    rows = [_step(run, k, names) for k in range(min(len(run.times_decimal), _STEPS))]
    what = "A run that violates it" if c.verdict == "refuted" else "A run that shows it"
    params = ", ".join(f"{_with(run, n)} = {_decimal(q)}" for n, q in run.params.items())
    blocks = [element("h4", what + (f", for {params}" if params else "")), table(head, rows, "numbers")]
    left = len(run.times_decimal) - len(rows)
    return blocks + ([element("p", f"{left} more instants are in report.json.", kind="soft small")] if left else [])


def _step(run: Run, k: int, names: Sequence[str]) -> list[Html]:
    is_end = k >= len(run.mode_path)
    mode = _end(run) if is_end else _mode(run, k)
    state = run.states_decimal[k] if k < len(run.states_decimal) else {}
    said = f": {run.violation}" if is_end and run.violation else ""
    first = [cell(run.times_decimal[k], kind="n"), cell(clipped(mode + said, 160))]
    return first + [cell(state.get(n, ""), kind="n") for n in names]


def _mode(run: Run, k: int) -> str:
    """The mode that is entered; of a system, after its start, what fired and the parts that it moved."""
    parts = run.mode_path[k].split(", ")
    if k == 0 or len(parts) == 1:
        return run.mode_path[k]
    before = run.mode_path[k - 1].split(", ")
    moved = ", ".join(p for p in parts if p not in before) or "no part moves"
    return f"{run.edges[k - 1]}: {moved}" if k <= len(run.edges) else moved


def _end(run: Run) -> str:
    """The end of a run, in a mode where that is one word."""
    return "end" if ", " in run.mode_path[-1] else f"end, in {run.mode_path[-1]}"


def _with(run: Run, name: str) -> str:
    unit = run.units.get(name)
    return f"{name} [{unit}]" if unit else name


def _listed(title: str, texts: Sequence[str]) -> list[Html]:
    if not texts:
        return []
    items = [element("li", inline(clipped(t, 600))) for t in texts[:_LISTED]]
    items += [element("li", f"{len(texts) - _LISTED} more in report.json")] if len(texts) > _LISTED else []
    return [element("h4", title), element("ul", *items)]


def _facts(c: Claim, again: str) -> Html:
    """Assumptions, method, evidence and how to repeat it."""
    pairs = [("On", c.automaton)] if c.automaton else []
    pairs += [("Assuming", "; ".join(c.assumptions[:_LISTED]))] if c.assumptions else []
    pairs += [("Using", ", ".join(c.using))] if c.using else []
    pairs += [("Horizon", c.horizon)] if c.horizon else []
    pairs += [("Decided by", c.method)] if c.method else []
    rows = [e for k, v in pairs for e in (element("dt", k), element("dd", clipped(v, 1000)))]
    if c.certificate:
        # a relative address within the folder; `./` keeps a name with a colon from being a scheme
        rows += [element("dt", "Evidence"), element("dd", element("a", c.certificate, href=_address(c.certificate)))]
    rows += [element("dt", "Repeat"), element("dd", element("code", again))]
    return joined([element("dl", *rows)])


def _address(path: str) -> str:
    return "./" + path.replace("%", "%25").replace("#", "%23").replace("?", "%3F")
