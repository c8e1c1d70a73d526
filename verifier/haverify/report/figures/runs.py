"""A run over time: its modes as bands, its variables as lines, where it ends."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.report.figures import svg
from haverify.report.figures.evaluate import scope, with_params
from haverify.report.figures.material import Figure, Json, Material, Undrawable
from haverify.report.report import Claim, Run

WIDTH, LEFT, RIGHT, TOP, LANE, HEIGHT, GAP = 680.0, 58.0, 14.0, 8.0, 22.0, 84.0, 22.0

_STEPS = 60
_VARIABLES = 4

Point = tuple[float, float]


def of_run(material: Material, automaton: Json, c: Claim) -> Figure:
    """The run that decides a claim.

    Raises
    ------
    Undrawable      if there is none, or no time passes in it
    """
    run = c.run
    if run is None or len(run.times) < 2 or len(run.mode_path) > _STEPS:
        raise Undrawable
    times = [float(Fraction(t)) for t in run.times]
    if times[-1] <= 0:
        raise Undrawable
    title = f"The run that {'violates' if c.verdict == 'refuted' else 'shows'} {c.name}"
    drawing = _draw(run, times, _lines(material, automaton, run, times), title)
    end = f"t = {run.times_decimal[-1]} s"
    said = f"violated at {end}" if c.verdict == "refuted" else f"reached at {end}"
    return Figure(f"run_{c.name}", title, f"modes as bands, variables over time; {said}", drawing, c.name)


def _lines(material: Material, automaton: Json, run: Run, times: Sequence[float]) -> dict[str, list[list[Point]]]:
    """For each variable that changes: its line in each mode, ends at the instants of the jumps."""
    modes = {m["name"]: m for m in automaton["modes"]}
    names = [n for n in run.states[0] if len({s[n] for s in run.states}) > 1][:_VARIABLES]
    lines: dict[str, list[list[Point]]] = {n: [] for n in names}
    for k, name in enumerate(run.mode_path):
        if k + 1 >= len(times):
            break
        s = with_params(scope(material, automaton, modes[name]), run.params)
        for n in names:
            start, dwell = float(Fraction(run.states[k][n])), times[k + 1] - times[k]
            rate = s.value(s.rates[n])({}) if s.rates.get(n) is not None else 0.0
            lines[n].append([(times[k], start), (times[k + 1], start + rate * dwell)])
    return {} if _is_clock_alone(lines) else lines


def _is_clock_alone(lines: dict[str, list[list[Point]]]) -> bool:
    """Whether all there is to see is one variable that rises evenly with time and is never set."""
    if len(lines) != 1:
        return False
    (strokes,) = lines.values()
    points = [p for stroke in strokes for p in stroke]
    (t, v), (end, last) = points[0], points[-1]
    rate = (last - v) / (end - t) if end > t else 0.0
    return all(abs(y - v - rate * (x - t)) <= 1e-9 * max(1.0, abs(y)) for x, y in points)


def _draw(run: Run, times: Sequence[float], lines: dict[str, list[list[Point]]], title: str) -> str:
    bottom = TOP + LANE + len(lines) * (HEIGHT + GAP) + 4

    def x(t: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * t / times[-1]

    parts = _lane(run, times, x, bottom)
    for k, (name, strokes) in enumerate(lines.items()):
        unit = run.units.get(name)
        parts += _variable(f"{name} [{unit}]" if unit else name, strokes, x, TOP + LANE + GAP + k * (HEIGHT + GAP))
    for value in svg.ticks(0.0, times[-1], 10):
        parts.append(svg.line((x(value), bottom), (x(value), bottom + 4), "tick"))
        parts.append(svg.label(x(value), bottom + 17, svg.tick_text(value), "tick", "m"))
    parts.append(svg.line((x(times[-1]), TOP), (x(times[-1]), bottom), "jump bad" if run.violation else "jump"))
    parts.append(svg.label((LEFT + WIDTH - RIGHT) / 2, bottom + 34, "t [s]", "axis", "m"))
    return svg.drawing(WIDTH, bottom + 40, parts, title)


def _lane(run: Run, times: Sequence[float], x: svg.Scale, bottom: float) -> list[str]:
    """The bands of the modes; a mode that is left at once is a line."""
    parts, names = list[str](), list[str]()
    ends = [*times[1:], times[-1]]
    for k, (mode, start, end) in enumerate(zip(run.mode_path, times, ends, strict=False)):
        width = x(end) - x(start)
        if width < 0.5:
            names.append(svg.line((x(start), TOP), (x(start), bottom), "jump"))
            continue
        parts.append(svg.rect(x(start), TOP, width, bottom - TOP, f"band{k % 2}"))
        if svg.text_width(mode) <= width:
            names.append(svg.label((x(start) + x(end)) / 2, TOP + 16, mode, "mode", "m"))
    return parts + names


def _variable(name: str, strokes: Sequence[Sequence[Point]], x: svg.Scale, top: float) -> list[str]:
    values = [v for stroke in strokes for _, v in stroke]
    low, high = min(values), max(values)
    room = (high - low) * 0.08 or 1.0
    low, high = low - room, high + room

    def y(value: float) -> float:
        return top + HEIGHT * (1 - (value - low) / (high - low))

    parts = [svg.rect(LEFT, top, WIDTH - LEFT - RIGHT, HEIGHT, "frame"), svg.label(4, top - 6, name, "name")]
    for value in svg.ticks(low, high, 4):
        parts.append(svg.line((LEFT, y(value)), (WIDTH - RIGHT, y(value)), "grid"))
        parts.append(svg.label(LEFT - 5, y(value) + 4, svg.tick_text(value), "tick", "e"))
    for k, stroke in enumerate(strokes):
        parts.append(svg.polyline([(x(t), y(v)) for t, v in stroke], "curve"))
        if k and strokes[k - 1][-1][1] != stroke[0][1]:
            t = stroke[0][0]
            parts.append(svg.line((x(t), y(strokes[k - 1][-1][1])), (x(t), y(stroke[0][1])), "jump"))
    last = strokes[-1][-1]
    return [*parts, svg.circle((x(last[0]), y(last[1])), 3.5, "mark")]
