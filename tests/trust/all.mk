# Everything that takes longer than a check before each commit should. Included by the Makefile.

.PHONY: check-all check-browser check-kills check-units check-warnings check-analysis \
    check-analysis-gcc check-analysis-cppcheck check-analysis-tidy check-valgrind check-threads coverage

# What fails most and what is short comes first.
ALL_PARTS := check-style check-c check-python check-trust check-kills docs check-browser check-threads coverage \
    check-warnings check-analysis check-valgrind check-units check-packages

check-all: ## check, and every unit test on every target, all compilers and analysers, valgrind, coverage, packages; goes on where it ended
	@scripts/check-all $(BUILD)/all $(ALL_PARTS)

# ---- The pages of the bridge in a browser; make check leaves this out where there is none.
check-browser: all $(ENV)
	$(call need,chromium --version,chromium)
	@QSTEREO=$(abspath $(BUILD))/qstereo QSTEREO_BRIDGE=$(abspath $(BIN))/qstereo-bridge \
	    $(BIN)/python -m pytest -q tests/e2e/test_report.py

# ---- Fifty kills -9 of paid runs, at random moments; make check has a few.
check-kills: $(ENV) ## kill paid runs at fifty random moments: each call is charged once
	@QSTEREO_KILLS=50 $(BIN)/python -m pytest -q tests/bridge/test_windows.py \
	    tests/bridge/test_interruptions.py -k killed

