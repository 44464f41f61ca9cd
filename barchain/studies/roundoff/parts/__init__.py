"""Parts of the study: each measures the rows of one table."""
