"""Fresh environments: other versions of engines and libraries, other sources of barchain, beside the installation."""
