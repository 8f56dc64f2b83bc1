# `make` or `make help` says what there is. All that a target needs is installed into .venv, from PyPI and crates.io.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
OUT := out
DEMO ?=
CALLS ?= 1000000

RUST_SOURCES := $(shell find rust_core -name '*.rs' -o -name 'Cargo.toml') Cargo.toml $(wildcard Cargo.lock)
PYTHON_SOURCES := $(shell find python -type f ! -name '*.so' ! -path '*/__pycache__/*')
WHEEL_SOURCES := $(RUST_SOURCES) $(PYTHON_SOURCES) pyproject.toml README.md
WHEEL := $$(echo dist/physcore-*.whl)

# nextest runs the Rust tests faster and names the slow ones; plain `cargo test` runs the same tests.
CARGO_TEST := $(if $(shell command -v cargo-nextest),cargo nextest run,cargo test)

TESTED := --locked --workspace --exclude physcore-benches
# There is nothing in the bindings that could run without Python; `--lib` would compile them, and the engine once more.
UNITS := $(TESTED) --exclude physcore-python

.DEFAULT_GOAL := help
.PHONY: help check install dev wheels demo docs test test-rust test-python test-portable test-long fuzz mutants edges asan validate tradeoff lint format bench clean

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

check: ## look whether this machine has what the build needs, and say how to get what is missing
	@PYTHON='$(PYTHON)' scripts/check-environment

demo: $(VENV)/package.stamp ## build, install, run a demo (DEMO=name), say where the GIF is and what the audit found
	@mkdir -p $(OUT)
	@$(BIN)/physcore demo $(DEMO) -o $(OUT)/$(or $(DEMO),demo).gif

install: $(VENV)/package.stamp ## build the release wheel and install it into .venv

# The stamp of the wheel goes: `make test` and `make install` then install the wheel again.
dev: $(VENV)/maturin.stamp ## build for editing, in seconds after the first time: the same behaviour, but slow
	@rm -f $(VENV)/package.stamp
	VIRTUAL_ENV=$(abspath $(VENV)) $(BIN)/maturin develop --profile editing --locked

# Zig links against the symbols of an old C library. It is found as a module of the first `python3`.
wheels: $(VENV)/maturin.stamp ## build the wheel for all Linux systems since 2014 with this processor, and the sdist, into dist/wheels
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'ziglang>=0.13,<1'
	rm -rf dist/wheels
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/maturin build --release --locked --zig --compatibility manylinux2014 \
		--target $(shell uname -m)-unknown-linux-gnu --interpreter $(BIN)/python --out dist/wheels
	$(BIN)/maturin sdist --out dist/wheels

test: test-rust test-python ## run every test, Rust and Python, in about ten minutes on two cores after `make install`

# Unit tests are compiled with debug assertions and overflow checks, and hardly optimized, which is quickest. The other tests
# use the wheel's profile and the same features of all dependencies, so that the engine is compiled once for both.
test-rust: | check
	@echo 'The tests of the Rust crates, 400 of them, in a minute; before that the crates are compiled, in minutes.'
	CARGO_PROFILE_DEV_OPT_LEVEL=0 PROPTEST_CASES=64 $(CARGO_TEST) $(UNITS) --lib
	PROPTEST_CASES=64 $(CARGO_TEST) $(TESTED) --release --test '*'

test-python: $(VENV)/tools.stamp
	@echo 'The tests of the package, 14200 of them, in some six minutes on two cores.'
	$(BIN)/python -m pytest -q -m 'not long' --numprocesses auto --costs 10

