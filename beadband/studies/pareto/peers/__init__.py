"""Peers: other programs and methods that compute the same release, on the same axes as beadband's own."""
