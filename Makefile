# Needs Python 3.11 or newer and GNU make 3.81 or newer. The first call makes a virtual environment in .venv; a change
# of pyproject.toml updates it. After that no target needs a network.
# Windows without make: CONTRIBUTING.md gives the same steps with pip.

PYTHON ?= python3

# Searched if PYTHON was not set by hand and python3 is too old.
others := $(if $(filter file,$(origin PYTHON)),python3.14 python3.13 python3.12 python3.11)
venv_python := .venv/bin/python

# An environment breaks without a message if its folder was moved or copied (its scripts have the old path), or if its Python
# was removed. Both cause a new installation.
$(shell [ -x $(venv_python) ] && [ "$$(cat .venv/installed 2>/dev/null)" = "$$(pwd -P)" ] || rm -f .venv/installed)

.DEFAULT_GOAL := help
.PHONY: help demo test newest unlocked notebooks fleet docs site page package browser cable hour phone-in-guest fuzz soak check bench causes audit sbom lock clean

# What was compiled is kept: each worker of the tests, and each program that they start, would compile all again.
unexport PYTHONDONTWRITEBYTECODE

# Every package that is installed here, also those that build ours, has the version and a hash of requirements/lock.txt.
install := requirements/install.py

help: ## list these targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' Makefile

demo: .venv/installed ## the product with a virtual car: no cable needed
	@.venv/bin/mikas demo

# The tests of these three run with coverage, all others without: measuring halves the speed of long runs.
gated := tests/test_framing.py tests/commands tests/catalog

# Folders with targets of their own.
elsewhere := tests/browser tests/docs_in_browser tests/static_site tests/in_firefox tests/on_pyodide tests/cable \
  tests/notebooks tests/installing tests/fleet_real

test: .venv/with-test web/node_modules/installed ## all tests but those in a browser and on a cable; framing, commands, catalog: 100 % branches
	@$(venv_python) -m pytest -n logical --dist worksteal $(gated) --cov=mikas.framing --cov=mikas.commands --cov=mikas.catalog \
	  --cov-fail-under=100 --cov-report=term-missing:skip-covered
	@$(venv_python) -m pytest -n auto --dist worksteal $(foreach path,$(gated) $(elsewhere),--ignore=$(path))
	@$(npm) test

# The rooms that a new Python breaks first: the codec, data, asyncio and threads, the command line. No server, no broker, and
# no long recordings: what they test is the same on every Python, and the gate has 45 minutes.
fast := $(gated) tests/tester tests/client tests/sampling/test_acquisition.py tests/cli/test_main.py tests/cli/test_output.py

newest: .venv/with-test ## a fast part of the tests on the newest Python of this computer, if it is newer than that of .venv
	@$(find_newest); \
	if [ -z "$$python" ]; then echo "newest: no Python here is newer than that of .venv; nothing more is tested"; exit 0; fi; \
	made_for="$$("$$python" --version), $$(cat pyproject.toml requirements/lock.txt | cksum)"; \
	echo "newest: $$("$$python" --version)"; \
	if [ "$$(cat build/newest/made-for 2>/dev/null)" != "$$made_for" ]; then \
	  mkdir -p build && "$$python" -m venv --clear build/newest && build/newest/bin/python $(install) mikas test && \
	  echo "$$made_for" > build/newest/made-for; \
	fi && build/newest/bin/python -m pytest -n logical --dist worksteal $(fast)

# Pre-releases as well: make unlocked PRE=--pre
PRE ?=
unlocked_python := build/unlocked/bin/python

unlocked: .venv/with-test ## the tests of `make test` on the newest releases of all packages, without the lock (needs a network)
	@rm -rf build/unlocked && mkdir -p build && $(venv_python) -m venv build/unlocked
	@$(unlocked_python) $(install) --newest $(PRE) mikas extras test
	@$(unlocked_python) requirements/differences.py
	@$(unlocked_python) -m pytest -n auto --dist worksteal $(foreach path,$(elsewhere),--ignore=$(path))

notebooks: .venv/with-test ## the example notebooks in a real kernel: each cell, and whether the results in them are stale
	@$(venv_python) -m pytest -n logical tests/notebooks

docs: build/docs/index.html ## this documentation as a site into build/docs, English and Russian (docs/development/docs.md)
	@echo "Open build/docs/index.html, or put the folder build/docs on a web server, under any address"

site: build/site/docs/index.html ## the page without installation and the documentation into build/site: a folder for any web server (docs/development/site.md)
	@echo "Put the folder build/site on a web server (https), under any address. On this computer: make page"

page: build/site/docs/index.html ## that page on this computer, in a browser
	@$(venv_python) -m tools.site.serve

package: .venv/with-test ## what people install, into dist/: wheel, sdist, one-folder program, .deb; installed and tried (docs/how-to/install.md)
	@$(venv_python) -m tools.package
	@MIKAS_REQUIRE_PACKAGE=1 $(venv_python) -m pytest -n 2 --dist loadfile tests/installing

