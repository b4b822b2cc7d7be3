"""Sweeps as a stream: rows are made, solved and handed on in pieces, in order, in bounded memory."""
