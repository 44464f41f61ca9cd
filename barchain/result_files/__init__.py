"""Results that another program left in a file: tables with names, units and digits of their own, and their verdict.

`case` writes the problem of a scene for such a program.
"""
