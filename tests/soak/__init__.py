"""Sampled runs against enclosures; the linear algebra of numpy, which is imported later, stays in one thread.

Its threads wait for each other in loops: sums over some thousand runs need twice the time with two of them.
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
