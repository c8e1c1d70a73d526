"""A robot's replay in pictures: stick figures, a moving one, the zero moment point in the soles, joints over time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby

from haverify.report.figures import svg
from haverify.text.record import record

Spot = tuple[float, float, float]  # m: forward, to the left, up
Flat = tuple[float, float]


@record
class Frame:
    """The robot at an instant (s): its limbs as chains of points with the side each is on, and its soles."""

    time: float
    mode: str
    stance: str
    limbs: Sequence[tuple[str, Sequence[Spot]]]
    soles: Mapping[str, Sequence[Spot]]
    com: Spot


@record
class Curve:
    """A joint over time: name, unit, values, limits (None: none), and other curves of the same quantity by name."""

    name: str
    unit: str
    values: Sequence[float]
    limits: tuple[float, float] | None
    others: Mapping[str, Sequence[tuple[float, float]]]


@record
class Film:
    """What the pictures show. `points` are zero moment points (m, seen from the stance foot), None where there is none.

    Times are those of the replay; `limits` of the sole are x and y ranges in m.
    """

    times: Sequence[float]
    modes: Sequence[str]
    stance: Sequence[str]
    frames: Sequence[Frame]
    points: Sequence[Flat | None]
    com: Sequence[Flat]
    sole: tuple[Flat, Flat]
    curves: Sequence[Curve]


_SIDE = {"left": "t0", "right": "t1", "": "t7"}


def strip(film: Film) -> str:
    """The robot from its right, in the middle of each mode."""
    chosen = [_middle(list(group)) for _, group in groupby(film.frames, key=lambda f: f.mode)]
    room, height, scale = 118.0, 252.0, 380.0
    parts = []
    for k, frame in enumerate(chosen):
        x = 62 + k * room

        def place(p: Spot, x: float = x) -> svg.Point:
            return x + p[0] * scale, height - 46 - p[2] * scale

        parts.append(svg.rect(k * room + 3, 4, room - 6, height - 8, f"band{k % 2}"))
        parts.append(svg.line((k * room + 3, height - 46), ((k + 1) * room - 3, height - 46), "arrow"))
        parts += _figure(frame, place)
        parts.append(svg.label(x, height - 26, frame.mode, "name", "m"))
        parts.append(svg.label(x, height - 12, f"{frame.time:.2f} s, {frame.stance}", "tick", "m"))
    said = "the robot in the middle of each phase, seen from its right; left limbs blue, right ones orange"
    return svg.drawing(room * max(len(chosen), 7), height, parts, said)


def _middle(frames: Sequence[Frame]) -> Frame:
    return frames[len(frames) // 2]


def _figure(frame: Frame, place: Callable[[Spot], svg.Point]) -> list[str]:
    parts = []
    for side, chain in frame.limbs:
        parts.append(svg.polyline([place(p) for p in chain], f"term {_SIDE[side]}"))
    for side, corners in frame.soles.items():
        front, back = max(corners, key=lambda p: p[0]), min(corners, key=lambda p: p[0])
        parts.append(svg.polyline([place(back), place(front)], f"term {_SIDE[side]}"))
    return [*parts, svg.circle(place(frame.com), 3.2, "mark")]


def moving(film: Film) -> str:
    """The same, moving: every frame is there, a style sheet shows one after the other; no script."""
    count, scale, width, height = len(film.frames), 640.0, 680.0, 400.0
    length = film.times[-1] - film.times[0]
    moments = []
    for k, frame in enumerate(film.frames):

        def side(p: Spot) -> svg.Point:
            return 190 + p[0] * scale, height - 60 - p[2] * scale

        def front(p: Spot) -> svg.Point:
            return 500 - p[1] * scale, height - 60 - p[2] * scale

        drawn = [*_figure(frame, side), *_fronted(frame, front)]
        drawn.append(svg.label(8, 20, f"{frame.mode}, {frame.time:.2f} s, stands on the {frame.stance}", "name"))
        delay = f"animation-delay:{(k / count - 1) * length:.4f}s;animation-duration:{length:.4f}s"
        moments.append(f'<g class="frame" style="{delay}">{"".join(drawn)}</g>')
    share = 104 / count  # a little more, so that nothing flickers between two frames
    style = (
        "<style>.moving .frame{visibility:hidden;animation:shown 1s step-end infinite}"
        f"@keyframes shown{{0%{{visibility:visible}}{share:.4f}%{{visibility:hidden}}}}"
        "@media (prefers-reduced-motion:reduce),print{.moving .frame{animation:none}"
        ".moving .frame:first-of-type{visibility:visible}}</style>"
    )
    ground = svg.line((4, height - 60), (width - 4, height - 60), "arrow")
    said = [
        svg.label(190, height - 30, "from the right", "tick", "m"),
        svg.label(500, height - 30, "from behind", "tick", "m"),
    ]
    return svg.drawing(
        width, height, [style, '<g class="moving">', ground, *said, *moments, "</g>"], "the robot walking"
    )


def _fronted(frame: Frame, place: Callable[[Spot], svg.Point]) -> list[str]:
    parts = [svg.polyline([place(p) for p in chain], f"term {_SIDE[side]}") for side, chain in frame.limbs]
    for side, corners in frame.soles.items():
        left, right = max(corners, key=lambda p: p[1]), min(corners, key=lambda p: p[1])
        parts.append(svg.polyline([place(left), place(right)], f"term {_SIDE[side]}"))
    return [*parts, svg.circle(place(frame.com), 3.2, "mark")]


def soles(film: Film) -> str:
    """The zero moment point under each stance sole, with the edge it must not pass."""
    (back, front), (right, left) = film.sole
    scale, height, parts = 1500.0, 316.0, []
    for k, side in enumerate(("left", "right")):
        x0, y0 = 150 + 330 * k, 156

        def place(p: Flat, x0: float = x0, y0: float = y0) -> svg.Point:
            x, y = min(max(p[0], -0.085), 0.095), min(max(p[1], -0.075), 0.075)
            return x0 + x * scale, y0 - y * scale

        (x, y), (far, low) = place((back, left)), place((front, right))
        parts.append(svg.label(x0 - 60, 16, f"standing on the {side} foot", "name"))
        parts.append(svg.rect(x, y, far - x, low - y, "band1"))
        parts.append(svg.rect(x, y, far - x, low - y, "bound"))
        parts += _trails(film, side, place)
        parts.append(svg.circle((x0, y0), 2.5, "mark"))
    size = f"forward to the right; the sole is {1000 * (front - back):.3g} mm by {1000 * (left - right):.3g} mm"
    parts.append(svg.label(345, height - 20, size, "tick", "m"))
    parts.append(
        svg.label(345, height - 6, "dashed: centre of mass; what is farther out is drawn at the rim", "tick", "m")
    )
    return svg.drawing(690, height, parts, "the zero moment point under the stance soles")


def _trails(film: Film, side: str, place: Callable[[Flat], svg.Point]) -> list[str]:
    parts: list[str] = []
    names: list[str] = []
    taken: list[svg.Point] = []
    rows = zip(film.modes, film.stance, film.points, film.com, strict=True)
    for key, group in groupby(rows, key=lambda row: row[:2]):
        if key[1] == side:
            members = list(group)
            points = [p for _, _, p, _ in members if p is not None]
            is_bad = len(points) < len(members) or not all(_holds(film, p) for p in points)
            parts.append(svg.polyline([place(c) for *_, c in members], "jump"))
            if points:
                trail = [place(p) for p in points]
                parts.append(svg.polyline(trail, "curve bad" if is_bad else "curve"))
                taken.append(_free(trail, taken))
                names.append(svg.label(*taken[-1], key[0], "edge"))
    return parts + names


def _free(trail: Sequence[svg.Point], taken: Sequence[svg.Point]) -> svg.Point:
    """Where a mode's name stands beside its trail, away from names that stand already."""
    near = [trail[0], trail[len(trail) // 2], trail[-1]]
    spots = [(x + 4, y + up) for up in (-5, 15, -19, 29) for x, y in near]
    return next((s for s in spots if all(abs(s[0] - x) > 38 or abs(s[1] - y) > 13 for x, y in taken)), spots[0])


def _holds(film: Film, p: Flat) -> bool:
    return all(low <= c <= high for c, (low, high) in zip(p, film.sole, strict=True))


def joints(film: Film) -> str:
    """The joints that move, over the phases, against their limits."""
    width, left, high, gap = 680.0, 58.0, 84.0, 30.0
    start, end = film.times[0], film.times[-1]
    bottom = 24 + len(film.curves) * (high + gap)

    def x(t: float) -> float:
        return left + (width - left - 14) * (t - start) / (end - start)

    parts = []
    for k, (mode, first, last) in enumerate(_bands(film)):
        parts.append(svg.rect(x(first), 2, x(last) - x(first), bottom, f"band{k % 2}"))
        parts.append(svg.label((x(first) + x(last)) / 2, 16, mode, "mode", "m"))
    for k, curve in enumerate(film.curves):
        parts += _curve(film, curve, x, 40 + k * (high + gap), high, width)
    for t in svg.ticks(start, end, 10):
        parts.append(svg.label(x(t), bottom + 16, f"{svg.tick_text(t)} s", "tick", "m"))
    return svg.drawing(width, bottom + 26, parts, "joints over time, against their limits")


def _bands(film: Film) -> list[tuple[str, float, float]]:
    """Each mode from its first instant to the first of the next one."""
    rows = zip(film.modes, film.times, strict=True)
    begins = [(mode, next(group)[1]) for mode, group in groupby(rows, key=lambda r: r[0])]
    ends = [*(start for _, start in begins[1:]), film.times[-1]]
    return [(mode, start, end) for (mode, start), end in zip(begins, ends, strict=True)]


def _curve(film: Film, c: Curve, x: svg.Scale, top: float, high: float, width: float) -> list[str]:
    limits = c.limits or (min(c.values), max(c.values))
    span = max(c.values) - min(c.values)
    # a limit far away from the curve would flatten it: it is named instead of drawn
    near = [
        limit
        for limit in (limits if c.limits else ())
        if min(abs(limit - v) for v in (min(c.values), max(c.values))) < 0.6 * span
    ]
    others = [v for points in c.others.values() for _, v in points]
    low, up = min(*c.values, *near, *others, min(c.values)), max(*c.values, *near, *others, max(c.values))
    room = 0.08 * (up - low) or 1.0

    def y(v: float) -> float:
        return top + high * (up + room - v) / (up - low + 2 * room)

    far = "" if len(near) == 2 or c.limits is None else f"; limits {limits[0]:.4g} and {limits[1]:.4g}"
    parts = [svg.label(4, top - 6, f"{c.name} [{c.unit}]{far}", "name"), svg.rect(58, top, width - 72, high, "frame")]
    for v in svg.ticks(low, up, 3):
        parts += [
            svg.line((58, y(v)), (width - 14, y(v)), "grid"),
            svg.label(53, y(v) + 4, svg.tick_text(v), "tick", "e"),
        ]
    parts += [svg.line((58, y(v)), (width - 14, y(v)), "bound") for v in near]
    rows = zip(film.modes, film.times, c.values, strict=True)
    for _, group in groupby(rows, key=lambda r: r[0]):
        points = [(x(t), y(v)) for _, t, v in group]
        parts.append(svg.polyline(points, "curve broad" if c.others else "curve"))
    for k, (name, other) in enumerate(c.others.items()):
        kind = f"term t{(1, 2, 4)[k % 3]}" + (" dashed" if k else "")
        parts.append(svg.polyline([(x(t), y(v)) for t, v in other], kind))
        parts.append(svg.label(width - 20 - 150 * k, top - 6, name, f"s{(1, 2, 4)[k % 3]}", "e"))
    return parts
