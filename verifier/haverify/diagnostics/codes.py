"""The catalogue: every code haverify may use, and the manual page of each that this version can report.

Codes are stable and never reused. A code has a page, `pages/<code>.md`, from the version on that can report it; the
page says why the finding matters, with a bad example (which yields the code) and a good one (which does not).
"""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.text.record import record


@record
class Code:
    """An entry of the catalogue.

    `how` the check decides (syn, int, smt, graph, sim, sym); `fix` is `S` (safe, applied by `--fix`), `P` (proposed,
    applied by `--unsafe-fixes`) or empty. Where `is_meaningless`, the affected part of the spec has no meaning: its
    claims are unknown and the exit code is 2. Any other error is a fault of a well-defined model: exit code 1.
    """

    code: str
    name: str
    severity: Severity
    how: str
    fix: str
    is_meaningless: bool


_SEVERITIES = {"E": Severity.ERROR, "W": Severity.WARNING, "I": Severity.INFORMATION, "U": Severity.VERDICT}

_MEANINGLESS_FAMILIES = ("HA0", "HA1")
_MEANINGLESS = ("HA210", "HA211", "HA224", "HA504", "HA601", "HA608")

_ROWS = (
    ("HA001", "unexpected token", "E", "syn", ""),
    ("HA002", "unknown name", "E", "syn", "P"),
    ("HA003", "dangling operator or unclosed block", "E", "syn", ""),
    ("HA004", "name defined twice", "E", "syn", ""),
    ("HA005", "unused variable, constant, parameter, term or enum value", "W", "syn", "S"),
    ("HA006", "import cycle or missing file", "E", "syn", ""),
    ("HA007", "variable without a flow in a mode", "E", "syn", "P"),
    ("HA008", "algebraic loop: lets or ports that depend on each other with no variable between", "E", "graph", ""),
    ("HA009", "index outside its enum", "E", "syn", ""),
    ("HA101", "unit mismatch", "E", "syn", "P"),
    ("HA102", "degrees passed where radians are meant", "E", "syn", "S"),
    ("HA103", "flow unit is not variable unit per second", "E", "syn", ""),
    ("HA104", "exponent or logarithm of a quantity with a unit", "E", "syn", ""),
    ("HA105", "type mismatch (bool, enum, quantity)", "E", "syn", ""),
    ("HA106", "data or robot file without a declared angle unit", "E", "syn", ""),
    ("HA107", "name shadows a unit in a quantity", "W", "syn", ""),
    ("HA108", "value implausible for its unit", "W", "int", "P"),
    ("HA201", "empty interval / backwards bounds", "E", "int", "P"),
    ("HA202", "contradictory conjunction (domain, guard, init or assumption)", "E", "smt", ""),
    ("HA203", "time ranges not increasing", "E", "int", "P"),
    ("HA204", "gap or overlap between consecutive time slots", "W", "int", "S"),
    ("HA205", "open/closed bound mismatch at a shared boundary", "I", "syn", "S"),
    ("HA210", "table row or column missing, duplicated or not numeric", "E", "syn", ""),
    ("HA211", "table key not in enum", "E", "syn", "P"),
    ("HA212", "output leaves the declared range inside its own slot", "W", "int", "P"),
    ("HA213", "discontinuity at a jump without a reset", "W", "int", "P"),
    ("HA214", "rounding of printed coefficients exceeds the margin", "W", "int", ""),
    ("HA215", "data file changed since its hash was recorded", "W", "syn", "S"),
    ("HA216", "polynomial evaluated outside its fitted range", "W", "int", ""),
    ("HA221", "the header of a recording contradicts its rows", "W", "syn", ""),
    ("HA222", "samples of a recording are missing", "W", "syn", ""),
    ("HA223", "a recording is turned: sign of the knee, direction of the walk", "W", "int", ""),
    ("HA224", "a recording lacks what a walk needs", "E", "int", ""),
    ("HA225", "left and right may be exchanged in a recording", "W", "int", ""),
    ("HA226", "events of a recording are missing or contradict one another", "I", "int", ""),
    ("HA227", "samples of a recording leap away from their neighbours", "W", "int", ""),
    ("HA228", "a declared bound contradicts the recording", "W", "int", ""),
    ("HA301", "unreachable mode", "W", "graph, then int", ""),
    ("HA302", "guard never enabled", "W", "smt", "P"),
    ("HA303", "time-lock: domain left with no edge enabled", "E", "smt", ""),
    ("HA304", "overlapping guards: nondeterministic choice", "W", "smt", ""),
    ("HA305", "may edge where a must edge was likely meant", "I", "smt", "S"),
    ("HA306", "reset lands outside the target's domain", "E", "smt", "P"),
    ("HA307", "init outside domain / empty init", "E", "smt", ""),
    ("HA308", "init partly outside domain", "W", "smt", ""),
    ("HA309", "mode without outgoing edge and not `terminal`", "I", "graph", "S"),
    ("HA310", "domain cannot be left and no horizon given", "I", "smt", ""),
    ("HA311", "counter leaves its range", "E", "smt", "P"),
    ("HA312", "priorities form a cycle", "E", "graph", ""),
    ("HA313", "a priority silences an edge for good", "W", "smt", ""),
    ("HA401", "Zeno risk: a cycle may take arbitrarily short time", "W", "smt/sim", ""),
    ("HA402", "instantaneous cycle", "E", "smt", "P"),
    ("HA403", "flow not Lipschitz or undefined in the domain", "W", "int", ""),
    ("HA404", "guard grazed (tangential crossing)", "I", "int", ""),
    ("HA405", "finite escape possible before the horizon", "W", "int", ""),
    ("HA406", "energy-like quantity not conserved although its twin is", "I", "sym", "P"),
    ("HA501", "rule table not total", "E", "smt", ""),
    ("HA502", "two rules for one cell, different results", "E", "smt", ""),
    ("HA503", "duplicate rule", "W", "syn", "S"),
    ("HA504", "rule result outside the cell set", "E", "smt", ""),
    ("HA505", "two descriptions of the same relation disagree", "W", "smt", ""),
    ("HA506", "two codes with one name / one code with two names", "W", "syn", ""),
    ("HA510", "fuzzy input not covered", "W", "smt", ""),
    ("HA511", "no rule fires", "W", "smt", ""),
    ("HA512", "contradictory conclusions from equal premises", "E", "smt", ""),
    ("HA513", "rule never dominant", "I", "smt", ""),
    ("HA514", "output term that no rule produces", "W", "syn", ""),
    ("HA601", "claim refers to an output not defined in every mode", "E", "syn", ""),
    ("HA602", "vacuous claim: premise never true", "W", "smt/int", ""),
    ("HA603", "contradictory assumptions", "E", "smt", ""),
    ("HA604", "tautology or claim independent of the model", "W", "smt", ""),
    ("HA605", "invariant true but not inductive", "U", "smt", "P"),
    ("HA606", "horizon shorter than one pass through the modes", "W", "int", ""),
    ("HA607", "claim without `expect`", "I", "syn", "S"),
    ("HA608", "`using` in a circle, or of a claim that is no invariant", "E", "syn", ""),
    ("HA701", "verdict, or the set of violated parts, differs from what is expected", "E", "", ""),
    ("HA702", "unknown: resource limit", "U", "", ""),
    ("HA703", "unknown: enclosure too wide", "U", "", ""),
    ("HA704", "refuted only inside rounding or delta", "U", "", ""),
    ("HA705", "two engines disagree", "E", "", ""),
    ("HA706", "counterexample does not replay", "E", "", ""),
    ("HA707", "unknown: a run leaves the declared range of a variable", "U", "", ""),
    ("HA708", "unknown: jump limit reached", "U", "", ""),
    ("HA801", "baseline entry no longer matches anything", "W", "syn", "S"),
    ("HA802", "suppression without a reason / unused suppression", "W", "syn", "S"),
    ("HA900", "check could not decide", "I", "", ""),
)


