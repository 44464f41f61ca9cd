"""Rules of change: one module for each kind of figure. Functions of the data model, without input and output."""
