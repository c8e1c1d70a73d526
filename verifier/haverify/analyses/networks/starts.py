"""The initial states of a network, before time passes (LANGUAGE S5)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from typing import Any

from haverify.analyses.networks.naming import Place
from haverify.analyses.networks.network import Network, between
from haverify.analyses.networks.terms import TIME, State
from haverify.analyses.networks.zones import Formula, Zone, conjunction
from haverify.obligations.translate import OutsideFragmentError

Json = Any
UNBOUNDED = 1 << 60


def starts(net: Network) -> Iterator[tuple[State, Zone]]:
    """The initial states, before time passes (S5)."""
    choices = [[(p, line, m) for line in _lines(p) for m in _modes(p, line)] for p in net.places]
    for chosen in product(*choices):
        net.effort.spend(100)
        known = {r["var"]: r for p, line, _ in chosen for r in p.resets(line["with"])}
        modes = {p.prefix: m for p, _, m in chosen if m is not None}
        free = [n for n in net.slots if n not in modes]
        where = [p.flat(line["where"]) for p, line, _ in chosen]
        for values in product(*(_values(net, n, known.get(n)) for n in free)):
            given = modes | dict(zip(free, values, strict=True))
            s = tuple(given[n] for n in net.slots)
            held = conjunction(net.terms.truth(w, s) for w in where)
            yield from ((s, z) for z in _zones(net, s, known, held))


def _values(net: Network, name: str, r: Json) -> list[Fraction]:
    values, window = net.values(name), net.windows.get(name, (None, None))
    if r is None and values is not None:
        return values
    low, high = window if r is None else net.ends(r, ())
    if values is None and (low is None or low != high):
        raise OutsideFragmentError(
            f"`{name}` starts with any value of a range, and no flow changes it: give it one value"
        )
    return [low] if values is None and low is not None else [v for v in values or () if between(low, v, high)]


def _zones(net: Network, s: State, known: Mapping[str, Json], where: Formula) -> Iterator[Zone]:
    z = net.in_domain(s, net.space.everything)
    if z is None:
        return
    ends = {n: net.ends(known[n], ()) for n in net.clocks if n in known}
    ends |= {TIME: (Fraction(0), Fraction(0))} if net.is_timed else {}
    given = conjunction([where, *(net.terms.clock_bounds(n, *e) for n, e in ends.items())])
    for part in net.space.meet(z, given):
        bounds = [net.terms.clock_bounds(n, *_missing(net, n, c, part)) for n, c in net.clocks.items()]
        found = list(net.space.meet(part, conjunction(bounds)))
        if not found:
            raise OutsideFragmentError("a start outside the declared ranges, beyond which nothing is followed")
        yield from found


def _missing(net: Network, name: str, clock: int, z: Zone) -> tuple[Fraction | None, Fraction | None]:
    """The ends of a clock's declared range where nothing else bounds it (S5); None where something does."""
    is_open = [z[clock] > UNBOUNDED, z[clock * net.space.n] > UNBOUNDED]
    ends = net.windows.get(name, (None, None))
    if net.terms.rates.get(name, Fraction(1)) < 0:
        is_open.reverse()
    if any(o and e is None for o, e in zip(is_open, ends, strict=True)):
        raise OutsideFragmentError(f"`{name}` starts anywhere")
    low, high = (e if o else None for o, e in zip(is_open, ends, strict=True))
    return low, high


def _lines(p: Place) -> list[Json]:
    found: list[Json] = p.model["init"] or [{"mode": None, "where": True, "with": []}]
    return found


def _modes(p: Place, line: Json) -> list[str | None]:
    return [m["name"] for m in p.model["modes"] if line["mode"] in (None, m["name"])] if p.is_automaton else [None]
