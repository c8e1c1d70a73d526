"""Which changes of table cells make rows fit again: the fewest, and among these the ones that join best."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product

from haverify.model.spec import Cell
from haverify.repair.cells import cells_by_line, line_changes
from haverify.repair.change import Change
from haverify.repair.curves import Key, Line
from haverify.repair.fit import Fit, Trouble
from haverify.text.record import field, holder, record, replace
from haverify.text.source import Source

Q = Fraction

MOST_KEPT = 12  # changes of one line that are tried together with those of others
MOST_TRIED = 4000  # combinations of such changes
NEAR = Q(11, 10)  # misfits within a tenth of one another do not tell which is right


@record
class Choice:
    """The change of a line that fits best; `equals` fit as well, `next` is the best of the others that would do.

    `troubles` are what the row as written does not meet; the misfits are sums of steps, in the output's unit.
    """

    line: Line
    change: Change
    misfit: Q
    troubles: tuple[Trouble, ...]
    keys: tuple[Key, ...]
    equals: tuple[Change, ...] = ()
    next: tuple[Change, Q] | None = None


@record
class Hopeless:
    """Lines that no single change makes fit, and what they do not meet."""

    lines: tuple[Line, ...]
    troubles: tuple[Trouble, ...]


@record
class _Option:
    """A change of a line, the rows it touches, and its misfit with the neighbours as they are written."""

    change: Change
    keys: tuple[Key, ...]
    misfit: Q


@holder
class Chooser:
    """Choices for all lines of a spec that are in trouble."""

    fit: Fit
    sources: Mapping[str, Source]
    places: dict[Line, list[list[Cell]]] = field(default_factory=dict)

    def choose(self) -> tuple[list[Choice], list[Hopeless]]:
        """A choice for each line at fault, in the order of files and lines, and the lines where there is none."""
        self.places = cells_by_line(self.fit.curves.facts.spec)
        troubles = list(self.fit.troubles(self.fit.curves.rows))
        choices: list[Choice] = []
        hopeless: list[Hopeless] = []
        for group in _groups(self.fit, [t for t in troubles if self.fit.lines(t)]):
            found, lost = self._group(group)
            choices += found
            hopeless += lost
        return sorted(choices, key=lambda c: c.line), hopeless

    def _group(self, troubles: Sequence[Trouble]) -> tuple[list[Choice], list[Hopeless]]:
        certain = sorted({next(iter(ls)) for t in troubles if len(ls := self.fit.lines(t)) == 1})
        others = sorted({line for t in troubles for line in self.fit.lines(t)} - set(certain))
        options = {line: self._options(line, [t for t in troubles if self.fit.lines(t) == {line}]) for line in certain}
        lost = [line for line in certain if not options[line]]
        free = [t for t in troubles if not self.fit.lines(t) & set(lost)]
        hopeless = [Hopeless(tuple(lost), tuple(t for t in troubles if t not in free))] if lost else []
        able = [line for line in certain if options[line]]
        found = self._best(able, options, free)
        if found is not None:
            return list(self._told(able, options, found[1], free)), hopeless
        return self._extended(able, others, options, free, hopeless)

    def _extended(
        self, able: list[Line], others: Sequence[Line], options: Mapping[Line, list[_Option]],
        free: Sequence[Trouble], hopeless: list[Hopeless],
    ) -> tuple[list[Choice], list[Hopeless]]:  # fmt: skip
        """The choices with one further line, which only joints speak against; lines that do as well are its equals."""
        found: list[tuple[Q, Line, dict[Line, list[_Option]], tuple[_Option, ...]]] = []
        for extra in others:
            more = {**options, extra: self._options(extra, [])}
            again = self._best([*able, extra], more, free) if more[extra] else None
            if again is not None:
                found.append((again[0], extra, more, again[1]))
        if not found:
            return [], [*hopeless, Hopeless(tuple(able or others), tuple(free))] if free else hopeless
        misfit, line, more, best = min(found, key=lambda f: f[:2])
        choices = list(self._told([*able, line], more, best, free))
        rivals = [f[3][-1].change for f in found if f[1] != line and f[0] <= misfit * NEAR]
        choices[-1] = replace(choices[-1], equals=(*choices[-1].equals, *rivals))
        return choices, hopeless

    def _options(self, line: Line, own: Sequence[Trouble]) -> list[_Option]:
        """The changes of a line after which its rows meet what they have to in their modes, best ones first."""
        found = []
        for change in line_changes(self.places.get(line, ()), self.sources):
            keys = self._keys(change)
            numbers = dict(change.numbers)
            if not keys or not all(k in keys for t in own for k in t.keys):
                continue
            if not self.fit.is_outside(keys, numbers):
                found.append(_Option(change, keys, self.fit.misfit(keys, numbers)))
        found.sort(key=lambda o: (o.misfit, o.change.order()))
        return found[:MOST_KEPT]

    def _keys(self, change: Change) -> tuple[Key, ...]:
        readers = self.fit.curves.readers
        return tuple(dict.fromkeys(k for name, _ in change.numbers for k in readers.get(name, ())))

    def _best(
        self, lines: Sequence[Line], options: Mapping[Line, list[_Option]], troubles: Sequence[Trouble]
    ) -> tuple[Q, tuple[_Option, ...]] | None:
        """The options, one for each line, after which no trouble is left, with the least misfit."""
        if not lines:
            return None
        kept = dict(options)
        while _count(kept[line] for line in lines) > MOST_TRIED:
            longest = max(lines, key=lambda line: len(kept[line]))
            kept[longest] = kept[longest][:-1]
        best: tuple[Q, tuple[_Option, ...]] | None = None
        for combined in product(*(kept[line] for line in lines)):
            misfit = self._misfit(combined, troubles)
            if misfit is not None and (best is None or misfit < best[0]):
                best = (misfit, combined)
        return best

    def _misfit(self, combined: Iterable[_Option], troubles: Sequence[Trouble]) -> Q | None:
        """The misfit after several changes, None where one of the troubles stays or another comes."""
        chosen = list(combined)
        numbers = {n: v for o in chosen for n, v in o.change.numbers}
        keys = tuple(dict.fromkeys(k for o in chosen for k in o.keys))
        known = {(t.keys, t.where, t.limit) for t in troubles}
        touched = tuple(dict.fromkeys([*keys, *(k for t in troubles for k in t.keys)]))
        for t in self.fit.troubles(touched, numbers):
            if (t.keys, t.where, t.limit) in known or any(k in keys for k in t.keys):
                return None
        return self.fit.misfit(keys, numbers)

    def _told(
        self, lines: Sequence[Line], options: Mapping[Line, list[_Option]], best: tuple[_Option, ...],
        troubles: Sequence[Trouble],
    ) -> Iterator[Choice]:  # fmt: skip
        """The choices, each with what else would do in its place, the other lines being as chosen."""
        for k, line in enumerate(lines):
            own = self._misfit(best, troubles)
            assert own is not None, "the best combination leaves no trouble"
            rivals = []
            for o in options[line]:
                misfit = self._misfit((*best[:k], o, *best[k + 1 :]), troubles) if o is not best[k] else None
                if misfit is not None:
                    rivals.append((o.change, misfit))
            equals = tuple(c for c, m in rivals if m <= own * NEAR)
            others = [(c, m) for c, m in rivals if m > own * NEAR]
            nearest = min(others, key=lambda r: r[1], default=None)
            mine = tuple(t for t in troubles if line in self.fit.lines(t))
            yield Choice(line, best[k].change, own, mine, best[k].keys, equals, nearest)


def _count(options: Iterable[Sequence[_Option]]) -> int:
    total = 1
    for found in options:
        total *= max(1, len(found))
    return total


def _groups(fit: Fit, troubles: Sequence[Trouble]) -> list[list[Trouble]]:
    """The troubles that share lines or meet at a joint, directly or through others."""
    groups: list[tuple[set[Line], list[Trouble]]] = []
    in_trouble = {k for t in troubles for k in t.keys}
    for t in troubles:
        joined = [j for k in t.keys for j in fit.curves.joints_of.get(k, ())]
        near = {k for j in joined for k in (j.before, j.after) if k in in_trouble} | set(t.keys)
        lines, together = {line for k in near for line in fit.curves.rows[k].lines}, [t]
        for known in [g for g in groups if g[0] & lines]:
            groups.remove(known)
            lines |= known[0]
            together = known[1] + together
        groups.append((lines, together))
    return [g[1] for g in groups]
