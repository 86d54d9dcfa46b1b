"""Peers: other programs and methods that compute the same release, on the same axes as beadband's own."""

from beadband.studies.pareto.peers.comparison import Comparison, compare
from beadband.studies.pareto.peers.protocol import Peer, Trace, answer_of, end_s
from beadband.studies.pareto.peers.registry import PEERS, add_peer

__all__ = ["PEERS", "Comparison", "Peer", "Trace", "add_peer", "answer_of", "compare", "end_s"]
