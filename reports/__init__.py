"""Renders stored result tables into HTML and Markdown; knows tables, not engines or scenes.

Pages are made by :mod:`reports.render`, which is not imported here: plots take a second to import, and every worker
process imports this package for the words of an outcome.
"""

from reports.tables.outcome import Outcome as Outcome
