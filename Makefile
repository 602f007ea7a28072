# `make test` on a machine with python3, its venv module, make and gcc needs nothing else.

PYTHON ?= python3
VENV ?= .venv
JOBS ?= auto
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet
PYTEST := $(BIN)/python -m pytest
# More workers than this only repeat the imports. Each has tests that follow one another, which share
# their mechanisms, until it takes some from another.
PARALLEL := -n $(JOBS) --maxprocesses=8 --dist=worksteal

# One thread per worker: the linear algebra is tiny, and the workers already fill the cores.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1
# What one process compiled of Python serves the others: tests start many.
export PYTHONDONTWRITEBYTECODE :=
# No display is needed to draw.
export MPLBACKEND ?= Agg

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help setup test lint slow oldest mutants fuzz reproduce derivations references paper studies figures bench numerics dist docs docs-check setup-browser explorer-modules clean distclean

help: ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-16s %s\n", $$1, $$2}' $(firstword $(MAKEFILE_LIST))

setup: $(VENV)/.installed ## create .venv and install the package with its test tools

test: lint ## check style, types, import layers and prose, then run all but the slow tests
	$(PYTEST) -q $(PARALLEL) -m "not slow"

# Types take longest: the others are checked beside them.
lint: $(VENV)/.installed ## check style, types, import layers and prose
	$(BIN)/ruff check --quiet .
	@{ $(BIN)/lint-imports --no-logo && $(BIN)/python tools/prose.py; } > $(VENV)/lint.log 2>&1 & beside=$$!; \
	$(BIN)/mypy --no-error-summary; types=$$?; \
	wait $$beside || { cat $(VENV)/lint.log; exit 1; }; exit $$types

# pytest ends with 5 when it selects nothing: having no slow tests is not a failure.
slow: $(VENV)/.installed ## run the slow tests
	$(PYTEST) -q $(PARALLEL) -m slow || [ $$? -eq 5 ]

# One test file of each stage: what an old release lacks is missed at once.
OLDEST_TESTS := tests/mechanics/test_coefficients.py tests/codegen/test_bridge.py \
	tests/problem/complementarity/test_lcp.py tests/at/test_classify.py tests/engines/test_engine.py \
	tests/motion/test_rigid.py tests/motion/test_trajectory.py tests/study/test_fit.py \
	tests/study/test_region_map.py tests/present/test_figures.py tests/c_export/test_export_names.py

oldest: ## test the oldest versions of the dependencies, in .venv-oldest
	@$(PYTHON) -m venv $(VENV)-oldest
	@$(VENV)-oldest/bin/python -m pip --disable-pip-version-check --quiet install \
		-c constraints-oldest.txt -e . hypothesis 'pytest>=8' pytest-xdist
	$(VENV)-oldest/bin/python -m pytest -q $(PARALLEL) -m "not slow" $(OLDEST_TESTS)

# Tests of pages are skipped, with the reason, where these are absent.
NODE_PACKAGES := axe-core@4.14.1 typescript@5.9.3
setup-browser: $(VENV)/.installed ## install what tests of pages need: Chromium and Node (by apt), their packages
	@has() { command -v "$$1" > /dev/null; }; missing=; sudo=; [ "$$(id -u)" = 0 ] || sudo="sudo -n"; \
	has chromium || has chromium-browser || has chrome || missing=chromium; \
	has node || missing="$$missing nodejs"; has npm || missing="$$missing npm"; \
	[ -z "$$missing" ] || { $$sudo apt-get -qq update && $$sudo apt-get -qq install -y --no-install-recommends $$missing; } \
		< /dev/null > $(VENV)/apt.log 2>&1 || echo "make: not installed: $$missing (see $(VENV)/apt.log). Fix: sudo apt install $$missing"
	@$(PIP) install -c constraints.txt -e . --group browser
	@if command -v npm > /dev/null; then npm install --silent --no-audit --no-fund --prefix $(VENV)/browser $(NODE_PACKAGES); fi

explorer-modules: $(VENV)/.installed ## compile the explorer's module of the rod again where it is old
	$(BIN)/python tools/explorer_modules.py

# One process for each change, as many at a time as there are cores.
mutants: $(VENV)/.installed ## check that the tests notice each of a list of small wrong changes
	$(BIN)/python -m tests.mutants

reproduce: $(VENV)/.installed ## redo every table, figure and formula of the paper into out/reproduce
	$(BIN)/painleve reproduce --out out/reproduce

# An input with a fault goes from out/fuzz to tests/fuzz/corpus, which `make test` runs.
fuzz: $(VENV)/.installed ## call the program with 10 000 made-up inputs, at most an hour; SEED=1 for others
	$(BIN)/python -m tests.fuzz --inputs 10000 --seconds 3600 --seed $(or $(SEED),0)

derivations: $(VENV)/.installed ## run every derivation; each asserts that it agrees with the package
	$(BIN)/python -m derivations

