"""The command as it was typed."""

import shlex
import sys


def typed() -> str:
    """Command line of this process, for records."""
    return shlex.join(["barchain", *sys.argv[1:]])
