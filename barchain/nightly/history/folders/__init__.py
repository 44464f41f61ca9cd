"""Result folders as nights: one module for each kind of results, through their validated readers."""
