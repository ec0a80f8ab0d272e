# Packages and pages: what a release consists of. Included by the Makefile.

.PHONY: deb wheel docs check-packages

RELEASE := .venv/.release

$(RELEASE): requirements-release.txt $(ENV)
	$(Q)$(PIP) -r $<
	@touch $@

# Debian's tools write into the tree that they build, so they get a copy.
DEB := $(BUILD)/deb

$(BUILD)/.debian:
	@mkdir -p $(@D)
	$(call need,dh --version && lintian --version,debhelper lintian libopencv-imgcodecs-dev \
	    g++ pkg-config)
	@touch $@

deb: | $(BUILD)/.debian ## Debian's packages, in build/deb, looked over by lintian
	$(Q)rm -rf $(DEB) && mkdir -p $(DEB)/qstereo-$(VERSION)
	$(Q)tar -cf - --exclude=./.git --exclude=./.venv --exclude=./$(BUILD) --exclude=__pycache__ \
	    --exclude='*.egg-info' . | tar -xf - -C $(DEB)/qstereo-$(VERSION)
	$(Q)cd $(DEB)/qstereo-$(VERSION) && env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS \
	    dpkg-buildpackage -us -uc -b -j2 >../build.log 2>&1 || { tail -30 ../build.log; exit 1; }
	$(Q)rm -rf $(DEB)/qstereo-$(VERSION)
	$(Q)lintian --allow-root --fail-on error,warning --tag-display-limit 0 $(DEB)/*.changes
	@ls -l $(DEB)/*.deb

wheel: $(RELEASE) ## the bridge's wheel, in build/wheel, looked over by twine
	$(Q)rm -rf $(BUILD)/wheel
	$(Q)$(BIN)/python -m pip wheel -q --disable-pip-version-check --no-deps --no-build-isolation \
	    -w $(BUILD)/wheel ./bridge
	$(Q)rm -rf bridge/build
	$(Q)$(BIN)/python -m twine check --strict $(BUILD)/wheel/*.whl

$(BUILD)/.doxygen:
	@mkdir -p $(@D)
	$(call need,doxygen --version,doxygen)
	@touch $@

docs: $(RELEASE) | $(BUILD)/.doxygen ## pages of headers, documents and Python, in build/docs/html
	$(Q)rm -rf $(BUILD)/docs && mkdir -p $(BUILD)/docs
	$(Q)VERSION=$(VERSION) OUT=$(BUILD)/docs doxygen docs/Doxyfile
	$(Q)$(BIN)/python scripts/python-pages $(BUILD)/docs/html/python
	@echo "$(BUILD)/docs/html/index.html"

$(BUILD)/.mmdebstrap:
	@mkdir -p $(@D)
	$(call need,mmdebstrap --version,mmdebstrap)
	@touch $@

# Needs root, as the tools that make a clean system do.
check-packages: deb wheel | $(BUILD)/.mmdebstrap ## install the packages in clean systems and use them
	@scripts/check-packages $(DEB) $(BUILD)/wheel $(BUILD)/packages
