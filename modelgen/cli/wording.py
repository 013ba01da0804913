"""Refusals in the words of the command line, where the library says what to write in Python.

Part of ``cli``, below ``commands``. Where the library's sentence names a call or a keyword, the command names the option, or the
key of the model file, that does the same.
"""

from __future__ import annotations

import re

LACKS = r"rule '(?P<rule>\w+)'(?P<what>.*); write rule\.given\((?P<key>\w+)=\.\.\.\) with"
GIVE = r"""rule '\g<rule>'\g<what>; write --rule "\g<rule> \g<key>=%s", or in the model's [[limits]] inputs = { \g<key> = %s }"""

WORDS: tuple[tuple[str, str], ...] = (
    (LACKS + r" a number in (?P<unit>[^ ]+)", GIVE % (r"'... \g<unit>'", r'"... \g<unit>"')),
    (LACKS, GIVE % ("...", "...") + ", with"),
    (
        r"set start \(time of the solution at the measured zero\), or align=True",
        "give --start TIME (time of the run at the measured zero), --align, or --window around the recording",
    ),
    (r"record longer, or give a shorter longest_lag", "record longer, or give --start TIME instead of --align"),
    (r"give longest_lag in seconds, or base in Hz", "give --start TIME instead of --align"),
    (r"use balance\(load\), (.*) declare that it drifts", r'write balance = ["load"] into the model file, \1 drifts = true'),
    (r"use balance\(load, \.\.\.\), one", 'write balance = ["load", ...] into the model file, one'),
    (r"balance\(\.\.\., may_drive=True\), in a model file (balance_may_drive = true)", r"\1 in the model file"),
)
"""What the library says (a pattern), and what the command says in its place."""


def in_words_of_the_command_line(message: str) -> str:
    """A refusal as a command says it.

    >>> in_words_of_the_command_line("comparison: too little in common; set start (time of the solution at the measured zero), "
    ...     "or align=True")
    'comparison: too little in common; give --start TIME (time of the run at the measured zero), --align, or --window around ...'
    """
    for pattern, words in WORDS:
        message = re.sub(pattern, words, message, flags=re.DOTALL)
    return message