# A file is one worker's. These take minutes each, in few tests: begun last, they would run on alone.
longest := tests/browser/test_browser_actions.py tests/static_site/test_site_actions.py

browser: .venv/with-test build/site/docs/index.html ## the tests that drive the page in Chromium and Firefox, and those on Pyodide; pictures of all screens in build/screenshots
	@$(venv_python) -m pytest -n logical --dist loadfile --no-loadscope-reorder $(longest) \
	  tests/static_site tests/browser tests/docs_in_browser tests/in_firefox tests/on_pyodide

fleet: .venv/with-test ## datasets with all that they need: a Dask cluster, S3 (moto), kills, virtual cars with defects; under a minute
	@$(venv_python) -m pytest -n logical --dist loadfile tests/fleet_real

# Three guests on two cores: a test waits for half of its time, in real time, for the line and for timeouts.
cable: .venv/with-test build/cable/unpacked ## the program on a cable under Linux' own drivers, in QEMU: docs/development/cable.md
	@MIKAS_REQUIRE_CABLE=1 $(venv_python) -m pytest -n 3 --dist worksteal tests/cable

# Minutes in real time, and the seed of the events: make hour MINUTES=3 SEED=2
MINUTES ?= 60

hour: .venv/with-test build/cable/unpacked ## an hour of recording in QEMU while the cable is pulled out and put back, nothing wrong or lost
	@PYTHONPATH=tests $(venv_python) -m cable.hour --minutes $(MINUTES) --seed $(SEED)

# Some of its runs, and how many processors the guest has: make phone-in-guest RUNS="detaching unbound" PROCESSORS=1
RUNS ?=
PROCESSORS ?= 2

phone-in-guest: .venv/with-test web/node_modules/installed build/cable/unpacked ## Chromium in QEMU takes the chips by WebUSB from a real kernel: docs/development/cable.md
	@PYTHONPATH=tests $(venv_python) -m cable.phone_in_guest --processors $(PROCESSORS) $(RUNS)

# Seconds for each of four targets, one after another; recordings are read beside them, as long as all four together, by
# cases of SEED: make fuzz SECONDS=3600 SEED=2
SECONDS ?= 45

fuzz: .venv/with-fuzz ## the parsers under mutated inputs, and all readers under hostile recordings (Linux); fails on a finding
	@$(venv_python) -m fuzz --seconds $(SECONDS) --seed $(SEED)

check: .venv/with-check web/node_modules/installed build/docs/index.html ## lint, format, types, import rules, names of changes/, links and examples of the documents
	$(venv_python) -m ruff check .
	$(venv_python) -m ruff format --check .
	$(venv_python) -m mypy
	@$(venv_python) -m tools.public_types
	.venv/bin/lint-imports
	$(venv_python) tools/generate_types.py --check
	@$(venv_python) -m towncrier build --draft --version next >/dev/null
	@$(npm) run check
	@$(venv_python) -m tools.docs.check

# Themes may follow: make bench causes
themes := $(filter-out bench,$(MAKECMDGOALS))

bench: .venv/with-test ## rates, times, memory, kills and full disks against their targets, into docs/development/benchmarks.md: an hour
	@$(venv_python) -m bench $(themes)

ifeq ($(filter bench,$(MAKECMDGOALS)),)
causes: .venv/with-test ## simulate cars with known defects, weigh what speaks for each cause: src/mikas/causes/weights, an hour
	@$(venv_python) -m tools.causes
else
.PHONY: $(themes)
$(themes): bench
	@:
endif

# Exchanges and seed of the campaign; a hundred thousand take a minute or two: make soak EXCHANGES=100000 SEED=2
EXCHANGES ?= 1000000
SEED ?= 1

soak: .venv/with-test ## a million exchanges on a very bad line in simulated time, no value wrong: a quarter of an hour
	@$(venv_python) -m bench.soak --exchanges $(EXCHANGES) --seed $(SEED)

audit: build/audit/installed .venv/installed ## the locked packages against the known advisories (requirements/README.md)
	@PATH="$(CURDIR)/.venv/bin:$$PATH" build/audit/bin/python requirements/audit.py

sbom: build/audit/installed .venv/installed ## the parts of a release (CycloneDX) into build/sbom
	@rm -rf build/sbom && $(venv_python) -m venv build/sbom/venv
	@build/sbom/venv/bin/python $(install) extras
	@build/sbom/venv/bin/python -m pip uninstall --quiet --yes pip setuptools  # no parts of ours
	@build/audit/bin/cyclonedx-py environment --pyproject pyproject.toml --output-reproducible -o build/sbom/mikas.cdx.json build/sbom/venv
	@$(npm) sbom --sbom-format cyclonedx --package-lock-only > build/sbom/page.cdx.json
	@rm -rf build/sbom/venv
	@echo "build/sbom: mikas.cdx.json (Python) and page.cdx.json (the dashboard's page, and what builds it)"

# The newest versions: make lock UPGRADE=--upgrade
UPGRADE ?=

