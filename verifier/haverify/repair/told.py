"""Choices in words: what a row of a table does as written, and what it does after the change."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.lint._wording import quantity
from haverify.model.unit import Unit
from haverify.repair.change import KINDS, Change
from haverify.repair.choice import Choice
from haverify.repair.curves import AS_WRITTEN, Curves, Joint, Key, Numbers
from haverify.repair.fit import Fit
from haverify.repair.stated import Limit

Q = Fraction


def change_text(change: Change) -> str:
    """A change in a line: `p4 in row LR: one sign, -258.8`."""
    texts = " and ".join(e.text for e in change.edits)
    return f"{change.what}: {KINDS[change.kind]}, {texts}"


def near(value: Q, unit: Unit | str | None) -> str:
    """A computed value to three decimals, with its unit; of small ones, what there is."""
    rounded = Q(round(value * 1000), 1000)
    shown = quantity(rounded or value, unit if isinstance(unit, Unit) else None)
    return f"{shown} {unit}" if isinstance(unit, str) and unit else shown


def row_notes(fit: Fit, choice: Choice, numbers: Numbers) -> tuple[str, ...]:
    """What a choice changes; `numbers` are those of all choices, so that rows are compared with mended neighbours."""
    keys = {k for t in choice.troubles for k in t.keys} & set(choice.keys)
    shown = [k for k in choice.keys if k in keys] or list(choice.keys[:1])
    return tuple(line for key in shown for line in _of_row(fit, choice, key, numbers))


def _of_row(fit: Fit, choice: Choice, key: Key, numbers: Numbers) -> Iterator[str]:
    unit = fit.curves.rows[key].unit
    now, then = fit.curves.range(key), fit.curves.range(key, numbers)

    def text(values: tuple[Q, Q]) -> str:
        return f"{near(values[0], unit)} .. {near(values[1], unit)}"

    yield f"`{key[2]}` in mode {key[1]} of {key[0]}: {text(now)} as written, {text(then)} then"
    limits = [m for t in choice.troubles for m in [t.limit] if m is not None and not m.edge and t.keys == (key,)]
    for limit in dict.fromkeys(limits):
        yield f"stated by {limit.claim}: {_range(limit, fit.curves, key)}"
    steps = [_step(fit.curves, j, key, numbers) for j in fit.curves.joints_of.get(key, ())]
    if steps:
        yield "steps at its ends: " + "; ".join(steps)


def _range(limit: Limit, curves: Curves, key: Key) -> str:
    unit = curves.rows[key].unit
    low, high = (quantity(v, unit) if v is not None else "" for v in (limit.low, limit.high))
    if low and high:
        return f"{low} .. {high}"
    return f"at least {low}" if low else f"at most {high}"


def _step(curves: Curves, joint: Joint, key: Key, numbers: Numbers) -> str:
    unit = curves.rows[key].unit
    now, then = curves.step(joint, AS_WRITTEN), curves.step(joint, numbers)
    return f"{near(now, unit)} at {joint.where}, then {near(then, unit)}"
