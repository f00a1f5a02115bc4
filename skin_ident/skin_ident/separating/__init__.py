"""The separating experiment: which motion would tell rival causes apart, computed before anything is recorded.

Each rival is a fitted model. `candidates` proposes motions. `contest` simulates every rival on them, and computes how much of one rival's
signals another one could not imitate. `choose` takes the motion that decides in the least time and writes it as a battery.

Source: A. C. Atkinson and V. V. Fedorov, The design of experiments for discriminating between two rival models,
Biometrika 62 (1975) 57-70 (T-optimality).
"""