lock: build/audit/installed ## write requirements/lock.txt, after a change of the packages in pyproject.toml
	@build/audit/bin/uv pip compile pyproject.toml --quiet --universal --python-version 3.11 --generate-hashes --no-header \
	  --no-emit-index-url --no-emit-find-links --annotation-style line --all-extras $(addprefix --group ,$(groups)) \
	  $(UPGRADE) --output-file requirements/lock.txt

clean: ## remove .venv and everything else that was generated
	rm -rf .venv .coverage .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache build dist htmlcov \
	  web/node_modules src/mikas/dashboard/page
	find src tests bench fuzz tools -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

groups := test check docs package fuzz build audit

# The page is built on installation, so its sources count as well; those of the site alone do not.
page := pyproject.toml requirements/lock.txt tools/hatch_build.py \
  $(shell find web \( -path web/node_modules -o -path web/src/site -o -name '*site*' \) -prune -o -type f -print 2>/dev/null)

.venv/installed: $(page)
	@[ -f $@ ] || { $(find_python); $(make_venv); }
	@echo "Installing mikas into .venv"
	@$(venv_python) $(install) mikas
	@pwd -P > $@

.venv/with-%: .venv/installed
	@echo "Installing the packages for: $*"
	@$(venv_python) $(install) $*
	@touch $@

.venv/with-check .venv/with-fuzz: .venv/with-test

# An environment of its own, so that `make lock` works when .venv can't be made by the present lock.
build/audit/installed:
	@echo "Installing the packages for: audit"
	@mkdir -p build && $(find_python); "$$python" -m venv --clear build/audit && build/audit/bin/python $(install) audit
	@touch $@

# The page's own tools, with Node from the environment.
npm := PATH="$(CURDIR)/.venv/bin:$$PATH" npm --prefix web --silent

web/node_modules/installed: web/package-lock.json .venv/with-test
	@echo "Installing the packages of the page"
	@$(npm) ci
	@touch $@

site_sources := $(page) $(shell find web/site.html web/vite.site.config.ts web/src/site tools/site src/mikas \
  \( -name __pycache__ -o -path src/mikas/dashboard/page -o -path src/mikas/cli \) -prune -o -type f -print 2>/dev/null)

build/site/files.json: $(site_sources) web/node_modules/installed
	@echo "Building the page without installation"
	@$(venv_python) -m tools.site

docs_sources := pyproject.toml requirements/lock.txt web/public/icon.svg $(shell find docs tools/docs src/mikas \
  \( -name __pycache__ -o -path src/mikas/dashboard/page \) -prune -o -type f -print 2>/dev/null)

build/docs/index.html: $(docs_sources) .venv/with-docs
	@echo "Building the documentation"
	@$(venv_python) -m tools.docs

# Beside the page, and no part of it: neither in files.json nor in its service worker.
build/site/docs/index.html: build/site/files.json build/docs/index.html
	@$(venv_python) -m tools.docs.joining

# Debian's kernel and udev for `make cable`, unpacked here and not installed. Where they can't be had, the tests say so.
build/cable/unpacked:
	@mkdir -p $(@D)
	@cd $(@D) && if $(get_packages); then touch $(@F); fi

define get_packages
kernel=$$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: //p' | head -n 1); \
[ -n "$$kernel" ] && echo "Getting $$kernel and udev" && rm -f ./*.deb && \
apt-get download --quiet=2 "$$kernel" udev && \
for package in ./*.deb; do dpkg-deb --extract "$$package" . || exit 1; done && rm -f ./*.deb
endef

define find_python
python=; \
for candidate in "$(PYTHON)" $(others); do \
  if "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then \
    python=$$candidate; break; \
  fi; \
done; \
if [ -z "$$python" ]; then \
  echo "mikas needs Python 3.11 or newer. These are older or missing: $(PYTHON) $(others)" >&2; \
  echo "Install one, or give its path: make PYTHON=/path/to/python3.12 $(MAKECMDGOALS)" >&2; \
  exit 1; \
fi
endef

# Also those of pyenv that no shim leads to.
define find_newest
main=$$($(venv_python) -c 'import sys; print(sys.version_info[1])'); python=; \
for minor in 15 14 13 12; do \
  [ "$$minor" -gt "$$main" ] || break; \
  for candidate in "python3.$$minor" "$$(pyenv root 2>/dev/null)"/versions/3.$$minor.*/bin/python; do \
    if "$$candidate" -c 'import ensurepip, venv' 2>/dev/null; then python=$$candidate; break 2; fi; \
  done; \
done
endef

define make_venv
if ! "$$python" -c 'import ensurepip, venv' 2>/dev/null; then \
  version=$$("$$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])'); \
  echo "This Python $$version cannot make virtual environments: its ensurepip is missing." >&2; \
  echo "On Debian or Ubuntu: sudo apt install python3-venv   (or python$$version-venv)" >&2; \
  exit 1; \
fi; \
echo "Making .venv with $$("$$python" --version)"; \
"$$python" -m venv --clear .venv
endef
