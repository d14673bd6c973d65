# solidwhirl: `make pipeline` and `make test` are all a new machine needs.
SCENE ?= ferraris
OUT ?= out/$(SCENE)
NP ?= 1
JOBS ?= 2
BIN := .venv/bin
export OPENBLAS_NUM_THREADS := 1
# ranks on one machine: allow root and more ranks than cores, and let waiting ranks sleep
export OMPI_ALLOW_RUN_AS_ROOT := 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM := 1
export OMPI_MCA_rmaps_base_oversubscribe := 1
export OMPI_MCA_mpi_yield_when_idle := 1

.PHONY: help setup pipeline test check verify hard paper study bench clean

help: ## say what can be made
	@sed -n 's/^\([a-z]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

setup: ## install Debian packages and .venv (quick when done)
	@tools/setup.sh

pipeline: setup ## run a scene end to end (SCENE=ferraris OUT=out/ferraris NP=1)
	@if [ $(NP) = 1 ]; then $(BIN)/solidwhirl run scenes/$(SCENE).toml --out $(OUT); \
	else mpirun -n $(NP) $(BIN)/solidwhirl run scenes/$(SCENE).toml --out $(OUT); fi

test: setup ## run the tests (on JOBS=2 cores; installs ROSS, which reads exported bodies)
	@tools/ross_environment.sh
	@$(BIN)/python -m pytest -m "not verify" -n $(JOBS) --dist worksteal

check: setup ## lint, format, types and import rules
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports

verify: ## long comparisons: converged figures, other programs (installs calculix-ccx)
	@tools/setup.sh verify
	@tools/ross_environment.sh
	@$(BIN)/python -m pytest -m verify

paper: setup ## compute every table and figure of the paper, write docs/paper.md
	@$(BIN)/python tools/paper

hard: setup ## measure the hard cases, write docs/hard_cases.md
	@$(BIN)/python tools/hard_cases.py

study: setup ## error against time and memory over levels, meshes and modes (SCENE=ferraris)
	@$(BIN)/solidwhirl study scenes/$(SCENE).toml --out out/study/$(SCENE)

bench: setup ## measure time and memory, beside other programs (an hour)
	@tools/setup.sh verify
	@tools/ross_environment.sh
	@tools/exudyn_environment.sh
	@$(BIN)/python bench/peers.py
	@$(BIN)/python bench/effectivity.py
	@$(BIN)/python bench/dial.py
	@$(BIN)/python bench/scaling.py
	@$(BIN)/python bench/solver_settings.py
	@$(BIN)/python bench/harmonic_and_solid.py
	@$(BIN)/python bench/engine.py
	@$(BIN)/python bench/run_up.py

clean: ## remove results and caches, not the environment
	rm -rf out build .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -not -path './.venv*' -prune -exec rm -rf {} +
