"""Launches: the whole ring on its finger, from the release until the rear arrives, and the flight after it.

string (closed forms) -> plan (what the finger adds to a release's) -> contact (the ring held on a finger that gives
way) -> launch (run and measured) -> results; map and ladder put many of them together.
"""
