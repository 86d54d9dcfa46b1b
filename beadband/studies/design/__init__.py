"""Studies for a designer: which input decides, and which band is best for a goal."""
