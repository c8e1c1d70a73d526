"""A motion that `haverify simulate` wrote, read by OpenSim: `python opensim_reads.py OUT.mot SPEC.csv`.

Runs in an environment of its own, with OpenSim and without haverify (`make test-opensim`). The table of the same run
says what the columns have to be; both readers of OpenSim, the old storage and the table, are asked.
"""

from __future__ import annotations

import csv
import sys

import opensim

CLOSE = 1e-9  # deg; a motion has ten decimals
ANGLES = " [deg]"


def expected(path: str) -> dict[float, dict[str, float]]:
    """The angles after the last jump of each instant, from the table of text."""
    found: dict[float, dict[str, float]] = {}
    with open(path, newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            angles = {k.removesuffix(ANGLES): float(v) for k, v in row.items() if k.endswith(ANGLES)}
            found[float(row["time [s]"])] = angles
    return found


def main() -> int:
    motion, table = sys.argv[1:3]
    storage, read = opensim.Storage(motion), opensim.TimeSeriesTable(motion)
    labels = list(read.getColumnLabels())
    stored = [storage.getColumnLabels().get(i) for i in range(storage.getColumnLabels().getSize())]
    times = [float(t) for t in read.getIndependentColumn()]
    assert stored == ["time", *labels] and storage.getSize() == len(times), (stored, labels, storage.getSize())
    assert storage.isInDegrees() and read.getTableMetaDataString("inDegrees") == "yes"
    told, worst, looked = expected(table), 0.0, 0
    for row, t in enumerate(times):
        of_table = read.getRowAtIndex(row)
        of_storage = storage.getStateVector(row).getData()
        angles = told[min(told, key=lambda known: abs(known - t))]
        for column, label in enumerate(labels):
            worst = max(worst, abs(of_table[column] - angles[label]), abs(of_storage.get(column) - angles[label]))
            looked += 1
    read_back = f"{len(times)} rows, {len(labels)} angles, {looked} values, off by {worst:.1e} deg"
    print(f"OpenSim {opensim.GetVersion()}: {read_back}")
    return 0 if looked and worst <= CLOSE else 1


if __name__ == "__main__":
    sys.exit(main())