# ---- Every unit test on every target: 32 and 64 bits, little- and big-endian, emulated.
# NAME, compiler, Debian's name of the architecture, emulator.
UNIT_TARGETS := i686 aarch64 armhf s390x
UNIT_CC_i686 := i686-linux-gnu
UNIT_CC_aarch64 := aarch64-linux-gnu
UNIT_CC_armhf := arm-linux-gnueabihf
UNIT_CC_s390x := s390x-linux-gnu
UNIT_ARCH_i686 := i386
UNIT_ARCH_aarch64 := arm64
UNIT_ARCH_armhf := armhf
UNIT_ARCH_s390x := s390x
UNIT_RUN_i686 := qemu-i386
UNIT_RUN_aarch64 := qemu-aarch64
UNIT_RUN_armhf := qemu-arm
UNIT_RUN_s390x := qemu-s390x
UNIT_DIR := $(BUILD)/units
UNIT_NAMES := $(patsubst tests/unit/%.c,%,$(wildcard tests/unit/test_*.c tests/unit/*/test_*.c))

# A unit test under UNDER, an emulator or valgrind, in a build of its own. One that passed runs again
# only after it has changed.
UNDER ?=
$(BUILD)/passed/%.log: $(BUILD)/unit/%
	@mkdir -p $(@D)
	@nice $(UNDER) $< >$@.run 2>&1 || { tail -30 $@.run >&2; exit 1; }
	@mv $@.run $@

$(UNIT_DIR)/.packages:
	@mkdir -p $(@D)
	$(call need,aarch64-linux-gnu-gcc --version && arm-linux-gnueabihf-gcc --version,$(TARGET_PACKAGES) \
	    gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-arm-linux-gnueabihf libc6-dev-armhf-cross)
	@touch $@

$(UNIT_DIR)/%/cmocka/usr: | $(UNIT_DIR)/.packages
	@scripts/cmocka-for $(UNIT_ARCH_$*) $(@D)

check-units: $(UNIT_TARGETS:%=check-units-%)

check-units-%: $(UNIT_DIR)/%/cmocka/usr
	@$(MAKE) --no-print-directory -s OPENCV=0 NEED= CC=$(UNIT_CC_$*)-gcc BUILD=$(UNIT_DIR)/$* \
	    SANITIZE="-O1 -I$(UNIT_DIR)/$*/cmocka/usr/include -L$$(dirname $(UNIT_DIR)/$*/cmocka/usr/lib/*/libcmocka.so)" \
	    UNDER="$(UNIT_RUN_$*) -L /usr/$(UNIT_CC_$*) -E LD_LIBRARY_PATH=$$(dirname $(abspath $(UNIT_DIR))/$*/cmocka/usr/lib/*/libcmocka.so)" \
	    $(UNIT_NAMES:%=$(UNIT_DIR)/$*/passed/%.log) >/dev/null
	@echo "$*: $$(cat $(UNIT_NAMES:%=$(UNIT_DIR)/$*/passed/%.log) | grep -c '^\[       OK') unit tests pass"

# ---- No warning of gcc and clang, at any level of optimisation, on 64 and 32 bits. A row of options
# names what it sets, and the rest is 0: clang warns of that, gcc does not. clang warns before it
# optimises, so that two levels are enough for it: the first and the one whose macros differ.
C_SOURCES := $(LIB_SRC) $(wildcard cli/*.c cli/*/*.c)
WARN_ALL := $(WARN) -Wsign-conversion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wundef -Wcast-align \
    -Wwrite-strings -Wformat=2 -Wno-missing-field-initializers -Werror
WARN_CC_gcc := gcc
WARN_CC_gcc32 := i686-linux-gnu-gcc
WARN_CC_clang := clang
WARN_CC_clang32 := clang --target=i686-linux-gnu -I/usr/i686-linux-gnu/include
WARN_RUNS := $(foreach cc,gcc gcc32,$(foreach level,0 1 2 3,$(cc)-$(level))) \
    $(foreach cc,clang clang32,$(foreach level,0 2,$(cc)-$(level)))

# Each object of library and command.
.PHONY: objects
objects: $(LIB_OBJ) $(CLI_OBJ)

# $(call compile,FOLDER,COMPILER,FLAGS): each object in a build of its own. One that was compiled is
# compiled again only after it has changed.
compile = $(MAKE) --no-print-directory -s OPENCV=0 NEED= BUILD=$(BUILD)/$(1) CC="nice $(2)" CFLAGS="$(3)" objects >/dev/null

check-warnings: $(WARN_RUNS:%=check-warnings-%)
	@echo "no warning in $(words $(WARN_RUNS)) builds of $(words $(C_SOURCES)) files"

check-warnings-%: | $(UNIT_DIR)/.packages $(FUZZ)/.clang
	@$(call compile,warnings/$*,$(WARN_CC_$(firstword $(subst -, ,$*))),$(WARN_ALL) -O$(lastword $(subst -, ,$*)))

# ---- Analysers. Each report has been judged; those that are wrong are switched off here, with the reason.
# gcc: a struct that a function returns through a pointer counts as not set (qs_draft's shape); the
#   lanes of a vector count as narrower than they are (bp_avx2.c); an arena has no memory while it
#   counts (arena.h), so gcc takes the memory of every caller for a null pointer. What malloc returns
#   must still be tested: those are warnings of their own, of pointers that are possibly null.
ANALYZER_JUDGED := -Wno-analyzer-use-of-uninitialized-value -Wno-analyzer-shift-count-overflow \
    -Wno-analyzer-null-dereference -Wno-analyzer-null-argument
# cppcheck: a scale is never 0 (decimal.c); vectors of gcc are shifted arithmetically, as gcc documents
#   (bp_avx2.c); an array is read as far as a loop or a function has filled it (mover.c, expansion.c,
#   near.c, trws16_avx2.h); options_read fills its argument.
CPPCHECK_JUDGED := --suppress=zerodivcond:*numbers.c --suppress=shiftTooManyBitsSigned:*bp_avx2.c --suppress=uninitvar:*mover.c \
    --suppress=uninitvar:*expansion.c --suppress=uninitvar:*near.c --suppress=uninitvar:*trws16_avx2.h --suppress=ctuuninitvar:*options.c
# clang-tidy: what printf returns is seen at the end (ferror); strings here need no end (JSON); the
#   macros stringify; a va_list is set by the caller; x_64.c builds x.c again (in_64_bits.h); and the
#   analyser does not know that an index that was built has its arrays, that an arena has memory when
#   it does not count, and that weights are above 0.
TIDY_CHECKS := -*,bugprone-*,cert-*,clang-analyzer-*,-cert-err33-c,-cert-dcl37-c,-cert-dcl51-cpp,$\
    -bugprone-not-null-terminated-result,-bugprone-macro-parentheses,-bugprone-branch-clone,$\
    -bugprone-easily-swappable-parameters,-bugprone-narrowing-conversions,-bugprone-reserved-identifier,$\
    -bugprone-implicit-widening-of-multiplication-result,-clang-analyzer-valist.Uninitialized,$\
    -clang-analyzer-security.insecureAPI.*,-clang-analyzer-core.NullDereference,-clang-analyzer-core.NonNullParamChecker,$\
    -clang-analyzer-core.DivideZero,-bugprone-suspicious-include

# Jobs of cppcheck.
JOBS ?= 2
check-analysis: check-analysis-gcc check-analysis-cppcheck check-analysis-tidy

check-analysis-gcc:
	@$(call compile,analysis/gcc,$(CC),-O2 -fanalyzer $(ANALYZER_JUDGED) -Werror)
	@echo "gcc -fanalyzer: nothing in $(words $(C_SOURCES)) files"

check-analysis-cppcheck:
	$(call need,cppcheck --version,cppcheck)
	@mkdir -p $(BUILD)/analysis/cppcheck
	@nice cppcheck -j $(JOBS) --quiet --std=c99 --enable=warning,performance,portability --error-exitcode=1 \
	    --cppcheck-build-dir=$(BUILD)/analysis/cppcheck $(CPPCHECK_JUDGED) $(FUZZ_INCLUDE) $(C_SOURCES)
	@echo "cppcheck: nothing in $(words $(C_SOURCES)) files"

C_HEADERS := $(HEADERS) $(wildcard libqstereo/src/*/*.h cli/*.h cli/*/*.h)

$(BUILD)/analysis/tidy/%.passed: %.c $(C_HEADERS)
	@mkdir -p $(@D)
	@nice clang-tidy --quiet --warnings-as-errors='*' --checks='$(TIDY_CHECKS)' --extra-arg-before=-std=c99 \
	    --extra-arg=-D_XOPEN_SOURCE=700 $(FUZZ_INCLUDE:%=--extra-arg=%) $< 2>$@.told || { cat $@.told >&2; exit 1; }
	@mv $@.told $@

$(BUILD)/.tidy:
	@mkdir -p $(@D)
	$(call need,clang-tidy --version,clang-tidy)
	@touch $@

check-analysis-tidy: $(BUILD)/.tidy $(C_SOURCES:%.c=$(BUILD)/analysis/tidy/%.passed)
	@echo "clang-tidy: nothing in $(words $(C_SOURCES)) files"

# ---- valgrind: the unit tests, without the sanitizers.
check-valgrind: $(BUILD)/.cmocka
	$(call need,valgrind --version,valgrind)
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/valgrind OPENCV=0 NEED= SANITIZE="-O1 -g" \
	    UNDER="valgrind --quiet --error-exitcode=9 --leak-check=full" $(UNIT_NAMES:%=$(BUILD)/valgrind/passed/%.log) >/dev/null
	@echo "valgrind: nothing in $$(cat $(UNIT_NAMES:%=$(BUILD)/valgrind/passed/%.log) | grep -c '^\[       OK') unit tests"

# ---- The threads of match: nothing is read by one while another writes it.
check-threads: $(ENV) ## the tests of --threads under gcc's thread sanitizer
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/threads OPENCV=0 NEED= CFLAGS="-O1 -g -fsanitize=thread" $(BUILD)/threads/opencv0/qstereo >/dev/null
	@QSTEREO=$(abspath $(BUILD))/threads/opencv0/qstereo QSTEREO_PNM=$(abspath $(BUILD))/threads/opencv0/qstereo TSAN_OPTIONS="halt_on_error=1 exitcode=66" \
	    $(BIN)/python -m pytest -q tests/cli/test_cli_threads.py

# ---- How much of the library the unit tests and the corpora reach.
coverage: $(BUILD)/.cmocka ## print how much of the library the unit tests run, file by file; the goal is 95 % of the lines
	$(call need,gcovr --version,gcovr)
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/coverage OPENCV=0 NEED= SANITIZE="-O0 -g --coverage" $(UNIT_NAMES:%=$(BUILD)/coverage/unit/%) >/dev/null
	@find $(BUILD)/coverage -name '*.gcda' -delete
	@for test in $(UNIT_NAMES); do nice $(BUILD)/coverage/unit/$$test >/dev/null 2>&1 || exit 1; done
	@gcovr --root . --object-directory $(BUILD)/coverage --filter libqstereo/src --exclude-unreachable-branches --fail-under-line 95 $(BUILD)/coverage
