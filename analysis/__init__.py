"""Reading trajectories and measuring them; the measuring functions take arrays and return values with errors."""