# Wave functions take their transforms from AVX at this level too.
test-portable: $(VENV)/tools.stamp ## compare the bits of the level of other targets, in a build of its own
	rm -rf $(OUT)/portable
	$(BIN)/maturin build --release --locked --features portable --interpreter $(BIN)/python --out $(OUT)/portable
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --target $(OUT)/portable $(OUT)/portable/*.whl
	PYTHONPATH=$(OUT)/portable $(BIN)/python -m pytest tests/contracts/test_bits.py

test-long: $(VENV)/tools.stamp ## run every test with the full number of examples
	PROPTEST_CASES=2000 PROPTEST_MAX_GLOBAL_REJECTS=100000 cargo test $(TESTED) --release -- --include-ignored
	cargo test $(TESTED)  # with debug assertions and overflow checks, which the tests of `make test` have in part
	PHYSCORE_TESTS=long $(BIN)/python -m pytest

fuzz: $(VENV)/tools.stamp ## call everything with hostile values, CALLS=1000000 times on all cores, and say what was found
	$(BIN)/python tests/fuzz --calls $(CALLS)

mutants: $(VENV)/tools.stamp ## plant 60 faults into a copy of the engine, and say which of them the contracts do not see
	$(BIN)/python scripts/mutants

edges: $(VENV)/tools.stamp ## write out/edges.md: what becomes of the edge values of every argument
	@mkdir -p $(OUT)
	$(BIN)/python tests/fuzz/edges.py $(OUT)/edges.md

asan: ## run the tests of the library crates under AddressSanitizer, where a nightly Rust is installed
	scripts/address-sanitizer

validate: $(VENV)/tools.stamp ## run the cases with reference figures from outside, and write out/validation.md
	$(BIN)/python -m pytest -m validation --numprocesses auto --dist loadfile --report=$(OUT)/validation.md

tradeoff: $(VENV)/tools.stamp ## measure error against time and the extremes, and write out/tradeoff.md, in ten minutes
	$(BIN)/python benches/tradeoff.py $(OUT)

# Scripts of pages run again only if they or the package have changed.
docs: $(VENV)/docs.stamp ## build the documentation into out/docs/site, with its films, in five minutes
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --nitpicky --jobs auto --quiet --doctree-dir $(OUT)/docs/doctrees docs $(OUT)/docs/site
	@echo 'The first page is $(OUT)/docs/site/index.html.'

lint: $(VENV)/tools.stamp ## check format, style, types and licenses, Rust and Python
	cargo fmt --all --check
	cargo clippy --locked --workspace --all-targets -- -D warnings
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/stubtest physcore._core --mypy-config-file pyproject.toml
	$(BIN)/python scripts/check-licenses
	scripts/check-words

format: $(VENV)/tools.stamp ## format the code, Rust and Python
	cargo fmt --all
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

bench: $(VENV)/bench.stamp ## measure the speed beside NumPy, Numba and other engines, in about a quarter of an hour
	$(BIN)/python benches

clean: ## remove everything that was built
	rm -rf $(VENV) dist target $(OUT)
	find . -name __pycache__ -prune -exec rm -rf {} +

$(VENV)/maturin.stamp: | check
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'maturin>=1.14,<2'
	@touch $@

dist/wheel.stamp: $(WHEEL_SOURCES) $(VENV)/maturin.stamp
	@rm -f dist/physcore-*.whl
	$(BIN)/maturin build --release --locked --interpreter $(BIN)/python --out dist
	@touch $@

$(VENV)/package.stamp: dist/wheel.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps $(WHEEL)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check $(WHEEL)
	@touch $@

$(VENV)/tools.stamp: $(VENV)/package.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "$(WHEEL)[dev]"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --only-binary=:all: "$(WHEEL)[sweep]" \
		|| echo 'Executors for sweeps are not all installed: tests of those that are missing are skipped.'
	@touch $@

$(VENV)/bench.stamp: $(VENV)/package.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "$(WHEEL)[bench]"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --only-binary=:all: "$(WHEEL)[bench-rigid]" \
		|| echo 'Engines for rigid bodies are not all installed: `make bench` leaves out those that are missing.'
	@touch $@

$(VENV)/docs.stamp: $(VENV)/package.stamp
	$(BIN)/python -m pip install --quiet --disable-pip-version-check "$(WHEEL)[docs]"
	@touch $@
