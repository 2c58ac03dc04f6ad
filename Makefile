# Two commands do everything on a machine with Python 3.11 and make: `make demo` and `make test`.
# Elsewhere plain pip takes torch's CUDA build (several GB). To take the CPU build:
#   make demo TORCH_INDEX=https://download.pytorch.org/whl/cpu
PYTHON ?= python3.11
VENV ?= .venv
TORCH_INDEX ?=
BIN := $(VENV)/bin
export OMP_NUM_THREADS ?= 1
export OPENBLAS_NUM_THREADS ?= 1
export MKL_NUM_THREADS ?= 1
export NUMBA_NUM_THREADS ?= 1
# Without bytecode every process of the suite would compile all sources and rewrite all tests anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test accept kernels nightly fuzz mutate plant unseen lock sbom lint types bench persons necks train clean

$(BIN)/python:
	$(PYTHON) -m venv $(VENV) || python3 -m venv $(VENV)

# Modules are compiled when they are first imported: a fifth of the packages' 2 GB would be bytecode that nothing reads.
PIP_INSTALL = $(BIN)/python -m pip install --no-compile --disable-pip-version-check -c constraints.txt
$(VENV)/.installed: pyproject.toml setup.py constraints.txt | $(BIN)/python
	@echo "Installing garmentq into $(VENV): one to three minutes, 1.7 GB on disk; torch and open3d are the largest."
	$(PIP_INSTALL) $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX)) torch
	$(PIP_INSTALL) -e .
	touch $@

$(VENV)/.installed-test: $(VENV)/.installed
	$(PIP_INSTALL) --quiet -e '.[test]'
	touch $@

demo: $(VENV)/.installed
	@echo "Recovering a T-shirt and trousers from a person's scan: about four minutes of two cores."
	$(BIN)/python examples/remove_labels.py examples/data/person.ply demo/person.ply
	$(BIN)/garmentq run demo/person.ply --home demo --out demo/result; \
	status=$$?; $(BIN)/garmentq down --home demo; \
	echo "The reports are in demo/result; for the pages: $(BIN)/garmentq up --serve --home demo, then its link"; \
	exit $$status

# Three processes for two cores: a third of the time a test waits for a server or a reader in a process of its own. Each
# has an own PostgreSQL and brokers of its own.
TEST_PROCESSES ?= 3
PYTEST = $(BIN)/python -m pytest -n $(TEST_PROCESSES) --dist worksteal

test: $(VENV)/.installed-test
	$(PYTEST) --durations 25

nightly: $(VENV)/.installed-test
	$(PYTEST) -m nightly

# The golden scenes' numbers of today are what is right from now on: make accept REASON="..." [SCENES="edit export"]
# With MACHINE=1 they stay, and may be off as far as on this machine.
REASON ?=
SCENES ?=
accept: $(VENV)/.installed-test
	PYTHONPATH=benchmarks $(BIN)/python tests/golden/accept.py --reason "$(REASON)" $(SCENES:%=--scene %) $(if $(MACHINE),--machine)

# Which kernels `garmentq doctor --warm` compiles, and for which types: those that the golden scenes call are added.
kernels: $(VENV)/.installed-test
	PYTHONPATH=benchmarks $(BIN)/python tests/golden/kernel_calls.py

# Mutated files of every kind through the readers; a failure names the seed: make fuzz FUZZ=1 SEED=1234
FUZZ ?= 2000
SEED ?= 1
fuzz: $(VENV)/.installed-test
	FUZZ=$(FUZZ) SEED=$(SEED) $(BIN)/python -m pytest -n 0 tests/scan/test_mutated_files.py

# Drawn constants times 0.7 and 1.3; those that no test and no golden scene notices are listed: make mutate SEED=7
mutate: $(VENV)/.installed-test
	$(BIN)/python benchmarks/mutate.py --seed $(SEED)

# Errors drawn from forty that programmers make (benchmarks/planted_errors.py); which the scenes notice: make plant SEED=7
plant: $(VENV)/.installed-test
	$(BIN)/python benchmarks/plant.py --seed $(SEED)

# Targets that a seed draws and other programs make (docs/howto/judge-a-change.md), recovered, and beside another commit:
# make unseen SEED=12 COUNT=16 [FINISHED=1] [LAYERED=1] BLENDER=python [NEWTON=python] [GARMENTCODE=checkout GARMENTCODE_PYTHON=python] [AGAINST=commit]
COUNT ?= 16
BLENDER ?= python3
GARMENTCODE_PYTHON ?= python3
unseen: $(VENV)/.installed-test
	$(BIN)/python benchmarks/unseen.py --seed $(SEED) --count $(COUNT) --blender $(BLENDER) \
	  $(if $(GARMENTCODE),--garmentcode $(GARMENTCODE) --garmentcode-python $(GARMENTCODE_PYTHON)) \
	  $(if $(FINISHED),--finished) $(if $(LAYERED),--layered) $(if $(NEWTON),--newton $(NEWTON)) $(if $(AGAINST),--against $(AGAINST))

# Every production package with the hashes of its files, and the list of them as CycloneDX JSON. redis needs
# async-timeout with Python before 3.11.3 (Debian 12 has 3.11.2): the lock has it for all.
lock: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --dry-run --ignore-installed --report $(VENV)/report.json -c constraints.txt $(if $(TORCH_INDEX),--extra-index-url $(TORCH_INDEX)) '.[postgres,s3]' async-timeout
	$(BIN)/python deploy/supply.py lock $(VENV)/report.json > requirements.lock

sbom: $(VENV)/.installed
	$(BIN)/python deploy/supply.py sbom requirements.lock > sbom.cdx.json

lint: $(VENV)/.installed-test
	$(BIN)/ruff check .

# mypy does not follow an editable install: it is shown the checkout under the package's name.
types: $(VENV)/.installed-test
	mkdir -p $(VENV)/types && ln -sfn $(CURDIR) $(VENV)/types/garmentq
	MYPYPATH=$(VENV)/types $(BIN)/mypy -p garmentq.core -p garmentq.service -p garmentq.workers -p garmentq.cli

bench: $(VENV)/.installed
	$(BIN)/garmentq bench $(PACKS)

# The set that weights are trained on, and the weights. A tiny run of all of it: make train PERSONS=3 EPOCHS=1
PERSONS ?= 120
EPOCHS ?= 30
SET ?= out/persons
persons: $(VENV)/.installed
	$(BIN)/python -m garmentq.training.persons --out $(SET)/scans --count $(PERSONS)
	$(BIN)/python -m garmentq.training.describe --persons $(SET)/scans --out $(SET)/samples
	$(BIN)/python -m garmentq.training.describe --persons $(SET)/scans --out $(SET)/given --given

# Drapes of necks, by which collars are told apart: half an hour on one core; what is made is kept.
necks: $(VENV)/.installed
	$(BIN)/python -m garmentq.training.necks --out $(SET)/necks --write core/recover/grade/neck_drapes.npz

train: persons
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[training]'
	$(BIN)/python -m garmentq.training.train --samples $(SET)/samples --out $(SET)/weights --epochs $(EPOCHS) --boosted
	$(BIN)/python -m garmentq.training.kinds --samples $(SET)/samples $(SET)/given --out $(SET)/weights/kinds.npz

clean:
	rm -rf $(VENV) demo build dist *.egg-info
