"""Conformance of one engine: its declarations, conventions, physics, accuracy and behaviour, cheap checks first.

``assert_conforms("mine")`` is a test of an engine in the continuous integration of its own package.
"""

from barchain.conform.run import assert_conforms, conform
from barchain.conform.target import Extent

__all__ = ["Extent", "assert_conforms", "conform"]
