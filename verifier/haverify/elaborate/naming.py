"""The names that declarations have in the core, where one name means one thing."""

from __future__ import annotations

from collections.abc import Callable

from haverify.elaborate.context import Context


def once(make: Callable[[str], str]) -> Callable[[str], str]:
    """`make`, asked once for each name: the members of a family, declared one by one, are one family in the core."""
    known: dict[str, str] = {}

    def name_of(name: str) -> str:
        if name not in known:
            known[name] = make(name)
        return known[name]

    return name_of


def own_names(ctx: Context, machine: str) -> Callable[[str], str]:
    """The core names of what the automaton or system `machine` declares.

    A declaration hides what the top level calls the same. Params of the top level, constants that read what is hidden
    and assumptions are still there, so what hides gets another name, `MACHINE_name`.
    """
    return once(lambda name: ctx.fresh(f"{machine}_{name}") if name in ctx.shared else name)
