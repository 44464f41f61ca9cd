"""Text of pages: numbers, units, formulas, the glossary, and what a record tells."""
