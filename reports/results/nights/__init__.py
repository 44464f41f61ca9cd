"""Tables and documents of nights: the facts of a night, its trends, releases of an engine."""

PAGE, STATE = "nightly.html", "night.json"
"""Files of a night's folder: its page, and its state while it runs"""
