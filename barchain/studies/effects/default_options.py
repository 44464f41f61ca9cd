"""Defaults of an effect budget; a module of its own, as the command line's help must be quick."""

from __future__ import annotations

RTOL = 1e-12  # of the tighter run: what effects change is then told from the numerics as far as doubles go
RTOLS = (1e-14, 1e-3)  # ten times looser is still an accuracy
MATTERS = 1e-3
WIDTHS_M = (1e-6, 1e6)  # of a bar: from a hair's hundredth to the widest sail that anybody drew
REPEATS = 7  # rounds: the median's interval is drawn from six on
SECONDS = 20.0  # after which no further round is begun
TIME_LIMIT_S = 300.0  # of one run; compiling has its own besides
FAST, SLOW = "reference-fast", "reference"
