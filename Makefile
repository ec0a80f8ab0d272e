# qstereo. `make help` lists what can be made.
#
# CC, CXX, CFLAGS, CXXFLAGS, CPPFLAGS, LDFLAGS, PREFIX and DESTDIR are yours; flags that the code needs are added apart.

VERSION := $(shell sed -n 's/^#define QS_VERSION "\(.*\)"/\1/p' libqstereo/include/qstereo/version.h)
SONAME := libqstereo.so.0

CC ?= cc
CXX ?= c++
CFLAGS ?= -O3 -g
CXXFLAGS ?= -O2 -g
PREFIX ?= /usr/local
DESTDIR ?=
BUILD ?= build
# 0 builds a command that reads and writes PGM, PPM and PFM by itself; unset, what was built last is built again.
OPENCV ?= $(shell cat $(BUILD)/.kind 2>/dev/null || echo 1)
# Installs missing Debian packages where set; empty leaves the machine alone.
NEED ?= scripts/need

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

CLI := $(BUILD)/cli-opencv$(OPENCV)
CLI_SRC := $(filter-out cli/picture_none.c,$(wildcard cli/*.c))
ifeq ($(OPENCV),1)
CLI_OBJ := $(CLI_SRC:cli/%.c=$(CLI)/%.o) $(CLI)/picture_opencv.o
OPENCV_CPPFLAGS ?= $(shell pkg-config --cflags opencv4 2>/dev/null || echo -I/usr/include/opencv4)
CLI_LINK := $(CXX)
CLI_LIBS := -lopencv_imgcodecs -lopencv_core
OPENCV_STAMP := $(BUILD)/.opencv
else
CLI_OBJ := $(CLI_SRC:cli/%.c=$(CLI)/%.o) $(CLI)/picture_none.o
CLI_LINK := $(CC)
CLI_LIBS :=
endif

UNIT := $(patsubst tests/unit/%.c,$(BUILD)/unit/%,$(wildcard tests/unit/test_*.c tests/unit/*/test_*.c))
SANITIZE := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all
UNIT_LIB := $(LIB_SRC:libqstereo/src/%.c=$(BUILD)/unit/lib/%.o)

