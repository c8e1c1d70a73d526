"""Claims decided: evidence from the cache or the analyses, asked about at `hacheck`, granted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from haverify.evidence.evidence import Evidence
from haverify.evidence.grant import Answer, grant
from haverify.evidence.verdict import Trust, Unknown
from haverify.model.core import canonical
from haverify.model.spec import Spec
from haverify.run import cache, recheck
from haverify.run.beside import beside
from haverify.run.executors import Solved, solve
from haverify.run.folder import ReportFolder, certificate_file
from haverify.run.keys import Cones, code_hash
from haverify.text.record import field, holder, record


@record
class Plan:
    """What decides how a run goes, and nothing about what is claimed."""

    budget: Fraction
    jobs: int
    use_cache: bool
    grade: Trust
    base: Path  # the folder of the spec, from which its tables are found
    crosscheck: bool = True  # whether runs are simulated beside flowpipes and invariants


@holder
class Decided:
    """Granted evidence by claim; `faults` are certificates refused and other failures of ours."""

    evidence: dict[str, Evidence] = field(default_factory=dict)
    seconds: dict[str, tuple[float, float]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    is_interrupted: bool = False


def decide(spec: Spec, names: Sequence[str], core: Mapping[str, Any], folder: ReportFolder, plan: Plan) -> Decided:
    """The granted evidence of the named claims; certificates and cells are left in the folder.

    What the cache holds is asked about like fresh evidence, and what of it is refused is decided anew.
    """
    keys = _Keys(core, names)
    kept = keys.fetch() if plan.use_cache else {}
    solved = solve(spec, [n for n in names if n not in kept], plan.budget, plan.jobs, core)
    if plan.crosscheck:
        solved = beside(spec, solved)
    proposed = {**kept, **solved.evidence}
    try:
        answers = _ask(folder, proposed, plan.base)
        doubtful = [n for n in kept if n in answers and answers[n].word == "refused"]
        if doubtful:
            again = solve(spec, doubtful, plan.budget, plan.jobs, core)
            solved = solved.and_then(again)
            proposed = {n: e for n, e in proposed.items() if n not in doubtful} | again.evidence
            answers = _ask(folder, proposed, plan.base)
    except KeyboardInterrupt:  # nothing counts that hacheck has not answered for
        proposed, answers = {}, {}
        solved = Solved(is_interrupted=True)
    if plan.use_cache:
        keys.keep({n: e for n, e in solved.evidence.items() if n in answers and answers[n].word == "accepted"})
    return _granted(names, proposed, answers, solved, plan.grade, folder)


class _Keys:
    """The cache keys of claims: theirs, and those of the models they are about."""

    def __init__(self, core: Mapping[str, Any], names: Sequence[str]) -> None:
        cones = Cones(core, {"code": code_hash()})
        self._by_model: dict[str, dict[str, str]] = {}
        for name in names:
            self._by_model.setdefault(cones.model(name), {})[name] = cones.claim(name)

    def fetch(self) -> dict[str, Evidence]:
        return {n: e for model, claims in self._by_model.items() for n, e in cache.fetch(model, claims).items()}

    def keep(self, evidence: Mapping[str, Evidence]) -> None:
        for model, claims in self._by_model.items():
            if own := {n: evidence[n] for n in claims if n in evidence}:
                cache.keep(model, claims, own)


def _ask(folder: ReportFolder, proposed: Mapping[str, Evidence], base: Path) -> dict[str, Answer]:
    """Write the certificates of all that is proposed, and what `hacheck` answers for each."""
    written: dict[str, bool] = {}
    for name, e in proposed.items():
        folder.remove(certificate_file(name))
        if e.certificate is None or isinstance(e.verdict, Unknown):
            continue
        folder.add(certificate_file(name), canonical(e.certificate).decode())
        for cell, content in e.cells.items():
            if not written.get(cell):
                folder.add(f"certificates/cells/{cell}.json", canonical(content).decode())
                written[cell] = True
        written[f"claim {name}"] = True
    asked = [n for n in proposed if written.get(f"claim {n}")]
    if not asked:
        return {}
    answers = recheck.ask(folder.path, base)
    return {n: answers.get(n, Answer("refused", "hacheck did not mention it")) for n in asked}


def _granted(
    names: Sequence[str],
    proposed: Mapping[str, Evidence],
    answers: Mapping[str, Answer],
    solved: Solved,
    grade: Trust,
    folder: ReportFolder,
) -> Decided:
    decided = Decided({}, solved.seconds, list(solved.faults), solved.is_interrupted)
    for name in names:
        evidence = proposed.get(name) or _missing(solved)
        answer = answers.get(name)
        decided.evidence[name] = grant(evidence, answer, grade)
        if answer is not None and answer.word == "refused":
            folder.remove(certificate_file(name))
            decided.faults.append(f"{name}: hacheck refused the certificate: {answer.reason}")
    return decided


def _missing(solved: Solved) -> Evidence:
    if solved.is_interrupted:
        return Evidence(Unknown("interrupted", "the run was interrupted before this claim was decided"), (), "")
    return Evidence(Unknown("internal", "haverify failed on this claim; please report it"), (), "")
