"""Options, exit codes, result folders and output that all commands share."""
