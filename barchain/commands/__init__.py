"""The command line's studies, a module each; what they run is imported when they run."""

import shlex
import sys


def typed() -> str:
    """The command as it was typed, for records."""
    return shlex.join(["barchain", *sys.argv[1:]])
