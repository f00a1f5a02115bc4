"""Tables of a recording: `t_s, x_mm, force_n, taxel_0_n, …`. One reader for the driver that replays them and the fit that explains them.

Both accept and refuse the same cells, rows, columns and times, in the same words. What a table must hold beyond that is for each to say.
"""
