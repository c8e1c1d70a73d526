"""The figures of a claim on a flow: its flowpipe over time and as a portrait, with a few sampled runs."""

from __future__ import annotations

from haverify.report.figures import pipes, tubes
from haverify.report.figures.evaluate import Scope, scope
from haverify.report.figures.jumping import strokes
from haverify.report.figures.material import Figure, Json, Material, Undrawable
from haverify.report.figures.sampled import Trail, trails
from haverify.report.report import Claim
from haverify.text.record import replace

_PANELS = 4
_FEW = 3  # variables of which a pair shows much


def of_claim(material: Material, automaton: Json, claim: Json, c: Claim) -> list[Figure]:
    """The flowpipe behind a claim; of a claim that is not decided, as far as it got.

    Raises
    ------
    Undrawable      if there is none
    """
    if c.name not in material.flowpipes:
        raise Undrawable
    pipe = pipes.read(material.flowpipes[c.name])
    modes = {m["name"]: m for m in automaton["modes"]}
    s = scope(material, automaton, modes[pipe.pieces[0].mode])
    pipe = replace(pipe, end=min(pipe.end, pipes.horizon(claim, s)))
    variables = [v["name"] for v in automaton["vars"] if v["name"] in pipe.names]
    wanted = [n for n in pipes.read_by(claim, s) if n in variables] or variables
    levels = pipes.levels(claim, s)
    runs = _runs(material, automaton, s, pipe)
    guards = [g for e in automaton["edges"] for g in pipes.compared(e["guard"], s) if e["source"] in pipe.modes]
    units = {v["name"]: v.get("unit") or "1" for v in automaton["vars"]}
    said = {n: n if units[n] == "1" else f"{n} [{units[n]}]" for n in variables}
    told = _told(pipe, len(runs), bool(levels), bool(guards))
    title = f"Flowpipe of {c.name}"
    found = [
        Figure(
            f"flow_{c.name}",
            title,
            told,
            tubes.over_time(pipe, wanted[:_PANELS], said, [*levels, *guards], runs),
            c.name,
        )
    ]
    pair = _pair(variables, wanted)
    if pair is not None:
        drawing = tubes.portrait(pipe, pair, said, [*levels, *guards], runs)
        text = f"{pair[1]} over {pair[0]}; starts framed"
        found.append(Figure(f"portrait_{c.name}", f"Portrait of {c.name}", text, drawing, c.name))
    return found


def _runs(material: Material, automaton: Json, s: Scope, pipe: pipes.Pipe) -> list[Trail]:
    """Sampled runs: along each piece where nothing jumps, else from the start on."""
    if automaton["edges"]:
        return strokes(material, automaton, pipe)
    return [t for p in pipe.pieces for t in trails(s, p)][: max(5, len(pipe.pieces))]


def _told(pipe: pipes.Pipe, runs: int, has_levels: bool, has_guards: bool) -> str:
    count = len(pipe.pieces)
    said = [f"every run from the starts is in the areas at all instants shown, up to t = {pipe.end:g} s"]
    said += [f"{count} pieces"] if count > 1 else []
    said += ["a few sampled runs as lines"] if runs else []
    said += ["what the claim compares with dashed"] if has_levels else []
    said += ["guards dotted"] if has_guards else []
    return "; ".join(said)


def _pair(variables: list[str], wanted: list[str]) -> tuple[str, str] | None:
    """Two variables to draw over each other: those of the claim; its one and another where there are few."""
    if len(variables) < 2 or (len(wanted) < 2 and len(variables) > _FEW):
        return None
    chosen = wanted[:2] if len(wanted) > 1 else [wanted[0], next(n for n in variables if n != wanted[0])]
    first, second = sorted(chosen, key=variables.index)
    return first, second
