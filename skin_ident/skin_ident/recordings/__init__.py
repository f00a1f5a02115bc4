"""Recordings: from bags, tables and scans to evenly sampled arrays in SI units, with every repair counted and reported.

Readings are the samples of a topic at its own instants, before they are interpolated to those of the recording. A taker collects the
messages of one topic as arrays.
"""
