"""Sweeps as pictures: wanted variables over one swept input as curves, over two as maps."""
