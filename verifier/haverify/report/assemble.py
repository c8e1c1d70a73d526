"""A claim, its evidence and the judgement on it, brought into the words of the report."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

from haverify.evidence.evidence import Evidence, PartResult, Sensitivity
from haverify.evidence.verdict import Refuted, Unknown
from haverify.maths.digits import rational_text
from haverify.model import spec as model
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton
from haverify.report import report
from haverify.report.exit_codes import OK
from haverify.report.gate import Judgement, expected, word
from haverify.report.numbers import margin
from haverify.report.trace import describe_passages, describe_trace
from haverify.report.walk import describe
from haverify.text.record import record
from haverify.text.source import Source


@record
class Assembler:
    """The spec and its texts, from which names, places and numbers of the report come."""

    spec: model.Spec
    sources: Mapping[str, Source]

    @cached_property
    def cells(self) -> dict[str, model.Cell]:
        """The table cell behind each constant that comes from one."""
        return {cell.constant: cell for cell in self.spec.cells}

    @cached_property
    def automata(self) -> dict[str, HybridAutomaton]:
        """The automata by name."""
        return {a.name: a for a in self.spec.automata}

    def claim(
        self,
        claim: Claim,
        evidence: Evidence,
        judgement: Judgement,
        certificate: str | None,
        seconds: tuple[float, float],
    ) -> report.Claim:
        """Everything the report says of a claim."""
        verdict = evidence.verdict
        unknown = verdict if isinstance(verdict, Unknown) else None
        decided = None if isinstance(verdict, Unknown) else verdict
        return report.Claim(
            name=claim.name,
            automaton=claim.on,
            text=claim.text,
            path=claim.span.path if claim.span else None,
            line=self.line(claim),
            doc=claim.doc,
            verdict=word(verdict),
            expected=expected(claim),  # type: ignore[arg-type]
            because=claim.expect.because if claim.expect else None,
            ok=judgement.exit_code == OK,
            trust=decided.trust.name.lower() if decided and decided.trust else None,  # type: ignore[arg-type]
            parts=[self.part(p) for p in evidence.parts],
            rounding=_rounding(evidence),
            method=evidence.method,
            margin=margin(decided.margin) if decided else None,
            horizon=self.horizon(claim),
            assumptions=[self.text(e) for e in (*self.spec.assumptions, *claim.assume)],
            using=list(claim.using),
            certificate=certificate,
            run=self.run(claim, evidence),
            witness=dict(evidence.witness) if decided and evidence.witness else None,
            kind=unknown.kind if unknown else None,
            reason=unknown.reason if unknown else None,
            reached=unknown.reached or None if unknown else None,
            nearest=unknown.nearest or None if unknown else None,
            next_step=unknown.next_step or None if unknown else None,
            problems=[d.message.removeprefix(f"{claim.name}: ") for d in judgement.problems if d.code == "HA701"],
            notes=[*evidence.notes, *judgement.notes],
            wall_s=seconds[0],
            cpu_s=seconds[1],
        )

    def is_system(self, name: str | None) -> bool:
        """Whether a name is that of a system."""
        return any(s.name == name for s in self.spec.systems)

    def line(self, claim: Claim) -> int | None:
        """The line of a claim in its file."""
        if claim.span is None or claim.span.path not in self.sources:
            return None
        return self.sources[claim.span.path].position(claim.span.start)[0]

    def text(self, e: Expr) -> str:
        """An expression as written in the spec."""
        if e.span is None or e.span.path not in self.sources:
            return f"({e.op} ...)"
        return " ".join(self.sources[e.span.path].at(e.span).split())

    def horizon(self, claim: Claim) -> str | None:
        """The horizon as written: a time, a number of jumps, or both."""
        jumps = [f"{claim.jumps} jumps"] if claim.jumps is not None else []
        time = [self.text(claim.time)] if claim.time is not None else []
        return ", ".join(time + jumps) or None

    def part(self, p: PartResult) -> report.Part:
        """A part; where it is violated, with the table rows it reads."""
        is_decided = not isinstance(p.verdict, Unknown)
        return report.Part(
            mode=p.where,
            output=p.output,
            kind=p.kind,
            goal=p.goal + 1,
            text=p.text,
            verdict=word(p.verdict),
            margin=None if isinstance(p.verdict, Unknown) else margin(p.verdict.margin),
            facts=list(p.facts),
            cells=self.rows(p) if isinstance(p.verdict, Refuted) else [],
            reason=None if not isinstance(p.verdict, Unknown) else p.verdict.reason,
            sensitivities=[self.sensitivity(s) for s in p.sensitivities] if is_decided else [],
        )

    def rows(self, p: PartResult) -> list[str]:
        """The table rows that a part reads, as `file:row (first field of the row)`, in order."""
        cells = [self.cells[c] for c in p.constants if c in self.cells]
        return list(dict.fromkeys(self.row(cell) for cell in cells))

    def row(self, cell: model.Cell) -> str:
        """The place of a table row and what its first field calls it."""
        path = cell.span.path
        first = self.sources[path].line(cell.row).split(",")[0].strip() if path in self.sources else ""
        return f"{path}:{cell.row} ({first})" if first else f"{path}:{cell.row}"

    def sensitivity(self, s: Sensitivity) -> report.Sensitivity:
        """A sensitivity with the table cell behind the constant."""
        cell = self.cells.get(s.constant)
        place = f"{cell.span.path}:{cell.row}, column {cell.column}" if cell else None
        to_zero, rounding = (q if q is None else rational_text(q) for q in (s.to_zero, s.rounding))
        return report.Sensitivity(s.constant, place, rational_text(s.slope), to_zero, rounding)

    def run(self, claim: Claim, evidence: Evidence) -> report.Run | None:
        """The run that decides the claim: the evidence's own, else that of the first violated part."""
        has_run = evidence.trace is not None
        bad = next((p for p in evidence.parts if isinstance(p.verdict, Refuted) and (p.run or has_run)), None)
        if evidence.trace is not None and not isinstance(evidence.verdict, Unknown):
            return describe_trace(self.spec, claim.on or "", evidence.trace, bad.text if bad is not None else None)
        run = evidence.run or (bad.run if bad else None)
        if run is not None and run.path and not isinstance(evidence.verdict, Unknown) and self.is_system(claim.on):
            return describe_passages(self.spec, claim.on or "", run, bad.text if bad is not None else None)
        if run is None or claim.on not in self.automata or isinstance(evidence.verdict, Unknown):
            return None
        violation = bad.text if bad is not None else None
        return describe(self.spec, self.automata[claim.on], run, violation)


def _rounding(evidence: Evidence) -> report.Rounding | None:
    r = evidence.rounding
    return report.Rounding(word(r.verdict), margin(r.margin)) if r else None
