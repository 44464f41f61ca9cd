"""Charts: panels, curves, colours, SVG that works in both themes."""
