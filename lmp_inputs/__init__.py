"""The LAMMPS input scripts, as package data."""
