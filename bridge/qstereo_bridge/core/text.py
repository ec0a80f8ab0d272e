"""Strings from outside: what a service, a file or a file's name says, read, or made safe to print.

`line` is for what is quoted in a message, `shown` and `lines` for what is printed. All leave out
the tokens that `hide` was told of and what looks like one, and write what does not print (control
characters, marks that turn the direction of writing) as Python would: \\x1b, \\u202e.
"""

import json
import os
import re
import sys

# A shorter "token" is a slip in a configuration; to take it out would take letters out of words.
SHORTEST = 8
# What D-Wave's tokens look like.
LIKE_A_TOKEN = re.compile(r"\b[A-Za-z]{2,8}-[0-9a-fA-F]{32,}\b")
_hidden = set()


def parse(text, **hooks):
    """json.loads, of which what is nested too deeply is a ValueError like all that is no JSON."""
    try:
        return json.loads(text, **hooks)
    except RecursionError as error:
        raise ValueError(str(error)) from None


def hide(tokens):
    """Tokens (str, or None for none) that nothing that is printed may hold from now on."""
    _hidden.update(token for token in map(_stripped, tokens) if len(token) >= SHORTEST)


def _stripped(token):
    return (token or "").strip()


def _without_tokens(text):
    for token in sorted(_hidden | {_stripped(os.environ.get("DWAVE_API_TOKEN"))}, key=len)[::-1]:
        if len(token) >= SHORTEST:
            text = text.replace(token, "(token)")
    return LIKE_A_TOKEN.sub("(token)", text)


def shown(text):
    """`text` (str) without tokens, each character that does not print as a backslash sequence;
    a line end is such a character."""
    return "".join(letter if letter.isprintable() else
                   letter.encode("unicode_escape").decode() for letter in _without_tokens(text))


def lines(text):
    """shown() of each line of a text whose line ends are this program's own."""
    return "\n".join(map(shown, text.split("\n")))


def line(text):
    """shown() of a text in one line: line ends, tabs and rows of blanks become one blank."""
    # First the tokens: one may hold two blanks in a row.
    return shown(" ".join(_without_tokens(text).split()))


def say(options, text):
    """A message of the command."""
    print(lines(f"qstereo-bridge {options.command}: {text}"), file=sys.stderr, flush=True)
