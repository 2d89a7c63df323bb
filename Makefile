# `make demo` and `make test` are all the set-up there is, on a fresh machine too.
PYTHON ?= python3
BIN := .venv/bin
ifeq ($(OS),Windows_NT)
BIN := .venv/Scripts
endif

.PHONY: demo test lint bench-pair picture clean

demo: .venv/installed
	@$(BIN)/orbitscan process recordings/robot.mcap -o results --overwrite
	@echo "or: $(BIN)/rerun results/robot/review.rrd"

test: .venv/installed-dev
	$(BIN)/python -m pytest -n auto

lint: .venv/installed-dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

bench-pair: .venv/installed-dev
	$(BIN)/python -m tests.benchmarks.pair

picture: .venv/installed-dev
	$(BIN)/python -m tests.picture results/robot/review.rrd docs/review.png

clean:
	rm -rf .venv results build dist *.egg-info

.venv/installed: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -qq --upgrade pip
	$(BIN)/python -m pip install -qq --constraint constraints.txt --editable .
	touch $@

.venv/installed-dev: .venv/installed
	$(BIN)/python -m pip install -qq --constraint constraints.txt --editable .[dev]
	touch $@
