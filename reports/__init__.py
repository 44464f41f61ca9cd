"""Rendering of stored result tables as HTML, independent of engines and scenes.

:mod:`reports.render` makes the pages. It is not imported here: plots take a second to import, and every worker process
imports this package for the outcomes.
"""

from reports.results.outcome import Outcome as Outcome
