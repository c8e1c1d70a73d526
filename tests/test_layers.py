"""Imports point downwards; the checker stands alone; slow libraries load only where they are needed."""

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
VERIFIER = ROOT / "verifier"

# Who is on which layer: a package or module directly under `haverify`.
LAYERS = [
    {"text", "diagnostics", "errors", "maths"},
    {"syntax", "model"},
    {"elaborate"},
    {"obligations", "evidence"},
    {"solvers"},
    {"analyses", "lint", "simulate", "gait", "recordings", "fitting", "robot", "learn"},
    {"report"},
    {"repair"},
    {"run", "interop"},
    {"cli", "lsp", "__init__", "__main__"},
]
LAYER = {name: number for number, names in enumerate(LAYERS) for name in names}

# Siblings that must not know each other, and packages only the top may use.
STRANGERS = [("syntax", "model"), ("model", "syntax")]
DOMAINS = {"gait", "robot", "learn"}

# The one place (or two) where a third party comes in.
DOORS = {
    "haverify._kernel": {"haverify.maths.interval", "haverify.solvers.kernel", "haverify.solvers.runs"},
    "z3": {"haverify.solvers.z3"},
    "cvxpy": {"haverify.solvers.sdp"},
    "dask": {"haverify.run.executors"},
    "meshcat": {"haverify.run.replay_meshcat"},
    "opensim": {"haverify.fitting.posed"},
    "pinocchio": {"haverify.robot.mechanics"},
}

SLOW = {"sympy", "scipy", "cvxpy", "matplotlib", "pinocchio", "networkx", "numpy", "z3", "msgspec"}
NEEDLESS = {"dataclasses", "inspect", "concurrent", "multiprocessing", "subprocess", "logging"}  # of the library
DISTRIBUTIONS = {"z3": "z3-solver", "pinocchio": "pin"}


@dataclass(frozen=True)
class Arrow:
    """One import: who, whom, on which line, and whether it happens when the importer is loaded."""

    source: str
    target: str
    line: int
    at_load: bool

    def __str__(self) -> str:
        return f"{self.source}:{self.line} imports {self.target}"


def module_name(path: Path) -> str:
    parts = path.relative_to(VERIFIER).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 2 else parts)


def is_module(dotted: str) -> bool:
    path = VERIFIER.joinpath(*dotted.split("."))
    return path.is_dir() or any(path.with_suffix(suffix).is_file() for suffix in (".py", ".pyi"))


