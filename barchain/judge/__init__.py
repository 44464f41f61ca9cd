"""The verdict on one engine in one scene: differences, their bounds, and what explains them."""
