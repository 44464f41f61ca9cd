"""Command line of this process."""

import shlex
import sys


def typed() -> str:
    """Command line of this process, for records."""
    return shlex.join(["barchain", *sys.argv[1:]])