def _entry(row: tuple[str, str, str, str, str]) -> Code:
    code, name, severity, how, fix = row
    has_no_meaning = severity == "E" and (code.startswith(_MEANINGLESS_FAMILIES) or code in _MEANINGLESS)
    return Code(code, name, _SEVERITIES[severity], how, fix, has_no_meaning)


CATALOGUE: dict[str, Code] = {row[0]: _entry(row) for row in _ROWS}


def severity(d: Diagnostic) -> Severity:
    """The severity of a finding: its own, else that of its code."""
    return d.severity or CATALOGUE[d.code].severity


def is_error(d: Diagnostic) -> bool:
    """Whether a finding is an error."""
    return severity(d) is Severity.ERROR


def is_meaningless(d: Diagnostic) -> bool:
    """Whether a finding says that a part of the spec has no meaning (exit code 2)."""
    return is_error(d) and CATALOGUE[d.code].is_meaningless


_PAGES = Path(__file__).parent / "pages"


def pages() -> list[str]:
    """The codes that have a page, which are those this version can report, in order."""
    return sorted(file[:-3] for file in os.listdir(_PAGES) if file.startswith("HA") and file.endswith(".md"))


@cache
def page(code: str) -> str:
    """The manual page of a code, in Markdown.

    Raises
    ------
    KeyError        if the code is not in the catalogue or has no page in this version
    """
    if code not in CATALOGUE:
        raise KeyError(code)
    try:
        return (_PAGES / f"{code}.md").read_text(encoding="utf-8")
    except FileNotFoundError:
        raise KeyError(code) from None
