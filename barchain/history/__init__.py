"""History of nights: figures of earlier runs in one store, and what changed between them."""
