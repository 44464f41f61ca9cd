"""Effect budget: size, influence and cost of each effect, present or absent in a scene."""
