"""Everything that touches LAMMPS: what it reads, how it runs, and what it looks like when a run diverges."""
