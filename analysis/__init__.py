"""Measuring what LAMMPS wrote: arrays in, values with errors out; numpy and nothing of the rest of beadband.

=============  ====================================================================================
``readers``    the files of a run as arrays: dumps, the path of a leg's rear, energies, the finger
``fits``       a value with its error, slopes and windowed means
``rear``       path and speed of the rear tip
``ring``       the whole ring over time, read when asked for
``curvature``  curvature of a chain of beads, and how that of the tip decays
``energy``     where the stored energy goes
``contact``    a launch: load of the finger, arrival of the rear, impulse, crossings
=============  ====================================================================================

Lengths are in m, times in s, energies in J and forces in N throughout.
"""