def targets(node: ast.stmt, package: str) -> list[str]:
    """The modules a statement imports; `from package import name` means a module of that name if there is one."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if not isinstance(node, ast.ImportFrom):
        return []
    parents = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
    base = ".".join([*parents, *([node.module] if node.module else [])])
    return [f"{base}.{alias.name}" if is_module(f"{base}.{alias.name}") else base for alias in node.names]


def is_type_checking(node: ast.stmt) -> bool:
    return isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)


def arrows_of(path: Path) -> Iterator[Arrow]:
    source, package = module_name(path), ".".join(path.parent.relative_to(VERIFIER).parts)
    pending = [(node, True) for node in ast.parse(path.read_text(encoding="utf-8")).body]
    while pending:
        node, at_load = pending.pop()
        if isinstance(node, ast.stmt):
            yield from (Arrow(source, target, node.lineno, at_load) for target in targets(node, package))
        deferred = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) or is_type_checking(node)
        pending.extend((child, at_load and not deferred) for child in ast.iter_child_nodes(node))


def arrows(package: str) -> list[Arrow]:
    return [arrow for path in sorted((VERIFIER / package).rglob("*.py")) for arrow in arrows_of(path)]


HAVERIFY = arrows("haverify")
HACHECK = arrows("hacheck")


def root(dotted: str) -> str:
    return dotted.split(".")[0]


def part(dotted: str) -> str:
    """The package or module directly under haverify; `__init__` for haverify itself."""
    return [*dotted.split("."), "__init__"][1]


INSIDE = [arrow for arrow in HAVERIFY if root(arrow.target) == "haverify" and arrow.target != "haverify._kernel"]


def listed(found: list[Arrow]) -> str:
    return "\n".join(map(str, found))


def test_every_part_of_haverify_has_a_layer() -> None:
    parts = {part(module_name(path)) for path in (VERIFIER / "haverify").rglob("*.py")}
    assert parts <= LAYER.keys()


def test_there_are_arrows_to_judge() -> None:
    assert len(INSIDE) > 10
    assert any(not arrow.at_load for arrow in HAVERIFY)


def test_imports_point_downwards() -> None:
    upwards = [arrow for arrow in INSIDE if LAYER[part(arrow.target)] > LAYER[part(arrow.source)]]
    assert not upwards, listed(upwards)


def test_syntax_and_model_do_not_know_each_other() -> None:
    known = [arrow for arrow in INSIDE if (part(arrow.source), part(arrow.target)) in STRANGERS]
    assert not known, listed(known)


def test_only_the_top_uses_domain_packages() -> None:
    used = [
        arrow
        for arrow in INSIDE
        if part(arrow.target) in DOMAINS and part(arrow.source) != part(arrow.target) and LAYER[part(arrow.source)] < 7
    ]
    assert not used, listed(used)


def test_third_parties_come_in_by_their_doors() -> None:
    around = [
        arrow
        for arrow in HAVERIFY
        for door in (arrow.target if arrow.target == "haverify._kernel" else root(arrow.target),)
        if door in DOORS and arrow.source not in DOORS[door]
    ]
    assert not around, listed(around)


def test_slow_libraries_are_imported_inside_functions() -> None:
    eager = [arrow for arrow in HAVERIFY if arrow.at_load and root(arrow.target) in SLOW]
    allowed = {"z3", "msgspec"}  # in modules imported late, as the everyday commands below show
    assert not [arrow for arrow in eager if root(arrow.target) not in allowed], listed(eager)


def test_every_third_party_is_a_declared_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    declared = [*project["dependencies"], *(r for name in extras if name != "test" for r in extras[name])]
    names = {requirement.split(">=")[0] for requirement in declared}
    foreign = [arrow for arrow in HAVERIFY if root(arrow.target) not in {*sys.stdlib_module_names, "haverify"}]
    assert foreign
    undeclared = [arrow for arrow in foreign if DISTRIBUTIONS.get(root(arrow.target), root(arrow.target)) not in names]
    assert not undeclared, listed(undeclared)


def test_the_checker_imports_the_standard_library_only() -> None:
    foreign = [arrow for arrow in HACHECK if root(arrow.target) not in {*sys.stdlib_module_names, "hacheck"}]
    assert not foreign, listed(foreign)


def test_haverify_imports_nothing_of_the_checker() -> None:
    used = [arrow for arrow in HAVERIFY if root(arrow.target) == "hacheck"]
    assert not used, listed(used)


def loaded_by(arguments: list[str]) -> set[str]:
    """The top-level modules in memory after a call of the command, or after `import haverify` without one."""
    call = "import haverify\n"
    if arguments:
        call += f"sys.argv = {['haverify', *arguments]!r}\nfrom haverify.cli import main\n"
        call += "try:\n    main()\nexcept SystemExit:\n    pass\n"
    script = f"import sys\n{call}print('\\n' + ' '.join(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    return {root(name) for name in run.stdout.splitlines()[-1].split()}


SPECS = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "spec").glob("*.ha"))]
CALLS = [["--help"], ["lint", *SPECS], ["fmt", "--check", *SPECS]] if is_module("haverify.cli") else []


@pytest.mark.parametrize("arguments", [[], *CALLS], ids=lambda arguments: " ".join(arguments[:1]) or "import")
def test_everyday_commands_load_nothing_slow(arguments: list[str]) -> None:
    loaded = loaded_by(arguments)
    assert "haverify" in loaded
    assert not loaded & (SLOW | NEEDLESS)
