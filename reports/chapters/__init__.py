"""Chapters of the report: from a study's tables to a view, charts and a page. No chapter imports another."""
