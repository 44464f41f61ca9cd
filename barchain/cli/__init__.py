"""Command line: one module for each study, and the other commands in ``run`` and ``maintain``.

Modules import only click and constants at their head, so that help is quick; a command imports its code when it runs.
"""
