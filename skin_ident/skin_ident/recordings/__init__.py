"""Recordings: from bags, tables and scans to evenly sampled arrays in SI units, with every repair counted."""
