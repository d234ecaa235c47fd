# One command for each thing; everything is set up in .venv the first time.
# Needs make and a python3 of version 3.11 or 3.12 with venv, on x86_64 Linux.

COMMA := ,
VENV := .venv
BIN := $(VENV)/bin
# Most of what is installed is never loaded: to compile it all takes longer than to fetch it.
# What is loaded is compiled then, and kept for the next process.
unexport PYTHONDONTWRITEBYTECODE
PIP := python -m pip install -qq --disable-pip-version-check --no-compile
STAMP := $(VENV)/.installed
OLDEST := .venv-oldest
OTHER := .venv-other
EXTRAS ?= ros,report,watch,foxglove,parquet,cluster,urdf,dev,docs
# Tests over DDS mostly wait: one more than cores.
WORKERS ?= 3
# Set to anything, what is installed is held to requirements.lock, by hash.
LOCKED ?=
PYTEST_ARGS ?=
NIGHTLY ?=

SUPPORTED := import sys; sys.exit(sys.version_info[:2] not in ((3, 11), (3, 12)))

.PHONY: run test nightly audit test-oldest test-other lint format docs chart lock setup clean

run: $(STAMP)  ## play the sample bag into the real node over DDS, compare with the truth
	$(BIN)/python -m peg_on_hole_ros.cli.demo

test: $(STAMP)  ## every check: style, import contract, tests
	$(MAKE) --jobs 2 compiled-estimator compiled-simulation lint
	$(BIN)/python -m pytest -n $(WORKERS) $(PYTEST_ARGS)

nightly: $(STAMP)  ## what takes too long for every push, with a table; NIGHTLY="--only live" for a part
	$(BIN)/python tools/nightly.py $(NIGHTLY)

audit: $(STAMP)  ## known vulnerabilities of all that requirements.lock names; asks PyPI; what it cannot audit is an error
	$(BIN)/$(PIP) pip-audit
	@# It would pass over pins whose marker names another Python or system, and takes no name twice:
	@# so without markers, and a further release of a package in a further file.
	rm -f $(VENV)/audit-*.txt
	awk '/^[^ ]/ {split($$1, pin, "=="); n = ++seen[pin[1]]; sub(/ ;[^\\]*/, " ")} \
	    {print > "$(VENV)/audit-" n ".txt"}' requirements.lock
	@# Strict: what the index has no advisories of is an error. There are no exceptions; one would
	@# be a package that is left out here by name, with the reason.
	@code=0; for pins in $(VENV)/audit-*.txt; do \
	    $(BIN)/pip-audit --strict --require-hashes --disable-pip -r $$pins || code=1; \
	done; exit $$code

test-oldest: $(STAMP)  ## the tests with the oldest dependencies that setup.py allows, on ROS 2 Jazzy
	rm -rf $(OLDEST)
	$(BIN)/python tools/oldest.py > $(VENV)/oldest.txt
	$(BIN)/python -m venv $(OLDEST)
	$(OLDEST)/bin/$(PIP) -r $(VENV)/oldest.txt
	$(OLDEST)/bin/$(PIP) --no-deps --editable .
	$(OLDEST)/bin/python -m pytest -n $(WORKERS) $(PYTEST_ARGS)

compiled-%: $(STAMP)
	$(BIN)/python tools/compiled.py $*

test-other:  ## the tests on another Python: make test-other PYTHON=/path/to/python3.12
	$(MAKE) setup VENV=$(OTHER)
	$(OTHER)/bin/python -m pytest -n $(WORKERS) $(PYTEST_ARGS)

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python tools/prose.py

format: $(STAMP)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .
	$(BIN)/python tools/doc_tables.py
	$(BIN)/python tools/tuned_table.py

docs: $(STAMP)  ## the documents as a site in site/; a broken link is an error
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build

chart: $(STAMP)  ## the pictures of chart and stability and their tables anew; half an hour
	$(BIN)/peg-on-hole chart --out out/chart
	$(BIN)/peg-on-hole stability --out out/chart
	cp out/chart/*.csv docs/figures/
	$(BIN)/python tools/figures.py

setup: $(STAMP)

$(STAMP): setup.py
	@set -e; \
	for python in $(PYTHON) python3 python3.12 python3.11; do \
	    if $$python -c '$(SUPPORTED)' 2>/dev/null; then found=$$python; break; fi; \
	done; \
	if [ -z "$$found" ]; then \
	    echo "make: found no Python 3.11 or 3.12 (python3 is $$(python3 --version 2>&1));" \
	        "install one with its venv module, or name it: make PYTHON=/path/to/python3.12" >&2; \
	    exit 1; \
	fi; \
	if [ "$$($$found -c 'import platform; print(platform.machine())')" != x86_64 ]; then \
	    echo "make: the ROS 2 wheels exist for x86_64 only; on other machines use a native" \
	        "ROS 2 and colcon (README)" >&2; \
	    exit 1; \
	fi; \
	echo "setting up $(VENV) with $$($$found --version): takes a minute or two"; \
	rm -rf $(VENV); \
	$$found -m venv $(VENV); \
	if [ -n "$(LOCKED)" ]; then \
	    $(BIN)/$(PIP) --require-hashes -r requirements.lock; \
	    $(BIN)/$(PIP) --no-deps --no-build-isolation --editable .; \
	else \
	    $(BIN)/$(PIP) --editable ".[$(EXTRAS)]"; \
	fi; \
	touch $@

lock: $(STAMP)  ## the versions and hashes that LOCKED=1 installs, anew
	$(BIN)/$(PIP) uv
	$(BIN)/uv pip compile -q setup.py $(foreach extra,$(subst $(COMMA), ,$(EXTRAS)),--extra $(extra)) \
	    --generate-hashes --no-header --no-annotate --python-version 3.11 --universal --upgrade \
	    -o requirements.lock

clean:
	rm -rf $(VENV) $(OLDEST) $(OTHER) .numba_cache .pytest_cache .ruff_cache .import_linter_cache .mypy_cache \
	    .hypothesis build install log site *.egg-info out
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
