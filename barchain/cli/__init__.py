"""Command line: one module for each group of commands; ``studies`` has six studies, ``nightly`` those of nights.

Modules import only click and constants at their head, so that help is quick; a command imports its code when it runs.
"""
