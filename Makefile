# What there is to do: make run | test | lint | circles | dashboard | bench | figures

CARGO ?= cargo
LISTEN ?= 127.0.0.1:8080
DATA ?= data
TARGET := $(or $(CARGO_TARGET_DIR),target)
EVSWARM := $(TARGET)/release/evswarm
CARGO_DENY := target/tools/bin/cargo-deny
CARGO_DENY_VERSION := 0.20.2

DASHBOARD := server/dashboard

.PHONY: build run dashboard dashboard-pictures dashboard-rate test test-rust test-python test-contract test-dashboard lint circles deny bench figures

build:
	$(CARGO) build --release --workspace --lib --bins --examples

# Serves at LISTEN, says what to open and, unless DATA holds jobs already, posts the README's first
# job and follows it. Ctrl-C stops the server, which keeps what its runs have done; the next
# `make run` goes on from there.
run: export EVSWARM_SERVER = http://$(LISTEN)
run: build
	@(for try in 1 2 3 4 5 6 7 8 9 10; do \
		sleep 0.5; \
		jobs=$$($(EVSWARM) status 2>/dev/null) || continue; \
		echo "Open $$EVSWARM_SERVER/ in a browser. For the README's commands, in another shell:"; \
		echo "  export EVSWARM_SERVER=$$EVSWARM_SERVER"; \
		test -n "$$jobs" && break; \
		$(EVSWARM) submit experiments/first-job.json --watch && \
			echo "The first job is done: $$EVSWARM_SERVER/ shows what it found."; \
		break; \
	done) & exec $(EVSWARM) serve --listen $(LISTEN) --data $(DATA)

test: test-rust test-python test-contract test-dashboard

# The end-to-end tests start the binaries that `build` makes.
test-rust: build
	$(CARGO) test --release --workspace

# The page: its built files are checked in, so that the program builds with Cargo alone.
dashboard: $(DASHBOARD)/node_modules
	cd $(DASHBOARD) && npm run --silent build

$(DASHBOARD)/node_modules: $(DASHBOARD)/package-lock.json
	cd $(DASHBOARD) && npm ci --no-audit --no-fund && touch node_modules

# Whether the built files are those of the sources, then the page in Chromium before a real server.
test-dashboard: build dashboard
	git diff --exit-code --stat -- $(DASHBOARD)/dist
	cd $(DASHBOARD) && npm test --silent && \
		CARGO_TARGET_DIR=$(abspath $(TARGET)) npm run --silent browser

# Pictures of the page, made by its tests; those that documents show are checked in.
SHOWN := job sweep run replay explained new editor overview overview-dark run-phone
dashboard-pictures: build dashboard
	mkdir -p $(TARGET)/pictures
	cd $(DASHBOARD) && PICTURES=$(abspath $(TARGET))/pictures CARGO_TARGET_DIR=$(abspath $(TARGET)) \
		npm run --silent browser
	cp $(SHOWN:%=$(TARGET)/pictures/dashboard-%.png) docs/pictures/

# How fluid a thousand robots are, and the first paint: for a quiet machine.
dashboard-rate: build $(DASHBOARD)/node_modules
	cd $(DASHBOARD) && CARGO_TARGET_DIR=$(abspath $(TARGET)) npm run --silent rate

# The Python client against the real server, in an environment of its own.
VENV := $(TARGET)/python
test-python: build $(VENV)/made
	cd clients/python && $(abspath $(VENV))/bin/ruff check . && $(abspath $(VENV))/bin/mypy \
		&& CARGO_TARGET_DIR=$(abspath $(TARGET)) $(abspath $(VENV))/bin/python -m pytest

# The OpenAPI document against a real server, by requests made of it at random.
SCHEMATHESIS_VERSION := 4.32.5
CONTRACT_VENV := $(TARGET)/contract
CONTRACT_SECONDS ?= 60
CONTRACT_SEED ?= 1
test-contract: build $(CONTRACT_VENV)/made-$(SCHEMATHESIS_VERSION)
	loadtests/contract/run.sh $(abspath $(EVSWARM)) $(abspath $(CONTRACT_VENV))/bin/schemathesis \
		$(CONTRACT_SECONDS) $(CONTRACT_SEED)

$(CONTRACT_VENV)/made-$(SCHEMATHESIS_VERSION):
	python3 -m venv $(CONTRACT_VENV)
	$(CONTRACT_VENV)/bin/pip install --quiet --disable-pip-version-check \
		schemathesis==$(SCHEMATHESIS_VERSION)
	touch $@

$(VENV)/made: clients/python/pyproject.toml
	python3 -m venv $(VENV)
	$(VENV)/bin/pip install --quiet --disable-pip-version-check -e 'clients/python[test]'
	touch $@

lint: deny circles
	$(CARGO) fmt --all --check
	$(CARGO) clippy --workspace --all-targets --release -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --workspace --no-deps --release

# Files of a crate that import each other in a circle.
circles:
	$(CARGO) run --release --quiet -p tests --bin import_circles -- arenas swarm api server recording loadtests tests

# Licences, duplicate bans and sources of all dependencies. Advisories are left out: they need a
# database from the network, and would let a build fail without any change to it.
deny:
	@command -v cargo-deny >/dev/null || test -x $(CARGO_DENY) || \
		$(CARGO) install cargo-deny --version $(CARGO_DENY_VERSION) --locked --root target/tools
	PATH="$$PATH:$(dir $(abspath $(CARGO_DENY)))" $(CARGO) deny check bans licenses sources

bench: build
	$(TARGET)/release/loadtests $(if $(BASE),--base $(BASE)) $(ARGS)

# Measures everything and puts the figures into docs/performance.md, with the picture.
figures: build
	$(TARGET)/release/loadtests --full --document docs/performance.md \
		--picture docs/pictures/scaling.svg $(ARGS)