references: $(VENV)/.installed ## write the package's data of the literature from docs/references.bib
	$(BIN)/python tools/references.py

# Pandoc makes other formats of them where it is installed: pandoc --citeproc paper/NAME.md -o NAME.pdf
paper: $(VENV)/.installed ## write tables and figures of the manuscripts in paper/ from the kept studies
	$(BIN)/python -m tests.benchmarks.contact_solvers_page
	$(BIN)/python -m tests.benchmarks.elastic_bar_page
	$(BIN)/python -m tools.provenance
	$(BIN)/python tools/figures.py contact-solvers landing

# Those of docs/peers.md need other programs: examples/studies/peers/run_all.py.
STUDIES := examples/studies
studies: $(VENV)/.installed numerics ## compute the numbers that the pages show again: hours
	$(BIN)/python $(STUDIES)/rigid_rod/rigid_rod.py
	$(BIN)/python $(STUDIES)/rigid_rod/landing.py
	$(BIN)/python $(STUDIES)/bench_rod/bench_rod.py
	$(BIN)/python $(STUDIES)/reverse_chatter/growth.py
	$(BIN)/python $(STUDIES)/singular_point/fates.py
	$(BIN)/python $(STUDIES)/tangential_compliance.py
	$(BIN)/python $(STUDIES)/corrected_jump/corrected_jump.py docs/figures
	$(BIN)/python $(STUDIES)/critical_force/study.py out/critical_force
	cp out/critical_force/critical-force.json docs/figures
	$(BIN)/python $(STUDIES)/sensitive_impact.py docs/figures/sensitive-impact
	$(BIN)/python $(STUDIES)/sticking_feet.py docs/figures/sticking-feet
	$(BIN)/python $(STUDIES)/impact_energy.py 3000 1 docs/figures/impact-energy
	$(BIN)/python -m tools.provenance

figures: $(VENV)/.installed ## draw every figure of the pages and of the gallery again
	$(BIN)/python tools/figures.py

bench: $(VENV)/.installed-bench ## compare costs with the last release, or AGAINST=REVISION, then run the benchmarks against the other integrators
	$(BIN)/python -m tests.benchmarks.against $(if $(AGAINST),--against $(AGAINST)) --out out/against.json
	$(PYTEST) -q -s tests/benchmarks -o python_files="bench_*.py test_*.py"
	$(BIN)/python -m tests.benchmarks --out out/bench.json

docs: $(VENV)/.installed-docs ## build the documentation site into out/site; needs no network
	rm -rf out/site docs/gallery docs/reference/api docs/reference/json
	$(BIN)/python -m sphinx --fail-on-warning --keep-going -b html docs out/site

dist: $(VENV)/.installed ## build the source archive and the wheel into dist, and check them
	rm -rf dist build
	@$(PIP) install --group dist
	$(BIN)/python -m build --outdir dist
	$(BIN)/python -m twine check --strict dist/*

docs-check: docs ## open every page of the site in Chromium
	$(BIN)/python tools/check_site.py out/site

numerics: $(VENV)/.installed-bench ## measure error against cost, and write docs/numerics.md and its figures
	$(BIN)/python -m tests.benchmarks.numerics_page --measure

clean: ## remove results, build products and caches
	rm -rf docs/_generated docs/gallery docs/reference/api docs/reference/json docs/sg_execution_times.rst
	rm -rf out build dist *.egg-info .pytest_cache .hypothesis .mypy_cache .ruff_cache .import_linter_cache
	find . -path './$(VENV)*' -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean ## also remove .venv
	rm -rf $(VENV) $(VENV)-oldest

$(VENV)/.created:
	@command -v $(PYTHON) > /dev/null || { echo "make: '$(PYTHON)' not found. Fix: install Python 3.11 or newer, or name it: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "make: '$(PYTHON)' is $$($(PYTHON) -V 2>&1), but 3.11 or newer is needed. Fix: name a newer one: make PYTHON=python3.12"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2> /dev/null || { echo "make: '$(PYTHON)' has no venv module. Fix: sudo apt install python3-venv"; exit 1; }
	@echo "Creating $(VENV) ..."
	@$(PYTHON) -m venv $(VENV)
	@touch $@

$(VENV)/.installed: $(VENV)/.created pyproject.toml constraints.txt
	@echo "Installing the package and its test tools into $(VENV) ..."
	@$(PIP) install --upgrade 'pip>=25.1'
	@$(PIP) install -c constraints.txt -e . --group test --group lint
	@touch $@

$(VENV)/.installed-bench: $(VENV)/.installed
	@echo "Installing the integrators to compare with ..."
	@$(PIP) install -c constraints.txt -e . --group bench
	@touch $@

$(VENV)/.installed-docs: $(VENV)/.installed
	@echo "Installing what builds the documentation site ..."
	@$(PIP) install -c constraints.txt -e . --group docs
	@touch $@
