# qstereo. `make help` lists what can be made.
#
# CC, CXX, CFLAGS, CXXFLAGS, CPPFLAGS, LDFLAGS, PREFIX, LIBDIR, MANDIR, DOCDIR and DESTDIR are
# yours. Flags that the code needs are added apart.

HEADERS := libqstereo/include/qstereo.h $(wildcard libqstereo/include/qstereo/*.h)
VERSION := $(shell sed -n 's/^\#define QS_VERSION *"\(.*\)"/\1/p' $(HEADERS))
SONAME := libqstereo.so.0

CC ?= cc
CXX ?= c++
CFLAGS ?= -O3 -g
CXXFLAGS ?= -O2 -g
PREFIX ?= /usr/local
LIBDIR ?= $(PREFIX)/lib
MANDIR ?= $(PREFIX)/share/man
DOCDIR ?= $(PREFIX)/share/doc/qstereo
DESTDIR ?=
# 1 installs command and library without symbols for debugging.
INSTALL_STRIP ?=
BUILD ?= build
# 0 builds a command that reads and writes PGM, PPM and PFM by itself, without OpenCV.
# If it is not given, the kind that was built last is built again.
OPENCV ?= $(shell cat $(BUILD)/.kind 2>/dev/null || echo 1)
# What is called when a package is missing. Plain make names it; run and check install it.
# NEED= says and installs nothing.
NEED := scripts/need
run check check-c check-python check-style: NEED := scripts/need --install
check-trust check-cortex-m check-browser check-units: NEED := scripts/need --install
check-warnings check-analysis: NEED := scripts/need --install
paper deb wheel docs check-packages: NEED := scripts/need --install
check-valgrind coverage fuzz: NEED := scripts/need --install

# V=1 shows every command.
V ?=
Q := $(if $(V),,@)
say = $(if $(V),,@printf '  %-7s %s\n' $(1) $(2))

WARN := -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror=implicit-function-declaration
C_FLAGS = -std=c99 $(WARN) -MMD -MP $(CPPFLAGS) $(CFLAGS)
INCLUDE := -Ilibqstereo/include

LIB_SRC := $(wildcard libqstereo/src/*/*.c)
LIB_OBJ := $(LIB_SRC:libqstereo/src/%.c=$(BUILD)/lib/%.o)
PIC_OBJ := $(LIB_SRC:libqstereo/src/%.c=$(BUILD)/pic/%.o)

CLI := $(BUILD)/opencv$(OPENCV)
CLI_SRC := $(filter-out cli/pictures/picture_none.c,$(wildcard cli/*.c cli/*/*.c))
ifeq ($(OPENCV),1)
CLI_OBJ := $(CLI_SRC:cli/%.c=$(BUILD)/cli/%.o) $(BUILD)/cli/pictures/picture_opencv.o
OPENCV_CPPFLAGS ?= $(shell pkg-config --cflags opencv4 2>/dev/null || echo -I/usr/include/opencv4)
CLI_LINK := $(CXX)
CLI_LIBS := -lopencv_imgcodecs -lopencv_core
OPENCV_STAMP := $(BUILD)/.opencv
else
CLI_OBJ := $(CLI_SRC:cli/%.c=$(BUILD)/cli/%.o) $(BUILD)/cli/pictures/picture_none.o
CLI_LINK := $(CC)
CLI_LIBS :=
REMEMBERED := echo "Built without OpenCV. This is remembered; make OPENCV=1 builds with it."
endif

