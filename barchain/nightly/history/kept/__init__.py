"""What is kept beside the figures of nights: their runs, what they told, and attributions."""
