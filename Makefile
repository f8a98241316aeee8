# Every target makes what it needs: `make demo` and `make test` start from nothing.
PYTHON ?= python3
BIN := .venv/bin

.PHONY: demo test test-slow pythons browser screenshots docs docs-links drawings picture truth lint format bench fuzz faults \
	clean clean-cache

demo: .venv/installed
	$(BIN)/einschalt densify data_examples/neukirchen --output out/neukirchen
	$(BIN)/einschalt densify data_examples/sxb_strasbourg --output out/sxb_strasbourg

# on all cores; a worker that has nothing left takes the last tests of another one, so
# that those of one file, which share what they look at, mostly stay together. pytest
# keeps its own form of the test modules also where the environment forbids it: to make
# it anew takes each worker, and each later run, as long as all else before the first test
PYTEST := PYTHONDONTWRITEBYTECODE= $(BIN)/python -m pytest --numprocesses auto --maxprocesses 8 --dist worksteal
test: .venv/compiled
	$(PYTEST) -m "not slow"

# the others, a tenth: they compute whole blocks, or start programs
test-slow: .venv/compiled
	$(PYTEST) -m slow

# the wheel in an empty environment of every Python from 3.11 to 3.14 that is here
pythons: .venv/installed-test
	$(BIN)/python -m tests.other_pythons

# for the tests of pages, on Debian and as root: without it they are left out, and say so
browser:
	command -v chromium || (apt-get update --quiet && apt-get install --yes --quiet chromium)
	npm install --no-save --silent axe-core

# pictures of report and local page, which nobody compares: out/screenshots, to look at
screenshots: .venv/installed-test
	$(BIN)/python -m tests.screenshots

# the site, from nothing and without a network: out/site/index.html, and out/docs.zip to
# read offline. Its tutorials and recipes are computed, a warning is an error
SPHINX := $(BIN)/python -m sphinx -W --keep-going --quiet -d out/doctrees
docs: .venv/installed-docs
	rm -rf out/site out/doctrees docs/gallery docs/recipes docs/reference/generated
	$(SPHINX) -b html docs out/site
	$(BIN)/python -m zipfile --create out/docs.zip out/site

# the links to other sites as well; needs a network
docs-links: .venv/installed-docs
	$(SPHINX) -b linkcheck docs out/links

# 200 blocks with known truth, some minutes; writes docs/truth.md
truth: .venv/installed-test
	$(BIN)/python -m tests.truth.long_form

lint: .venv/installed-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

format: .venv/installed-test
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: .venv/installed-bench
	$(BIN)/python -m benchmarks

faults: .venv/installed-test
	EINSCHALT_LONG=1 $(BIN)/python -m pytest tests/interfaces/batch/test_two_hundred_blocks.py \
		tests/interfaces/batch/test_bad_night.py
	$(BIN)/python -m benchmarks.faults

# a million hostile inputs in several runs, each going on where the last one ended
fuzz: .venv/compiled
	$(BIN)/python -m fuzz --seconds 1500

# the figures of the site, from our own numbers
drawings: .venv/installed
	$(BIN)/python docs/drawings.py

# the picture of the README; with a palette it is a fifth as large
PICTURE := docs/images/precision_map.png
picture: .venv/installed
	$(BIN)/einschalt plan --expect --scale-number 8000 --spacing 300m --m-g-um 5um \
		--high-m-g-um 7.5um --width 10.4km --height 10.2km --figure $(PICTURE) --overwrite
	$(BIN)/python -c "from PIL import Image; image = Image.open('$(PICTURE)').convert('RGB'); \
		image.resize((1450, 420)).quantize(128, dither=0).save('$(PICTURE)')"

.venv/bin/python:
	$(PYTHON) -m venv .venv

# pip would compile every module on one core, a third of them the libraries' own tests;
# what is no Python, as pip does not mind either, is told and left alone
define install
	$(BIN)/python -m pip install --quiet --no-compile --editable $(1)
	-$(BIN)/python -m compileall -q -j 0 -x '/tests?/' .venv/lib
	touch $@
endef

.venv/installed: pyproject.toml | .venv/bin/python
	$(call install,.)

.venv/installed-test: pyproject.toml | .venv/bin/python
	$(call install,".[test]")
	touch .venv/installed

# a comma in a call would begin its next argument
OF_BENCH := ".[test,bench]"
.venv/installed-bench: pyproject.toml | .venv/bin/python
	$(call install,$(OF_BENCH))
	touch .venv/installed .venv/installed-test

.venv/installed-docs: pyproject.toml | .venv/bin/python
	$(call install,".[docs]")
	touch .venv/installed

# kernels are compiled once, and not by each process that wants them; so are modules,
# also where the environment says that Python writes none (PYTHONDONTWRITEBYTECODE)
.venv/compiled: .venv/installed-test tests/compile_kernels.py \
		$(wildcard $(foreach floor,foundations theory,src/einschalt/$(floor)/*.py src/einschalt/$(floor)/*/*.py))
	$(BIN)/python -m compileall -q src benchmarks
	$(BIN)/python -m tests.compile_kernels
	touch $@

# compiled kernels are found by their sources alone: old ones only take room
clean-cache:
	find src -name '*.nb[ic]' -delete
	rm -f .venv/compiled

clean: clean-cache
	rm -rf .venv out build dist src/*.egg-info
