"""Random scenes far beyond what anybody would fly, and checks of the reference on them."""
