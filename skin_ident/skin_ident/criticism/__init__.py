"""Criticism: what a simulation gets wrong on measured data, by which cause, and what naming it is worth.

The method, in the order in which `diagnose` runs it:

1.  `telemetry` looks at each recording before any model: quantization, saturation, spikes, frozen samples, dead taxels, copied data.
2.  `session` and `band` put measured and simulated channels through one and the same low-pass, at full rate, then thin them out.
3.  `fitting` fits the dispersion model (or takes the given one) to all training sessions jointly, by output error.
4.  `proposals` simulates every effect of the catalogue, at every shape of its grid, on top of the model: the change it makes to every
    channel is the direction in which that cause would bend the residual.
5.  `whitening` fits the noise (autoregressive per channel, correlated between channels) to what the richest set of directions leaves.
6.  `ranking` projects the model's own parameters out and asks how much of the whitened residual each cause explains, within the signs
    that physics allows.
7.  The best few are refitted jointly, nonlinearly; `gate` demands that held-out sessions are predicted better (block bootstrap).
8.  Repeat; then eliminate backwards; then ask whether a general model still predicts something of the residual on held-out data.
"""
