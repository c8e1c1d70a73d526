# `make demo` runs the main job, `make test` the tests; both set up everything they need in .venv.
PYTHON ?= python3
VENV   := .venv
OPENSIM := .venv-opensim
HEYOKA := .venv-heyoka
BIN    := $(VENV)/bin
CRATE  := verifier/kernel/Cargo.toml
STAMP  := $(VENV)/.installed
RUST   := $(shell find verifier/kernel -name target -prune -o -name '*.rs' -print)

export MATURIN_NO_INSTALL_RUST = 1
export PIP_DISABLE_PIP_VERSION_CHECK = 1
# pip without isolation finds the pinned maturin on the path
export PATH := $(CURDIR)/$(BIN):$(PATH)

# Times of files can lie (a restored backup, a library deleted by hand); interval.py compares contents.
FRESH := $(shell $(BIN)/python -c 'import haverify.maths.interval' 2>/dev/null && echo yes)

.PHONY: all demo test lint bench bench-reach bench-sim bench-invariants test-opensim soak clean stale
all: $(STAMP)

# Python edits apply at once; an edit of the kernel makes the stamp old, and interval.py refuses an old kernel.
$(STAMP): pyproject.toml constraints.txt .cargo/config.toml $(CRATE) verifier/kernel/Cargo.lock $(RUST) $(if $(FRESH),,stale)
	$(BIN)/python -m pip --version >/dev/null 2>&1 || $(PYTHON) -m venv --clear $(VENV)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt maturin
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --no-build-isolation --editable '.[test]'
	$(BIN)/python -m compileall -q verifier
	touch $@

# Makes cargo look at the contents again.
stale:
	touch verifier/kernel/build.rs

# Bytecode is written here once, also where Python is told to write none: starting without it takes twice the time.
demo: $(STAMP)
	@$(BIN)/python -m compileall -q verifier
	$(BIN)/haverify check spec/gait_printed.ha spec/gait.ha

test: $(STAMP)
	cargo test --quiet --locked --manifest-path $(CRATE)
	$(BIN)/python -m pytest --numprocesses logical --maxprocesses 4 --dist worksteal

lint: $(STAMP)
	$(BIN)/ruff check
	$(BIN)/mypy
	cargo clippy --quiet --locked --manifest-path $(CRATE) --all-targets --features python -- --deny warnings

bench: $(STAMP)
	@$(BIN)/python -m compileall -q verifier
	$(BIN)/python -m tests.bench

# Reachability problems of the literature, beside what other tools needed: some minutes.
bench-reach: $(STAMP)
	@$(BIN)/python -m compileall -q verifier
	$(BIN)/python -m tests.bench.reach

# Simulated runs beside scipy and heyoka, which has an environment of its own (104 MB are downloaded once): two minutes.
bench-sim: $(STAMP)
	@$(BIN)/python -m compileall -q verifier
	test -x $(HEYOKA)/bin/python || $(PYTHON) -m venv $(HEYOKA)
	$(HEYOKA)/bin/python -m pip install --quiet heyoka==7.13.2
	$(HEYOKA)/bin/python tests/bench/heyoka_runs.py > $(HEYOKA)/runs.json
	$(BIN)/python -m tests.bench.simulation $(HEYOKA)/runs.json

# A simulated motion read back by OpenSim's own readers, and its gait2354 posed by a gait and a recording of it, in an
# environment of its own (72 MB are downloaded once, and what haverify needs).
test-opensim: $(STAMP)
	test -x $(OPENSIM)/bin/python || $(PYTHON) -m venv $(OPENSIM)
	$(OPENSIM)/bin/python -m pip install --quiet --constraint constraints.txt opensim==4.6 lark msgspec networkx scipy
	$(BIN)/haverify simulate spec/gait.ha --mot $(OPENSIM)/out.mot --csv $(OPENSIM)/out.csv
	$(OPENSIM)/bin/python tests/peers/opensim_reads.py $(OPENSIM)/out.mot $(OPENSIM)/out.csv
	PYTHONPATH=verifier $(OPENSIM)/bin/python tests/peers/opensim_poses.py models/gait2354/gait2354.osim
	PYTHONPATH=verifier $(OPENSIM)/bin/python -m haverify compare models/walks/subject01_walk1_ik.mot spec/gait.ha \
		--osim models/gait2354/gait2354.osim

# Continuous safety problems; `make bench-invariants PROBLEMS="--seconds 20 --only nl_0"` for some of them, with less time.
bench-invariants: $(STAMP)
	@$(BIN)/python -m compileall -q verifier
	PYTHONPATH=verifier:. $(BIN)/python -m tests.peers.hstp $(PROBLEMS)

# 100,000 sampled runs of each problem against the enclosures; a hundredth of it is among the tests. Threads of the linear
# algebra would wait for each other in loops and double the work.
soak: $(STAMP)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m tests.soak

clean:
	rm -rf $(VENV) $(OPENSIM) $(HEYOKA) reports verifier/kernel/target verifier/haverify/*.so .mypy_cache .ruff_cache .pytest_cache .hypothesis
