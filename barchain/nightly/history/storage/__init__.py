"""Tables of the history, their migrations, connections, and rows."""
