"""Documents of nights: the facts of a night, its trends, a gate, the results page."""

PAGE, STATE = "nightly.html", "night.json"
"""Files of a night's folder: its page, and its state while it runs"""
