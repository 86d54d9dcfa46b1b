"""Equilibria: the stretched ring and the leg while they are held, and the ring on its finger."""
