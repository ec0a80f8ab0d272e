# The fuzz targets. Included by the Makefile.
#
# check: each target runs over its corpus, under gcc's sanitizers. fuzz: clang's libFuzzer looks for
# more, SECONDS a target, from the corpus on; what it finds is left in build/fuzz.

.PHONY: fuzz

FUZZ := $(BUILD)/fuzz
FUZZ_TARGETS := qcf qsf qpf pictures text frames
FUZZ_REPLAY := $(FUZZ_TARGETS:%=$(FUZZ)/replay-%)
# Files of the container, whose checksums the mutator mends.
FUZZ_CONTAINERS := qcf qsf qpf
SECONDS ?= 60

FUZZ_CLI := $(filter-out %main.c,$(wildcard cli/*.c cli/*/*.c))
FUZZ_INCLUDE := $(INCLUDE) -Icli
FUZZ_FLAGS := -std=c99 -D_XOPEN_SOURCE=700 -g -O1 -Wall -Wextra -MMD -MP
FUZZER := -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined

$(FUZZ)/gcc/%.o: %.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) $(FUZZ_FLAGS) $(SANITIZE) $(FUZZ_INCLUDE) -c $< -o $@

$(FUZZ)/gcc/cli.a: $(FUZZ_CLI:%.c=$(FUZZ)/gcc/%.o)
	$(Q)rm -f $@
	$(Q)$(AR) rcs $@ $^

$(FUZZ)/replay-%: $(FUZZ)/gcc/tests/fuzz/fuzz_%.o $(FUZZ)/gcc/tests/fuzz/replay.o $(FUZZ)/gcc/cli.a $(UNIT_LIB)
	$(call say,LINK,$@)
	$(Q)$(CC) $(SANITIZE) $^ -lm -o $@

$(FUZZ)/.clang:
	@mkdir -p $(@D)
	$(call need,false,clang libclang-rt-14-dev)
	@touch $@

$(FUZZ)/clang/%.o: %.c | $(FUZZ)/.clang
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)clang $(FUZZ_FLAGS) $(FUZZER) $(FUZZ_INCLUDE) -c $< -o $@

$(FUZZ)/clang/mutate.o: tests/fuzz/mend.c | $(FUZZ)/.clang
	@mkdir -p $(@D)
	$(Q)clang $(FUZZ_FLAGS) -DFUZZ_CONTAINER $(FUZZER) $(FUZZ_INCLUDE) -c $< -o $@

FUZZ_OBJECTS := $(LIB_SRC:%.c=$(FUZZ)/clang/%.o) $(FUZZ_CLI:%.c=$(FUZZ)/clang/%.o)

$(FUZZ)/fuzz-%: $(FUZZ)/clang/tests/fuzz/fuzz_%.o $(FUZZ)/clang/mutate.o $(FUZZ_OBJECTS)
	$(Q)clang $(FUZZER) -fsanitize=fuzzer $(filter-out $(if $(filter $*,$(FUZZ_CONTAINERS)),,%/mutate.o),$^) -lm -o $@

fuzz: $(FUZZ_TARGETS:%=$(FUZZ)/fuzz-%) $(ENV) ## look for inputs that break the readers, SECONDS=60 for each of seven targets
	@set -e; for target in $(FUZZ_TARGETS); do \
	    mkdir -p $(FUZZ)/corpus-$$target $(FUZZ)/found-$$target; \
	    tar -xJf tests/fuzz/corpus/$$target.tar.xz -C $(FUZZ)/corpus-$$target; \
	    echo "$$target"; \
	    nice $(FUZZ)/fuzz-$$target -max_total_time=$(SECONDS) -max_len=1500 -timeout=5 -rss_limit_mb=3000 -print_final_stats=1 \
	        -artifact_prefix=$(FUZZ)/bad-$$target- $(FUZZ)/found-$$target $(FUZZ)/corpus-$$target >$(FUZZ)/$$target.log 2>&1 || \
	        { grep -aE "ERROR|promise|runtime error|Test unit|^ +#[0-9]+ " $(FUZZ)/$$target.log; exit 1; }; \
	    grep -a number_of_executed $(FUZZ)/$$target.log; \
	done
	@$(BIN)/python tests/fuzz/readers.py --seconds $(SECONDS) --keep $(FUZZ)
