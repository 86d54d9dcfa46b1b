"""Colours of lines and points that any colour vision tells apart (Okabe and Ito, Color Universal Design, 2008)."""

from __future__ import annotations

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
