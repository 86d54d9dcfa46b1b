"""The peers that are compared; a plug-in adds its own."""

from __future__ import annotations

from beadband.errors import UsageError, explain
from beadband.studies.pareto.peers.finite_elements import FiniteElements
from beadband.studies.pareto.peers.protocol import Peer
from beadband.studies.pareto.peers.stock_lammps import StockLammps
from beadband.studies.pareto.peers.with_exudyn import Exudyn
from beadband.studies.pareto.peers.with_openmm import OpenMM

INSTALL = "pip install 'beadband[peers]'"
"""What installs the packages of the peers that come with beadband."""

PEERS: dict[str, Peer] = {}
"""Peers by their names, in the order of the charts."""


def add_peer(peer: Peer) -> None:
    """Compare one more; UsageError for what is no adapter, or a name that is taken."""
    missing = [
        name for name in ("name", "package", "laws", "ladder", "quick", "note", "run") if not hasattr(peer, name)
    ]
    if missing:
        raise UsageError(
            explain("this is no adapter of a peer", f"no {', '.join(missing)}", "all of docs/peers.md", "add them")
        )
    if peer.name in PEERS:
        raise UsageError(explain("two peers of one name", repr(peer.name), "a name of its own", "rename it"))
    PEERS[peer.name] = peer


for _peer in (FiniteElements(), StockLammps(), OpenMM(), Exudyn()):
    add_peer(_peer)
