"""Effects beyond the paper's model, one module each; imported only for a model with that effect."""
