"""The facts of a report, in the shape in which `report.json` holds them: field names are its keys.

Exact numbers are strings (`"106594/5"`), with a decimal beside them where people read them. Every other format is a
view of these facts and adds none. `docs/report.schema.json` is made from these classes.
"""

from __future__ import annotations

from typing import Literal

from haverify.text.record import field, record

SCHEMA = "haverify.report/1"

Word = Literal["proved", "refuted", "unknown"]


@record
class Tool:
    """Who made the report: versions of the tool, its kernel (a hash of its source) and the solvers used."""

    name: str
    version: str
    kernel: str
    solvers: dict[str, str]


@record
class InputFile:
    """A file that was read: a spec, an import, a table."""

    path: str
    sha256: str


@record
class Label:
    """A further place of a finding and what it has to say there; of an edit: the text that replaces it."""

    path: str
    line: int
    column: int
    end_line: int
    end_column: int
    text: str


@record
class Finding:
    """A finding with its place; `accepted` is the reason for which `@allow` or `haverify.lock` accepts it.

    `fingerprint` stays the same when lines move; `excerpt` shows the places with carets; `edits` make up the fix.
    """

    code: str
    name: str
    severity: str
    message: str
    path: str | None
    line: int | None
    column: int | None
    end_line: int | None
    end_column: int | None
    notes: list[str]
    help: str | None
    fix: str | None
    accepted: str | None
    accepted_in: Literal["source", "lock"] | None = None
    fingerprint: str = ""
    excerpt: list[str] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    edits: list[Label] = field(default_factory=list)


@record
class Margin:
    """Signed distance to the bound. `value` is a rational, or an interval where the extremum is at a root."""

    value: str | list[str]
    decimal: str
    unit: str
    at: str


@record
class Sensitivity:
    """How a margin depends on a constant: d(margin)/d(value), the change that brings it to 0, the share of rounding."""

    constant: str
    place: str | None
    slope: str
    to_zero: str | None
    rounding: str | None


@record
class Part:
    """A part of a claim. `mode` is a mode or, for a jump, `source -> target`; `cells` are the table rows it reads."""

    mode: str
    output: str
    kind: str
    goal: int
    text: str
    verdict: Word
    margin: Margin | None
    facts: list[str]
    cells: list[str]
    reason: str | None
    sensitivities: list[Sensitivity]


@record
class Rounding:
    """The verdict for every model that rounds to the numbers as printed."""

    verdict: Word
    margin: Margin | None


@record
class Run:
    """A run: modes in order, the instant each is entered and the last instant, the state at each of these instants.

    `states` are exact: a truth value is 0 or 1, a value of an enumeration the number it counts as (its position from
    0, or the integer itself). `states_decimal` is for people: rounded decimals, and names where values have names.
    `units` has the unit of each variable and param that has one; times are in s.
    """

    mode_path: list[str]
    edges: list[str]
    times: list[str]
    times_decimal: list[str]
    states: list[dict[str, str]]
    states_decimal: list[dict[str, str]]
    params: dict[str, str]
    units: dict[str, str]
    violation: str | None


@record
class Claim:
    """A claim and what is known of it. `ok`: the verdict is the expected one; `problems` says what is not.

    `because` is the reason that its `expect` gives, `witness` the values that decide a claim without time.
    """

    name: str
    automaton: str | None
    text: str
    path: str | None
    line: int | None
    doc: str
    verdict: Word
    expected: Word
    because: str | None
    ok: bool
    trust: Literal["checked", "enclosed", "solver"] | None
    parts: list[Part]
    rounding: Rounding | None
    method: str
    margin: Margin | None
    horizon: str | None
    assumptions: list[str]
    using: list[str]
    certificate: str | None
    run: Run | None
    witness: dict[str, str] | None
    kind: str | None
    reason: str | None
    reached: str | None
    nearest: str | None
    next_step: str | None
    problems: list[str]
    notes: list[str]
    wall_s: float
    cpu_s: float


@record
class Summary:
    """Counts, and the exit code of the run for this file."""

    proved: int
    refuted: int
    unknown: int
    ok: int
    errors: int
    warnings: int
    accepted: int
    exit_code: int


@record
class Report:
    """What a run found out about one spec. `hash` covers core, data, options and versions: same hash, same verdicts."""

    schema: Literal["haverify.report/1"]
    spec: str
    title: str
    tool: Tool
    inputs: list[InputFile]
    options: dict[str, str]
    hash: str
    complete: bool
    wall_s: float
    cpu_s: float
    findings: list[Finding]
    claims: list[Claim]
    summary: Summary
