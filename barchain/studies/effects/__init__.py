"""Effect budget: what each effect, on or off in a scene, is worth there and what it costs."""
