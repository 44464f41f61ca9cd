"""One module for each effect beyond the paper's: imported only where a model calls for it."""