EXAMPLES := $(patsubst %.c,$(BUILD)/%,$(wildcard examples/*.c))

PYTHON ?= python3
# Scenes in Middlebury's layout, for bench and reproduce.
DATA ?= $(wildcard ../shared/data/middlebury)
BIN := .venv/bin
ENV := .venv/.ready

.DEFAULT_GOAL := all
.DELETE_ON_ERROR:
.PHONY: all run check check-c check-python examples bench bench-embedding reproduce install uninstall clean help FORCE

all: $(BUILD)/qstereo $(BUILD)/libqstereo.a $(BUILD)/libqstereo.so $(BUILD)/qstereo.pc ## build the library and the command (OPENCV=0: without OpenCV)

run: all $(ENV) ## encode a sample pair, solve it with the local annealer, decode, validate and score it
	@BUILD=$(BUILD) BIN=$(BIN) scripts/demo

check: check-c check-python ## run every test

check-c: $(UNIT) $(BUILD)/libqstereo.a
	@for test in $(UNIT); do $$test || exit 1; done
	@scripts/check-symbols $(BUILD)/libqstereo.a
	@scripts/check-freestanding "$(CC)"

check-python: all examples $(ENV) $(BUILD)/no-opencv/qstereo
	QSTEREO=$(abspath $(BUILD))/qstereo QSTEREO_PNM=$(abspath $(BUILD))/no-opencv/qstereo QSTEREO_BRIDGE=$(abspath $(BIN))/qstereo-bridge \
	    $(BIN)/python -m pytest -q -n 2 tests

examples: $(EXAMPLES) ## build the programs of examples/

bench: all $(ENV) $(BUILD)/bench_encode ## measure speed, memory and sizes beside public tools
	@$(BUILD)/bench_encode
	@$(BIN)/python tests/bridge/bench_bridge.py
	@$(BIN)/python tests/bridge/bench_upload.py
	@$(BIN)/python tests/bench/bench_solvers.py --qstereo $(BUILD)/qstereo $(if $(DATA),--data $(DATA))
	@$(BIN)/python tests/bench/bench_anneal.py --qstereo $(BUILD)/qstereo --bridge $(BIN)/qstereo-bridge $(if $(DATA),--data $(DATA))
	@$(BIN)/python tests/bench/bench_reduce.py --qstereo $(BUILD)/qstereo --bridge $(BIN)/qstereo-bridge $(if $(DATA),--data $(DATA))

bench-embedding: all $(ENV) ## the largest windows that embed into D-Wave's chips, in each encoding (about an hour)
	@$(BIN)/python tests/bench/bench_embedding.py --qstereo $(BUILD)/qstereo

reproduce: all ## run every solver on the scenes of DATA=folder (Middlebury's layout) and print the paper's table
	@scripts/reproduce --qstereo $(BUILD)/qstereo $(DATA)

install: all ## install command, library, headers and man page under PREFIX (default /usr/local)
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/lib/pkgconfig $(DESTDIR)$(PREFIX)/include/qstereo $(DESTDIR)$(PREFIX)/share/man/man1
	install -m 755 $(BUILD)/qstereo $(DESTDIR)$(PREFIX)/bin/
	install -m 644 $(BUILD)/libqstereo.a $(DESTDIR)$(PREFIX)/lib/
	install -m 755 $(BUILD)/libqstereo.so.$(VERSION) $(DESTDIR)$(PREFIX)/lib/
	ln -sf libqstereo.so.$(VERSION) $(DESTDIR)$(PREFIX)/lib/$(SONAME)
	ln -sf $(SONAME) $(DESTDIR)$(PREFIX)/lib/libqstereo.so
	install -m 644 libqstereo/include/qstereo.h $(DESTDIR)$(PREFIX)/include/
	install -m 644 libqstereo/include/qstereo/*.h $(DESTDIR)$(PREFIX)/include/qstereo/
	sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(VERSION)|' libqstereo/qstereo.pc.in > $(DESTDIR)$(PREFIX)/lib/pkgconfig/qstereo.pc
	install -m 644 docs/qstereo.1 $(DESTDIR)$(PREFIX)/share/man/man1/

uninstall: ## remove what install put there
	rm -f $(DESTDIR)$(PREFIX)/bin/qstereo $(DESTDIR)$(PREFIX)/lib/libqstereo.a $(DESTDIR)$(PREFIX)/lib/libqstereo.so* \
	    $(DESTDIR)$(PREFIX)/lib/pkgconfig/qstereo.pc $(DESTDIR)$(PREFIX)/include/qstereo.h $(DESTDIR)$(PREFIX)/share/man/man1/qstereo.1
	rm -rf $(DESTDIR)$(PREFIX)/include/qstereo

clean: ## remove build products (the .venv stays)
	rm -rf $(BUILD)

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/\1\t\2/p' Makefile | expand -t 12

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

$(BUILD)/libqstereo.so.$(VERSION): $(PIC_OBJ)
	$(call say,LINK,$@)
	$(Q)$(CC) $(CFLAGS) $(LDFLAGS) -shared -Wl,-soname,$(SONAME) $^ -o $@

$(BUILD)/libqstereo.so: $(BUILD)/libqstereo.so.$(VERSION)
	$(Q)ln -sf $(<F) $(BUILD)/$(SONAME)
	$(Q)ln -sf $(SONAME) $@

$(BUILD)/qstereo.pc: libqstereo/qstereo.pc.in libqstereo/include/qstereo/version.h
	@mkdir -p $(@D)
	$(Q)sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(VERSION)|' $< > $@

# The command. Objects of the two kinds live apart; the link remembers which kind it was.

$(CLI)/%.o: cli/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) -c $< -o $@

$(CLI)/%.o: cli/%.cpp | $(OPENCV_STAMP)
	@mkdir -p $(@D)
	$(call say,CXX,$@)
	$(Q)$(CXX) -std=c++17 -Wall -Wextra -MMD -MP $(CPPFLAGS) $(OPENCV_CPPFLAGS) $(INCLUDE) $(CXXFLAGS) -c $< -o $@

$(BUILD)/.kind: FORCE
	@mkdir -p $(@D)
	@echo $(OPENCV) | cmp -s - $@ || echo $(OPENCV) > $@

$(BUILD)/qstereo: $(CLI_OBJ) $(BUILD)/libqstereo.a $(BUILD)/.kind
	$(call say,LINK,$@)
	$(Q)$(CLI_LINK) $(CFLAGS) $(LDFLAGS) $(CLI_OBJ) $(BUILD)/libqstereo.a $(CLI_LIBS) -lm -o $@

$(BUILD)/no-opencv/qstereo: FORCE
	@$(MAKE) --no-print-directory OPENCV=0 BUILD=$(BUILD)/no-opencv $@

$(BUILD)/.opencv:
	@mkdir -p $(@D)
	@$(if $(NEED),$(NEED) g++ pkg-config libopencv-imgcodecs-dev)
	@touch $@

# Unit tests: with the library's private headers, under the sanitizers.

$(BUILD)/.cmocka:
	@mkdir -p $(@D)
	@$(if $(NEED),$(NEED) libcmocka-dev)
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
	$(Q)$(CC) $(SANITIZE) $^ -lcmocka -o $@

$(BUILD)/examples/%: examples/%.c $(BUILD)/libqstereo.a
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) $(LDFLAGS) $< $(BUILD)/libqstereo.a -o $@

$(BUILD)/pack_problem: tests/bench/pack_problem.c $(BUILD)/libqstereo.a
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) $(INCLUDE) $< $(BUILD)/libqstereo.a -o $@

$(BUILD)/bench_encode: tests/bench/bench_encode.c $(BUILD)/libqstereo.a
	$(call say,CC,$@)
	$(Q)$(CC) $(C_FLAGS) -D_POSIX_C_SOURCE=200809L $(INCLUDE) $< $(BUILD)/libqstereo.a -o $@

# The Python environment: the bridge (from this tree), the tests and the benchmarks.

$(ENV): requirements.txt bridge/pyproject.toml
	@$(if $(NEED),$(NEED) python3-venv)
	@echo "setting up .venv (about half a minute)"
	$(Q)test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(Q)$(BIN)/python -m pip install -q --disable-pip-version-check -r requirements.txt
	$(Q)$(BIN)/python -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e bridge
	@touch $@

.SECONDARY:
-include $(wildcard $(BUILD)/*/*.d $(BUILD)/*/*/*.d $(BUILD)/*/*/*/*.d)
