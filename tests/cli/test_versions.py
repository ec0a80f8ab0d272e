"""One version everywhere: library, bridge, citation, manual, news and packages."""

import re
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]
VERSION = re.search(
    r'QS_VERSION +"(.*)"', (TOP / "libqstereo/include/qstereo/version.h").read_text()
)[1]
PLACES = {
    "bridge/qstereo_bridge/__init__.py": r'^__version__ = "(.*)"$',
    "CITATION.cff": r"^version: (.*)$",
    "docs/qstereo.1": r'^\.TH QSTEREO 1 "" "qstereo (.*?)"',
    "NEWS": r"\Aqstereo (.*)$",
    "debian/changelog": r"\Aqstereo \((.*?)\)",
}


@pytest.mark.parametrize("place", PLACES)
def test_version(place):
    found = re.search(PLACES[place], (TOP / place).read_text(), flags=re.M)
    assert found and found[1] == VERSION, place
