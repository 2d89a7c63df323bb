# `make demo` and `make test` are all the set-up there is, on a fresh machine too.
PYTHON ?= python3
BIN := .venv/bin
ifeq ($(OS),Windows_NT)
BIN := .venv/Scripts
endif

.PHONY: demo test lint bench bench-quick bench-memory bench-symmetry bench-calibration bench-color bench-views faults fuzz model picture clean

demo: .venv/installed
	@$(BIN)/orbitscan process recordings/robot.mcap -o results --overwrite
	@echo "or: $(BIN)/rerun results/robot/review.rrd"

test: .venv/installed-dev
	$(BIN)/python -m pytest -n auto --dist loadfile

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/python -m tests.types

bench: .venv/installed-bench
	$(BIN)/python -m tests.benchmarks

bench-quick: .venv/installed-bench
	$(BIN)/python -m tests.benchmarks --quick

bench-memory: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.memory

# Whether `ok` can be believed on objects that repeat themselves: hours; QUICK=--quick takes minutes.
bench-symmetry: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.symmetry $(if $(QUICK),--quick)

# Whether the bounds of poses can be believed.
bench-calibration: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.calibration

# Whether colours decide what shapes leave open, and nothing else: QUICK=--quick takes minutes.
bench-color: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.color $(if $(QUICK),--quick)

# Which right views are called failed, and what a view costs as they become more.
bench-views: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.views lost
	$(BIN)/python -m tests.benchmarks.views many

# FIRST=7 COUNT=1 makes the damage of number 7 alone.
fuzz: .venv/installed-dev
	$(BIN)/python -m tests.fuzz --first $(or $(FIRST),0) --count $(or $(COUNT),500)

# A batch that is killed at random moments, and disks that are full; the number is the seed of the moments.
faults: .venv/installed-dev
	$(BIN)/python -m tests.faults $(SEED)

# Trains the packaged model, on virtual scans alone; in model-data/ lies what it is made of.
model: .venv/installed
	$(BIN)/orbitscan simulate corpus -o model-data/corpus --every 40 --instances 60 --workers 2
	$(BIN)/orbitscan simulate others -o model-data/others --every 50 --instances 8 --workers 2
	$(BIN)/orbitscan train model-data/corpus --unknown model-data/others --validate 6 -o model-data/household.pt
	cp model-data/household.pt processing/classification/household.pt

picture: .venv/installed-dev
	$(BIN)/orbitscan view results/robot --screenshot docs/review.png

clean:
	rm -rf .venv results model-data build dist *.egg-info

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -qq --upgrade pip
	$(BIN)/python -m pip install -qq --constraint constraints.txt --editable .
	touch $@

.venv/installed-dev: .venv/installed
	$(BIN)/python -m pip install -qq --constraint constraints.txt --editable .[dev]
	touch $@

# Peers are optional: where one has no wheel, the benchmark says so.
.venv/installed-bench: .venv/installed-dev
	-$(BIN)/python -m pip install -qq --constraint constraints.txt --only-binary kiss-matcher --editable .[bench]
	touch $@