UNIT := $(patsubst tests/unit/%.c,$(BUILD)/unit/%, \
    $(wildcard tests/unit/test_*.c tests/unit/*/test_*.c))
SANITIZE := -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all
UNIT_LIB := $(LIB_SRC:libqstereo/src/%.c=$(BUILD)/unit/lib/%.o)

EXAMPLES := $(patsubst %.c,$(BUILD)/%,$(wildcard examples/*.c))

PYTHON ?= python3
# Scenes in Middlebury's layout, for bench and paper.
DATA ?= $(wildcard ../shared/data/middlebury)
BIN := .venv/bin
ENV := .venv/.ready
PIP := $(BIN)/python -m pip install -q --disable-pip-version-check

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all run check check-style check-c check-python examples bench bench-embedding paper-qpu \
    paper install uninstall clean help FORCE

all: $(addprefix $(BUILD)/,qstereo libqstereo.a libqstereo.so) ## build (OPENCV=0: without OpenCV)
	@$(REMEMBERED)

run: all $(ENV) ## encode, solve, decode, validate and score a sample pair
	@BUILD=$(BUILD) BIN=$(BIN) OPENCV=$(OPENCV) scripts/demo

check: check-style check-c check-python check-trust ## run every test

check-style: $(ENV)
	@scripts/check-style $(BIN)

check-c: $(UNIT) $(BUILD)/libqstereo.a
	@for test in $(UNIT); do $$test || exit 1; done
	@scripts/check-symbols $(BUILD)/libqstereo.a
	@scripts/check-freestanding "$(CC)"
	@scripts/check-layers
	@scripts/check-circles $(BUILD)/libqstereo.a

# Tests want a command of each kind, whatever kind build/qstereo is.
check-python: all examples $(ENV) $(BUILD)/opencv1/qstereo $(BUILD)/opencv0/qstereo
	@QSTEREO=$(abspath $(BUILD))/opencv1/qstereo QSTEREO_PNM=$(abspath $(BUILD))/opencv0/qstereo \
	    QSTEREO_BRIDGE=$(abspath $(BIN))/qstereo-bridge $(BIN)/python -m pytest -q -n 2 \
	    --ignore tests/trust tests

examples: $(EXAMPLES) ## build the programs of examples/

BENCHES ?= encode passes costs bridge upload solvers anneal reduce problems windows
# Figures for the pages are those of real scenes.
FIGURES := $(if $(DATA),docs/figures,$(BUILD)/figures)

bench: $(BUILD)/bench_encode $(BUILD)/bench_passes $(BUILD)/pack_problem
bench: all $(ENV) ## measure, and write the pages' figures (DATA=scenes)
	@for bench in $(BENCHES); do \
	    $(BIN)/python tests/bench/bench_$$bench.py --build $(BUILD) --bridge $(BIN)/qstereo-bridge \
	        --figures $(FIGURES) $(if $(DATA),--data $(DATA)) || exit 1; \
	done
	@scripts/figures $(if $(DATA),,--show $(FIGURES))

paper-qpu: ## whole scenes on a stand-in of the annealer with its noise (DATA=scenes)
	@$(MAKE) --no-print-directory bench BENCHES=windows

bench-embedding: all $(ENV) ## the largest windows that embed into D-Wave's chips (about an hour)
	@$(BIN)/python tests/bench/bench_embedding.py --build $(BUILD) --figures docs/figures
	@scripts/figures

# SAMPLES: a folder with samples of services. WHOLE=1: the whole scenes, too.
paper: all $(ENV) ## the paper's evaluation on the scenes of DATA=folder, as a page: build/paper
	@$(BIN)/python scripts/paper --qstereo $(BUILD)/qstereo --bridge $(BIN)/qstereo-bridge \
	    -o $(BUILD)/paper $(if $(SAMPLES),--samples $(SAMPLES)) $(if $(WHOLE),--whole) $(DATA)

BASHDIR := $(PREFIX)/share/bash-completion/completions
ZSHDIR := $(PREFIX)/share/zsh/site-functions
DOCUMENTS := README.md NEWS LICENSE CITATION.cff CONTRIBUTING.md SECURITY.md \
    $(wildcard docs/*.png docs/*.md examples/*.c) examples/README.md
# $(call of_prefix,DIR): DIR as pkg-config's file has it.
of_prefix = $(patsubst $(PREFIX)/%,$${prefix}/%,$(1))

# Also yours: LIBDIR, MANDIR, DOCDIR, INSTALL_STRIP=1.
install: all ## install command, library, headers and documents under PREFIX (/usr/local)
	install -d $(addprefix $(DESTDIR),$(PREFIX)/bin $(LIBDIR)/pkgconfig \
	    $(PREFIX)/include/qstereo $(MANDIR)/man1 $(DOCDIR)/docs $(DOCDIR)/examples \
	    $(BASHDIR) $(ZSHDIR))
	install -m 755 $(BUILD)/qstereo $(DESTDIR)$(PREFIX)/bin/
	install -m 644 $(BUILD)/libqstereo.a $(DESTDIR)$(LIBDIR)/
	install -m 755 $(BUILD)/libqstereo.so.$(VERSION) $(DESTDIR)$(LIBDIR)/
	$(if $(filter 1,$(INSTALL_STRIP)),strip --strip-unneeded $(addprefix $(DESTDIR), \
	    $(PREFIX)/bin/qstereo $(LIBDIR)/libqstereo.a $(LIBDIR)/libqstereo.so.$(VERSION)))
	ln -sf libqstereo.so.$(VERSION) $(DESTDIR)$(LIBDIR)/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(LIBDIR)/libqstereo.so
	install -m 644 libqstereo/include/qstereo.h $(DESTDIR)$(PREFIX)/include/
	install -m 644 libqstereo/include/qstereo/*.h $(DESTDIR)$(PREFIX)/include/qstereo/
	sed 's|@PREFIX@|$(PREFIX)|; s|@LIBDIR@|$(call of_prefix,$(LIBDIR))|; s|@VERSION@|$(VERSION)|' \
	    libqstereo/qstereo.pc.in > $(DESTDIR)$(LIBDIR)/pkgconfig/qstereo.pc
	install -m 644 docs/qstereo.1 $(DESTDIR)$(MANDIR)/man1/
	$(BUILD)/qstereo --completion bash > $(DESTDIR)$(BASHDIR)/qstereo
	$(BUILD)/qstereo --completion zsh > $(DESTDIR)$(ZSHDIR)/_qstereo
	install -m 644 $(filter-out docs/% examples/%,$(DOCUMENTS)) $(DESTDIR)$(DOCDIR)/
	install -m 644 $(filter docs/%,$(DOCUMENTS)) $(DESTDIR)$(DOCDIR)/docs/
	install -m 644 $(filter examples/%,$(DOCUMENTS)) $(DESTDIR)$(DOCDIR)/examples/

uninstall: ## remove what install put there
	rm -f $(addprefix $(DESTDIR),$(PREFIX)/bin/qstereo $(LIBDIR)/libqstereo.a \
	    $(LIBDIR)/libqstereo.so* $(LIBDIR)/pkgconfig/qstereo.pc \
	    $(PREFIX)/include/qstereo.h $(MANDIR)/man1/qstereo.1 \
	    $(BASHDIR)/qstereo $(ZSHDIR)/_qstereo)
	rm -rf $(DESTDIR)$(PREFIX)/include/qstereo
	rm -f $(addprefix $(DESTDIR)$(DOCDIR)/,$(DOCUMENTS))
	-rmdir $(addprefix $(DESTDIR)$(DOCDIR)/,docs examples) $(DESTDIR)$(DOCDIR) 2>/dev/null

clean: ## remove build products (the .venv stays)
	rm -rf $(BUILD)

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' $(MAKEFILE_LIST) | expand -t 17

# The library, static and shared.

$(BUILD)/lib/%.o: libqstereo/src/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) -c $< -o $@

$(BUILD)/pic/%.o: libqstereo/src/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) -fPIC -c $< -o $@

$(BUILD)/libqstereo.a: $(LIB_OBJ)
	$(call say,AR,$@)
	$(Q)rm -f $@
	$(Q)$(AR) rcs $@ $^

$(BUILD)/libqstereo.map: scripts/export-map $(HEADERS)
	@mkdir -p $(@D)
	$(Q)scripts/export-map "$(CC)" > $@

$(BUILD)/libqstereo.so.$(VERSION): $(BUILD)/libqstereo.map $(PIC_OBJ)
	$(call say,LINK,$@)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -shared -Wl,-soname,$(SONAME),--version-script=$< \
	    $(PIC_OBJ) -o $@

$(BUILD)/libqstereo.so: $(BUILD)/libqstereo.so.$(VERSION)
	$(Q)ln -sf $(<F) $(BUILD)/$(SONAME)
	$(Q)ln -sf $(SONAME) $@

# The command. The two kinds differ in one object; .kind remembers which one build/qstereo is.

$(BUILD)/cli/%.o: cli/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) -Icli -c $< -o $@

$(BUILD)/cli/%.o: cli/%.cpp | $(OPENCV_STAMP)
	@mkdir -p $(@D)
	$(call say,CXX,$@)
	$(Q)$(CXX) -std=c++17 -Wall -Wextra -MMD -MP $(CPPFLAGS) $(OPENCV_CPPFLAGS) $(INCLUDE) -Icli \
	    $(CXXFLAGS) -c $< -o $@

$(BUILD)/.kind: FORCE
	@mkdir -p $(@D)
	@echo $(OPENCV) | cmp -s - $@ || echo $(OPENCV) > $@

$(CLI)/qstereo: $(CLI_OBJ) $(BUILD)/libqstereo.a
	@mkdir -p $(@D)
	$(call say,LINK,$@)
	$(Q)$(CLI_LINK) $(CFLAGS) $(LDFLAGS) $(CLI_OBJ) $(BUILD)/libqstereo.a $(CLI_LIBS) -lm -pthread \
	    -o $@

$(BUILD)/qstereo: $(CLI)/qstereo $(BUILD)/.kind
	$(Q)cp -f $< $@

# The command of the other kind, after this one, whose objects it shares.
OTHER := $(if $(filter 0,$(OPENCV)),1,0)
$(BUILD)/opencv$(OTHER)/qstereo: $(CLI)/qstereo FORCE
	@$(MAKE) --no-print-directory OPENCV=$(OTHER) NEED="$(NEED)" $@

# $(call need,TEST,PACKAGES): the packages, unless the shell command TEST works.
need = $(if $(NEED),@{ $(1); } >/dev/null 2>&1 || $(NEED) $(2))

$(BUILD)/.opencv: export HINT := Without OpenCV: make OPENCV=0 (PGM, PPM and PFM only).
$(BUILD)/.opencv:
	@mkdir -p $(@D)
	$(call need,echo '#include <opencv2/imgcodecs.hpp>' | $(CXX) $(OPENCV_CPPFLAGS) -E -x c++ -, \
	    g++ pkg-config libopencv-imgcodecs-dev)
	@touch $@

# Unit tests: with the library's private headers, under the sanitizers.

$(BUILD)/.cmocka:
	@mkdir -p $(@D)
	$(call need,echo '#include <cmocka.h>' | $(CC) $(CPPFLAGS) -E -,libcmocka-dev)
	@touch $@

$(BUILD)/unit/lib/%.o: libqstereo/src/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(SANITIZE) -c $< -o $@

$(BUILD)/unit/%.o: tests/unit/%.c | $(BUILD)/.cmocka
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) -UNDEBUG $(INCLUDE) -Itests/unit -Ilibqstereo/src $(SANITIZE) -c $< -o $@

$(UNIT): $(BUILD)/unit/%: $(BUILD)/unit/%.o $(BUILD)/unit/tiny.o $(BUILD)/unit/slow.o $(UNIT_LIB)
	$(call say,LINK,$@)
	$(Q)$(CC) $(SANITIZE) $^ -lcmocka -lm -o $@

$(BUILD)/examples/%: examples/%.c $(BUILD)/libqstereo.a
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) $(LDFLAGS) $< $(BUILD)/libqstereo.a -o $@

$(BUILD)/pack_problem: tests/bench/pack_problem.c $(BUILD)/libqstereo.a
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) $< $(BUILD)/libqstereo.a -o $@

$(BUILD)/bench_encode $(BUILD)/bench_passes: $(BUILD)/%: tests/bench/%.c tests/bench/bench.h \
    $(BUILD)/libqstereo.a
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) -D_POSIX_C_SOURCE=200809L $(INCLUDE) $< $(BUILD)/libqstereo.a -o $@

# The Python environment: the bridge (from this tree), the tests and the benchmarks.

$(ENV): requirements.txt bridge/pyproject.toml
	$(call need,test -x $(BIN)/python || $(PYTHON) -c 'import ensurepip',python3-venv)
	@echo "setting up .venv (about half a minute)"
	$(Q)test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(Q)$(PIP) -r requirements.txt
	$(Q)$(PIP) --no-deps --no-build-isolation -e bridge
	@touch $@

include packaging.mk
include tests/fuzz/fuzz.mk tests/trust/trust.mk tests/trust/all.mk

.SECONDARY:
# Builds inside this one follow their headers by themselves.
INNER := targets units warnings analysis valgrind threads coverage
-include $(shell find $(BUILD) $(INNER:%=-path $(BUILD)/% -prune -o) -name '*.d' -print 2>/dev/null)
