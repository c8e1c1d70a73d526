"""What figures are drawn from: the core and the cells of a report folder, as they stand in its files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from haverify.text.record import field, record

Json = dict[str, Any]


class Undrawable(Exception):
    """What was asked for has no figure: a quantity that cannot be computed, a state with too many variables."""


@record
class Material:
    """`core.json`, by automaton `certificates/cells/*.json`, by claim `flowpipes/*.json`; may be missing or foreign.

    Figures illustrate. They are drawn from rounded numbers and nothing rests on them.
    """

    core: Json = field(default_factory=dict)
    cells: dict[str, Json] = field(default_factory=dict)
    scopes: dict[tuple[str, str], Any] = field(default_factory=dict, compare=False)  # what is computed once
    points: dict[tuple[str, str], Any] = field(default_factory=dict, compare=False)
    index: dict[str, dict[str, Json]] = field(default_factory=dict, compare=False)
    flowpipes: dict[str, Json] = field(default_factory=dict)
    figures: dict[str, list[Figure]] = field(default_factory=dict, compare=False)  # by what they are of

    def drawn_once(self, of: str, draw: Callable[[], list[Figure]]) -> list[Figure]:
        """The figures of something, drawn when first asked for."""
        if of not in self.figures:
            self.figures[of] = draw()
        return self.figures[of]

    def listed(self, key: str) -> list[Json]:
        """The objects of a list of the core; those of another kind are left out."""
        found = self.core.get(key)
        return [x for x in found if isinstance(x, dict)] if isinstance(found, list) else []

    def named(self, key: str, name: str | None) -> Json | None:
        """The object of that name in a list of the core."""
        return self.by_name(key).get(name) if name is not None else None

    def by_name(self, key: str) -> dict[str, Json]:
        """The objects of a list of the core that have a name."""
        if key not in self.index:
            self.index[key] = {x["name"]: x for x in self.listed(key) if isinstance(x.get("name"), str)}
        return self.index[key]


@record
class Figure:
    """A drawing with what it shows: `name` is a file name's stem, `claim` the claim it belongs to."""

    name: str
    title: str
    caption: str
    svg: str
    claim: str | None = None
