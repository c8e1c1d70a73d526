"""How well the rows of tables fit what is stated about them, and one another where phases hand over."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cached_property

from haverify.repair.curves import AS_WRITTEN, Curves, Joint, Key, Line, Numbers
from haverify.repair.stated import Limit
from haverify.text.record import holder, record

Q = Fraction


@record
class Trouble:
    """A limit that rows do not meet, or a joint (`limit` None) at which they are far apart, as only misprints are."""

    keys: tuple[Key, ...]
    limit: Limit | None
    where: str
    excess: Q


@holder
class Fit:
    """The rows of a spec against the limits that its claims state."""

    curves: Curves
    limits: list[Limit]

    @cached_property
    def in_mode(self) -> dict[Key, list[Limit]]:
        """The limits in modes, by row."""
        return self._by_key([m for m in self.limits if not m.edge])

    @cached_property
    def at_edge(self) -> dict[Key, list[Limit]]:
        """The limits at edges: by automaton, edge and output."""
        return self._by_key([m for m in self.limits if m.edge])

    def _by_key(self, limits: Iterable[Limit]) -> dict[Key, list[Limit]]:
        found: dict[Key, list[Limit]] = {}
        for m in limits:
            found.setdefault((m.automaton, m.edge or m.where, m.output), []).append(m)
        return found

    def troubles(self, keys: Iterable[Key], numbers: Numbers = AS_WRITTEN) -> Iterator[Trouble]:
        """What the given rows, and the joints at them, do not meet."""
        joints: dict[int, Joint] = {}
        for key in keys:
            yield from self._in_mode(key, numbers)
            joints |= {id(j): j for j in self.curves.joints_of.get(key, ())}
        for j in joints.values():
            yield from self._at_edge(j, numbers)

    def is_outside(self, keys: Iterable[Key], numbers: Numbers) -> bool:
        """Whether some row does not meet what it has to in its mode; its ends, which cost little, are tried first."""
        for key in keys:
            limits = self.in_mode.get(key, ())
            ends = self.curves.ends(key, numbers) if limits else (Q(0), Q(0))
            if any(m.is_firm and m.excess(*ends) > 0 for m in limits):
                return True
        return any(True for key in keys for _ in self._in_mode(key, numbers))

    def _in_mode(self, key: Key, numbers: Numbers) -> Iterator[Trouble]:
        for limit in self.in_mode.get(key, ()):
            excess = limit.excess(*self.curves.range(key, numbers))
            is_gross = limit.width is not None and excess > limit.width > 0
            if excess > 0 and (limit.is_firm or is_gross):
                yield Trouble((key,), limit, limit.where, excess)

    def _at_edge(self, joint: Joint, numbers: Numbers) -> Iterator[Trouble]:
        limits = self.at_edge.get((joint.before[0], joint.edge.name, joint.before[2]), ())
        step = self.curves.step(joint, numbers) if limits or not joint.has_reset else Q(0)
        for limit in limits:
            excess = limit.excess(step, step)
            if excess > 0 and limit.is_firm:
                yield Trouble((joint.before, joint.after), limit, joint.where, excess)
        if not limits and not joint.has_reset and self._is_torn(joint, step, numbers):
            yield Trouble((joint.before, joint.after), None, joint.where, abs(step))

    def _is_torn(self, joint: Joint, step: Q, numbers: Numbers) -> bool:
        """Whether a step is larger than all the output moves on both sides, and both move (as in HA213)."""
        moves = [self.curves.move(k, numbers) for k in (joint.before, joint.after)]
        return min(moves) > 0 and abs(step) > max(moves)

    def misfit(self, keys: Iterable[Key], numbers: Numbers) -> Q:
        """The steps at the ends of rows, and by how far they leave the limits that are not firm, summed up."""
        joints: dict[int, Joint] = {}
        total = Q(0)
        for key in keys:
            joints |= {id(j): j for j in self.curves.joints_of.get(key, ())}
            soft = [m for m in self.in_mode.get(key, ()) if not m.is_firm]
            total += max((m.excess(*self.curves.range(key, numbers)) for m in soft), default=Q(0))
        return total + sum((abs(self.curves.step(j, numbers)) for j in joints.values()), Q(0))

    def lines(self, trouble: Trouble) -> frozenset[Line]:
        """The lines of tables that may be the cause of a trouble."""
        return frozenset(line for k in trouble.keys for line in self.curves.rows[k].lines)
