"""A run of a system: a lane for each part, a column for each moment, what fires between them; changes stand out."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.report.figures import svg
from haverify.report.figures.material import Figure, Undrawable
from haverify.report.report import Claim, Run

WIDTH, LANE, HEAD, FOOT = 680.0, 24.0, 34.0, 34.0

_COLUMNS, _BLOCKS, _LANES = 7, 8, 24


def of_run(c: Claim) -> Figure:
    """The run that decides a claim on a system.

    Raises
    ------
    Undrawable      if there is none, or its modes are not told part by part
    """
    run = c.run
    if run is None or not run.mode_path:
        raise Undrawable
    moments = [_moment(run, k) for k in range(len(run.mode_path))]
    lanes = list(dict.fromkeys(name for m in moments for name in m))[:_LANES]
    shown = moments[: _COLUMNS * _BLOCKS]
    if not lanes:
        raise Undrawable
    title = f"The run that {'violates' if c.verdict == 'refuted' else 'shows'} {c.name}"
    drawing = _draw(run, shown, lanes, title)
    said = ["each column is a moment, what changed is framed, what fires stands above, the time of entry below"]
    left = len(moments) - len(shown)
    said += [f"{left} later moments are in the table"] if left else []
    return Figure(f"run_{c.name}", title, "; ".join(said), drawing, c.name)


def _moment(run: Run, k: int) -> dict[str, str]:
    """What each part is in, and the value of each variable, when a moment begins."""
    modes = dict(_split(piece) for piece in run.mode_path[k].split(", ") if "." in piece)
    values = run.states_decimal[k] if k < len(run.states_decimal) else {}
    return {**modes, **{name: value for name, value in values.items() if not _is_clock(run, name)}}


def _split(piece: str) -> tuple[str, str]:
    part, _, mode = piece.rpartition(".")
    return part, mode


def _is_clock(run: Run, name: str) -> bool:
    """Whether a variable changes with time alone: it has a unit."""
    return name in run.units


def _draw(run: Run, moments: Sequence[dict[str, str]], lanes: Sequence[str], title: str) -> str:
    left = max(svg.text_width(name) for name in lanes) + 16
    across = (WIDTH - left - 8) / min(_COLUMNS, len(moments))
    height = HEAD + LANE * len(lanes) + FOOT
    parts = []
    for k, moment in enumerate(moments):
        block, column = divmod(k, _COLUMNS)
        x, y = left + column * across, block * height + HEAD
        if column == 0:
            parts += [svg.label(left - 8, y + LANE * n + 16, name, "name", "e") for n, name in enumerate(lanes)]
        if k and k <= len(run.edges):
            parts.append(svg.label(x, y - 8, _fit(run.edges[k - 1], across), "edge", "m" if column else ""))
        before = moments[k - 1] if k else moment
        for n, name in enumerate(lanes):
            parts += _cell(moment.get(name, ""), x, y + LANE * n, across, moment.get(name) != before.get(name))
        time = run.times_decimal[k] if k < len(run.times_decimal) else ""
        parts.append(svg.label(x + 2, y + LANE * len(lanes) + 15, f"t = {time} s" if time else "", "tick"))
    blocks = (len(moments) - 1) // _COLUMNS + 1
    return svg.drawing(WIDTH, blocks * height, parts, title)


def _cell(text: str, x: float, y: float, across: float, is_new: bool) -> list[str]:
    box = svg.rect(x + 1.5, y + 1.5, across - 3, LANE - 3, "node changed" if is_new else "band1", ' rx="4"')
    return [box, svg.label(x + across / 2, y + 16, _fit(text, across), "mode", "m")]


def _fit(text: str, across: float) -> str:
    most = max(3, int((across - 6) / 6.6))
    return text if len(text) <= most else text[: most - 1] + "\N{HORIZONTAL ELLIPSIS}"
