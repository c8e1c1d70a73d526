"""What the Rust kernel offers; `maths/interval.py` and `solvers/kernel.py` are its only callers."""

from collections.abc import Sequence

Pair = tuple[float, float]
Listing = tuple[list[tuple[str, int, int]], list[Pair], list[int]]

class Fault(ArithmeticError):
    """Why an operation has no enclosure to give."""

def source_hash() -> str: ...
def unary(name: str, x: Pair) -> Pair: ...
def binary(name: str, x: Pair, y: Pair) -> Pair: ...
def power(x: Pair, exponent: int) -> Pair: ...
def interval(low: float, high: float) -> Pair: ...
def enclose(numerator: int, denominator: int) -> Pair: ...
def halt(is_halted: bool) -> None: ...
def width(x: Pair) -> float: ...
def midpoint(x: Pair) -> float: ...
def flowpipe(
    field: Listing,
    start: list[Pair],
    horizon: Pair,
    watched: Listing,
    limits: list[Pair],
    order_degree_steps_depth: tuple[int, int, int, int],
    tolerance_first_longest_least: tuple[float, float, float, float],
) -> tuple[list[tuple[Pair, float, list[Pair], list[Pair]]], str, list[Pair]]: ...

Comparisons = list[tuple[int, str]]
Words = list[tuple[str, int]]
EdgeListing = tuple[int, bool, Comparisons, Listing, int, Listing, Words]
ModeListing = tuple[Listing, list[Pair], Listing, Comparisons, Comparisons, Words, Words, Words, list[EdgeListing]]
Judged = tuple[bool, bool, Pair | None, Pair | None]
JumpRow = tuple[int, Pair, list[Pair], list[Pair], Judged]
StepRow = tuple[Pair, list[Pair], list[Pair], Judged, bool, bool]
StretchRow = tuple[int | None, int, int, bool, JumpRow | None, list[StepRow], str, list[Pair]]

class Tree:
    def rows(self) -> list[StretchRow]: ...
    def judged(self, modes: Sequence[ModeListing], known: Comparisons, middle: bool) -> list[StretchRow]: ...
    def records(
        self,
    ) -> list[
        tuple[int | None, int, int | None, str, list[tuple[list[list[int]], tuple[float, list[list[list[float]]]]]]]
    ]: ...
    def size(self) -> int: ...

def reach(
    modes: Sequence[ModeListing],
    start: tuple[int, list[Pair], Comparisons],
    horizon: float,
    until: str,
    order_degree_steps_depth: tuple[int, int, int, int],
    tolerance_first_longest_least: tuple[float, float, float, float],
    jumps_stretches_cuts: tuple[int, int, int],
) -> Tree: ...
def units(series: list[list[list[float]]], length: float, bits: int) -> list[list[list[int]]]: ...
def along(
    positions: Listing,
    readout: Listing,
    derivatives: int,
    time: Pair,
    widths: list[float],
    order_depth_stretches: tuple[int, int, int],
) -> list[tuple[float, float, list[Pair] | None]]: ...

class Record:
    def end(self) -> tuple[str, float, int, list[float], float, int]: ...
    def jumps(self) -> list[tuple[float, int, list[float], list[float]]]: ...
    def pieces(self) -> list[tuple[int, int, float, float, list[list[float]], list[list[float]]]]: ...
    def robustness(self, formula: list[tuple[str, int, float, float]]) -> float: ...
    def sample(self, times: list[float]) -> list[tuple[float, int, int, list[float], list[float]]]: ...

class Simulator:
    def __init__(
        self,
        modes: list[
            tuple[
                list[tuple[str, list[int], float]],
                int,
                list[int | None],
                list[Words],
                Words,
                bool,
                list[int],
                list[int],
                list[int],
            ]
        ],
        edges: list[tuple[int, bool, Words, list[tuple[int, int, int | None]], list[int]]],
        variables: int,
        clock: int | None,
    ) -> None: ...
    def run(
        self,
        plan: tuple[
            int, list[float], float, tuple[int, int, int], str, int, list[float], list[tuple[float, int, float]]
        ],
    ) -> Record: ...
    def ends(
        self,
        plans: list[
            tuple[int, list[float], float, tuple[int, int, int], str, int, list[float], list[tuple[float, int, float]]]
        ],
    ) -> list[tuple[str, float, int, int, list[float]]]: ...
    def robustness(
        self,
        plans: list[
            tuple[int, list[float], float, tuple[int, int, int], str, int, list[float], list[tuple[float, int, float]]]
        ],
        formula: list[tuple[str, int, float, float]],
    ) -> list[float]: ...
    def values(self, mode: int, state: list[float]) -> list[float]: ...
    def slopes(self, mode: int, state: list[float]) -> list[float]: ...
