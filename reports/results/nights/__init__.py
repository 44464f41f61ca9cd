"""Tables and documents of nights: the facts of a night, its trends, releases of an engine."""
