# solidwhirl: `make pipeline` and `make test` are all a new machine needs.
SCENE ?= ferraris
OUT ?= out/$(SCENE)
NP ?= 1
K ?= 1
JOBS ?= 2
BIN := .venv/bin
# what results are older than when the program was changed
PROGRAM := $(shell find geometry meshing reduction rotordyn solidwhirl -type f ! -name "*.pyc")
# scenes of a batch, by name or path, and its folder unless OUT is given
CHOSEN = $(foreach s,$(SCENES),$(if $(filter %.toml,$(s)),$(s),scenes/$(s).toml))
BATCH = $(if $(filter file,$(origin OUT)),out/batch,$(OUT))
export OPENBLAS_NUM_THREADS := 1
# modules are compiled once, not by every process, also where the shell forbids it
export PYTHONDONTWRITEBYTECODE :=
# ranks on one machine: allow root and more ranks than cores, and let waiting ranks sleep
export OMPI_ALLOW_RUN_AS_ROOT := 1
export OMPI_ALLOW_RUN_AS_ROOT_CONFIRM := 1
export OMPI_MCA_rmaps_base_oversubscribe := 1
export PRTE_MCA_rmaps_default_mapping_policy := :oversubscribe
export OMPI_MCA_mpi_yield_when_idle := 1
# mpirun waits so long before SIGTERM, and again before SIGKILL: ranks end in order
export OMPI_MCA_odls_base_sigkill_timeout := 4

.PHONY: help measured setup pipeline batch scenes test check verify hard paper paper_blades study docs bench clean

help: ## say what can be made
	@sed -n 's/^\([a-z_]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 14

setup: ## install Debian packages and .venv (quick when done)
	@flock Makefile tools/setup.sh

pipeline: setup ## run a scene end to end (SCENE=ferraris OUT=out/ferraris NP=1)
	@if [ $(NP) = 1 ]; then $(BIN)/solidwhirl run scenes/$(SCENE).toml --out $(OUT) --pictures; \
	else mpirun -n $(NP) $(BIN)/solidwhirl run scenes/$(SCENE).toml --out $(OUT) --pictures; fi

batch: setup ## run many scenes or sweeps (SCENES="laval ferraris" NP=2 K=1 OUT=out/batch)
	@[ -n "$(CHOSEN)" ] || { echo 'batch: which scenes? make batch SCENES="laval ferraris"' >&2; exit 2; }
	@resume=--resume; \
	[ -z "$$(find $(PROGRAM) -newer $(BATCH)/batch.jsonl 2>/dev/null | head -n 1)" ] || resume=; \
	mpirun -n $(NP) $(BIN)/solidwhirl batch $(CHOSEN) --out $(BATCH) --ranks-per-scene $(K) $$resume

# a scene with [sweep] is for `make batch`
SINGLE := $(shell grep -L '^\[sweep\]' scenes/*.toml)
scenes: $(SINGLE:scenes/%.toml=out/%/SHA256SUMS) ## run what is stale of all scenes

# the last file of a whole run; what the run has kept of its stages is found again
.SECONDEXPANSION:
# Where two makes come to a scene at once, one waits, and finds it done.
out/%/SHA256SUMS: scenes/%.toml $$(wildcard scenes/$$*/*) $(PROGRAM) | setup
	@mkdir -p out
	@exec 9> out/.$*.lock; flock 9; \
	[ -n "$$(find $? -newer $@ -print -quit 2>&1)" ] || exit 0; \
	$(BIN)/solidwhirl run $< --out out/$* 9>&-

test: setup ## run the tests (on JOBS=2 cores; installs ROSS, which reads exported bodies)
	@tools/ross_environment.sh
	@tools/setup.sh browser
	@$(BIN)/python -m pytest -m "not verify" -n $(JOBS) --dist worksteal

check: setup ## lint, format, types and import rules
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports

verify: ## long comparisons: converged figures, other programs (installs calculix-ccx)
	@tools/setup.sh verify
	@tools/ross_environment.sh
	@$(BIN)/python -m pytest -m verify -n $(JOBS) --dist worksteal --durations=25

paper: setup ## compute every table and figure of the paper, write docs/paper.md
	@$(BIN)/python tools/paper

paper_blades: setup ## compute what the page of the paper says of the engine with blades
	@$(BIN)/python tools/paper/blades.py

measured: setup ## predict machines that were measured, write docs/measured.md
	@$(BIN)/python tools/measured

hard: setup ## measure the hard cases, write docs/hard_cases.md
	@$(BIN)/python tools/hard_cases.py

study: setup ## error against time and memory over levels, meshes and modes (SCENE=ferraris, or SCENE=uhbr_engine)
	@$(BIN)/solidwhirl study scenes/$(SCENE).toml --out out/study/$(SCENE)

docs: setup ## build the documentation as a site in out/docs
	@$(BIN)/python tools/scene_reference.py --check
	@$(BIN)/sphinx-build -W --keep-going -q -c docs . out/docs
	@echo out/docs/index.html

bench: setup ## measure time and memory, beside other programs (two hours)
	@tools/setup.sh verify
	@tools/ross_environment.sh
	@tools/exudyn_environment.sh
	@$(BIN)/python bench/peers.py
	@$(BIN)/python bench/effectivity.py
	@$(BIN)/python bench/dial.py
	@$(BIN)/python bench/scaling.py
	@$(BIN)/python bench/solver_settings.py
	@$(BIN)/python bench/harmonic_and_solid.py
	@$(BIN)/python bench/fixed_modes_of_sectors.py
	@$(BIN)/python bench/bladed_disk.py
	@$(BIN)/python bench/stage_joints.py
	@$(BIN)/python bench/ordinary_rotors.py
	@$(BIN)/python bench/engine.py
	@$(BIN)/python bench/run_up.py
	@$(BIN)/python bench/asymmetric.py
	@$(BIN)/python bench/asymmetric_body.py
	@$(BIN)/python bench/loop.py

clean: ## remove results and caches, not the environment
	rm -rf out build .mypy_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -not -path './.venv*' -prune -exec rm -rf {} +
