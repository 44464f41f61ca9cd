"""Chapters of the report: views and charts of each study's tables. No chapter imports another."""
