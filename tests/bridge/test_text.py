"""Strings from outside: no token, nothing that steers a terminal."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st
from service import TOKEN
from qstereo_bridge.core import text


@pytest.fixture(autouse=True)
def nothing_hidden(monkeypatch):
    monkeypatch.setattr(text, "_hidden", set())


@given(st.text())
def test_all_that_is_shown_prints_and_stays_as_it_is(said):
    for made in (text.shown, text.line):
        found = made(said)
        assert found.isprintable() and made(found) == found
        assert not any(unicodedata.category(letter) in ("Cc", "Cf", "Cs") for letter in found)


def test_what_steers_a_terminal_is_written_out():
    assert text.shown("a\x1b[2Jb\x9bc\u202ed\u2066e\ud800") == r"a\x1b[2Jb\x9bc\u202ed\u2066e\ud800"
    assert text.shown("two  blanks\n\u00e4 \u03bb") == "two  blanks\\n\u00e4 \u03bb"
    assert text.line(" two \t\r\n lines\x07 ") == r"two lines\x07"
    assert text.lines("one\ntwo\r\u2028") == "one\n" + r"two\r\u2028"


def test_tokens_are_left_out(monkeypatch):
    text.hide([None, "secret-of-one", " secret-of-one-more\n", "two  blanks"])
    monkeypatch.setenv("DWAVE_API_TOKEN", "of-the-environment\n")
    said = f"secret-of-one-more, secret-of-one, {TOKEN}, of-the-environment and two  blanks"
    assert text.line(said) == "(token), (token), (token), (token) and (token)"


def test_what_is_too_short_for_a_token_is_none(monkeypatch):
    """A slip in a configuration does not shred the messages."""
    monkeypatch.setenv("DWAVE_API_TOKEN", " ")
    text.hide(["a", "", " ", "\n", "seven77"])
    assert text.line("a plain seven77 text") == "a plain seven77 text"
