"""Commands on the history of nights."""
