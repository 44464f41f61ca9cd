"""Stored results, their form, reading and writing (`results`), and their pages, charts and animations.

Nothing here knows engines.

:mod:`reports.render` makes the pages. It is not imported here: plots take a second to import, and every worker process
imports this package for the outcomes.
"""

from reports.results.outcome import Outcome as Outcome
