# What proves the promises of docs/TRUST.md beside the unit tests. Included by the Makefile.

.PHONY: check-trust check-cortex-m

# Other machines: NAME, compiler, what runs it, Debian's packages. i686 is the small build too.
TARGET_DIR := $(BUILD)/targets
TARGETS := i686 s390x
TARGET_RUN_i686 :=
TARGET_RUN_s390x := qemu-s390x
# The old floating-point unit of i686 rounds twice, which changes the last digit of a camera's figures.
TARGET_CPPFLAGS_i686 := -DQS_SMALL -msse2 -mfpmath=sse
TARGET_PACKAGES := gcc-i686-linux-gnu libc6-dev-i386-cross gcc-s390x-linux-gnu libc6-dev-s390x-cross qemu-user
TARGET_FLAGS = OPENCV=0 NEED= LDFLAGS=-static CFLAGS="-O1 -g0"

$(TARGET_DIR)/.packages:
	@mkdir -p $(@D)
	$(call need,s390x-linux-gnu-gcc --version && i686-linux-gnu-gcc --version && qemu-s390x --version,$(TARGET_PACKAGES))
	@touch $@

$(TARGET_DIR)/%/qstereo: FORCE | $(TARGET_DIR)/.packages
	@$(MAKE) --no-print-directory $(TARGET_FLAGS) BUILD=$(TARGET_DIR)/$* CC=$*-linux-gnu-gcc CPPFLAGS="$(TARGET_CPPFLAGS_$*)" $@

# The example for small machines.
CORTEX_M := $(BUILD)/cortex-m/encode.elf

$(BUILD)/.cortex-m:
	@mkdir -p $(@D)
	$(call need,arm-none-eabi-gcc --version && qemu-system-arm --version,gcc-arm-none-eabi qemu-system-arm)
	@touch $@

$(CORTEX_M): FORCE | $(BUILD)/.cortex-m
	@$(MAKE) --no-print-directory -s -C examples/cortex-m BUILD=$(abspath $(BUILD))/cortex-m

# What lets calls fail, and what lets time stand still.
FAULTS := $(BUILD)/trust/faults.so
CLOCK := $(BUILD)/trust/clock.so

$(FAULTS) $(CLOCK): $(BUILD)/trust/%.so: tests/trust/%.c
	@mkdir -p $(@D)
	$(call say,CC,$@)
	$(Q)$(CC) -O1 -Wall -Wextra -fPIC -shared $< -o $@

TRUST_ENV = QSTEREO_FUZZ=$(abspath $(FUZZ)) QSTEREO_FAULTS=$(abspath $(FAULTS)) QSTEREO_CLOCK=$(abspath $(CLOCK)) QSTEREO=$(abspath $(BUILD))/opencv1/qstereo QSTEREO_PNM=$(abspath $(BUILD))/opencv0/qstereo \
    QSTEREO_BRIDGE=$(abspath $(BIN))/qstereo-bridge QSTEREO_CORTEX_M=$(abspath $(CORTEX_M)) \
    QSTEREO_TARGETS="$(foreach target,$(TARGETS),$(target)=$(TARGET_RUN_$(target)) $(abspath $(TARGET_DIR)/$(target)/qstereo):)"

check-trust: all $(ENV) $(BUILD)/opencv1/qstereo $(BUILD)/opencv0/qstereo $(TARGETS:%=$(TARGET_DIR)/%/qstereo) $(CORTEX_M) $(FAULTS) $(CLOCK) $(FUZZ_REPLAY)
	$(TRUST_ENV) $(BIN)/python -m pytest -q -n 2 tests/trust

check-cortex-m: all $(ENV) $(BUILD)/opencv1/qstereo $(CORTEX_M) ## encode on an emulated Cortex-M4: same bytes, at most 12 KiB of code and 2 KiB of RAM
	$(TRUST_ENV) $(BIN)/python -m pytest -q -s tests/trust/test_cortex_m.py
