"""Power laws fitted to the tables of errors."""
