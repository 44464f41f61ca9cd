"""Renders stored result tables into HTML and Markdown; knows tables, not engines or scenes."""

from reports.outcome import Outcome as Outcome
from reports.render import render as render
from reports.tables import Results as Results
from reports.tables import read_results as read_results
