"""Documents of a judged night."""
