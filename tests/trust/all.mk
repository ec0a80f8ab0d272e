# Everything that takes longer than a check before each commit should. Included by the Makefile.

.PHONY: check-all check-browser check-kills check-units check-warnings check-analysis check-valgrind check-threads coverage

check-all: check check-units check-warnings check-analysis check-valgrind check-threads coverage check-packages docs check-browser check-kills ## check, and every unit test on every target, all compilers and analysers, valgrind, coverage

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
	    $(UNIT_NAMES:%=$(UNIT_DIR)/$*/unit/%) >/dev/null
	@for test in $(UNIT_NAMES); do \
	    nice $(UNIT_RUN_$*) -L /usr/$(UNIT_CC_$*) -E LD_LIBRARY_PATH=$$(dirname $(abspath $(UNIT_DIR))/$*/cmocka/usr/lib/*/libcmocka.so) \
	        $(UNIT_DIR)/$*/unit/$$test >$(UNIT_DIR)/$*/$$(basename $$test).log 2>&1 || { tail -20 $(UNIT_DIR)/$*/$$(basename $$test).log; exit 1; }; \
	done; echo "$*: $$(cat $(UNIT_DIR)/$*/*.log | grep -c '^\[       OK') unit tests pass"

# ---- No warning of gcc and clang, at any level of optimisation, on 64 and 32 bits. A row of options
# names what it sets, and the rest is 0: clang warns of that, gcc does not.
C_SOURCES := $(LIB_SRC) $(wildcard cli/*.c cli/*/*.c)
WARN_ALL := -std=c99 -D_XOPEN_SOURCE=700 $(WARN) -Wsign-conversion -Wstrict-prototypes -Wmissing-prototypes -Wvla -Wundef -Wcast-align \
    -Wwrite-strings -Wformat=2 -Wno-missing-field-initializers -Werror

# $(call each,COMMAND): the command with each source in turn as its last word, JOBS at a time.
JOBS ?= 2
each = printf '%s\n' $(C_SOURCES) | xargs -P $(JOBS) -n 1 nice $(1)

check-warnings: | $(UNIT_DIR)/.packages $(FUZZ)/.clang
	@set -e; count=0; for compiler in gcc i686-linux-gnu-gcc clang "clang --target=i686-linux-gnu -I/usr/i686-linux-gnu/include"; do \
	    for level in 0 1 2 3; do \
	        $(call each,$$compiler $(WARN_ALL) -O$$level $(FUZZ_INCLUDE) -S -o /dev/null); \
	        count=$$((count + $(words $(C_SOURCES)))); \
	    done; \
	done; echo "no warning in $$count compilations"

# ---- Analysers. Each report has been judged; those that are wrong are switched off here, with the reason.
# gcc: a struct that a function returns through a pointer counts as not set (qs_draft's shape); the
#   lanes of a vector count as narrower than they are (bp_avx2.c); an arena has no memory while it
#   counts (arena.h), so gcc takes the memory of every caller for a null pointer. What malloc returns
#   must still be tested: those are warnings of their own, of pointers that are possibly null.
ANALYZER_JUDGED := -Wno-analyzer-use-of-uninitialized-value -Wno-analyzer-shift-count-overflow \
    -Wno-analyzer-null-dereference -Wno-analyzer-null-argument
# cppcheck: a scale is never 0 (decimal.c); vectors of gcc are shifted arithmetically, as gcc documents
#   (bp_avx2.c); an array is read as far as a loop has filled it (mover.c,
#   expansion.c); options_read fills its argument.
CPPCHECK_JUDGED := --suppress=zerodivcond:*numbers.c --suppress=shiftTooManyBitsSigned:*bp_avx2.c --suppress=uninitvar:*mover.c \
    --suppress=uninitvar:*expansion.c --suppress=ctuuninitvar:*options.c
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

check-analysis: | $(FUZZ)/.clang
	$(call need,cppcheck --version && clang-tidy --version,cppcheck clang-tidy)
	@$(call each,$(CC) -std=c99 -D_XOPEN_SOURCE=700 -O2 -fanalyzer $(ANALYZER_JUDGED) -Werror $(FUZZ_INCLUDE) -S -o /dev/null)
	@echo "gcc -fanalyzer: nothing in $(words $(C_SOURCES)) files"
	@nice cppcheck -j $(JOBS) --quiet --std=c99 --enable=warning,performance,portability --error-exitcode=1 $(CPPCHECK_JUDGED) $(FUZZ_INCLUDE) $(C_SOURCES)
	@echo "cppcheck: nothing in $(words $(C_SOURCES)) files"
	@$(call each,clang-tidy --quiet --warnings-as-errors='*' --checks='$(TIDY_CHECKS)' --extra-arg-before=-std=c99 \
	    --extra-arg=-D_XOPEN_SOURCE=700 $(FUZZ_INCLUDE:%=--extra-arg=%)) 2>/dev/null
	@echo "clang-tidy: nothing in $(words $(C_SOURCES)) files"

# ---- valgrind: the unit tests, without the sanitizers.
check-valgrind: $(BUILD)/.cmocka
	$(call need,valgrind --version,valgrind)
	@$(MAKE) --no-print-directory -s BUILD=$(BUILD)/valgrind OPENCV=0 NEED= SANITIZE="-O1 -g" $(UNIT_NAMES:%=$(BUILD)/valgrind/unit/%) >/dev/null
	@for test in $(UNIT_NAMES); do \
	    nice valgrind --quiet --error-exitcode=9 --leak-check=full $(BUILD)/valgrind/unit/$$test >$(BUILD)/valgrind/$$(basename $$test).log 2>&1 || \
	        { tail -30 $(BUILD)/valgrind/$$(basename $$test).log; exit 1; }; \
	done; echo "valgrind: nothing in $$(cat $(BUILD)/valgrind/*.log | grep -c '^\[       OK') unit tests"

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
