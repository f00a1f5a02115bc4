"""Criticism: what a simulation gets wrong on measured data, by which cause, and what naming it is worth.

The method, in the order in which `diagnose` runs it:

1.  `telemetry` looks at each recording before any model (`record`): quantization, saturation, spikes, frozen samples, dead taxels, copied
    data, and by a first fit at pieces that one channel alone knows of, stretches in which two channels are exchanged, and ceilings that
    quick touches alone reach. Of topics that come at instants of their own, single readings are asked (`telemetry.as_read`).
    `telemetry.odd_session` puts a session right that differs from all others in whole (columns in another order, a unit, a sign).
2.  `sessions` puts measured and simulated channels through one and the same low-pass, at full rate, then thins them out. A depth in coarse
    steps is drawn again first (`recordings.staircase`), and the band ends where its steps and noise would be more of the motion than the
    motion, or a fifth of the slowest topic's rate (`sessions.cutoff`). Moments when the plunger may have left the skin are not compared,
    and do not pass the filter either (`sessions.parting`): a jump's tail is louder than the noise.
3.  `baseline` fits the dispersion model (or takes the given one) to all training sessions jointly, by output error; damping is not below
    nothing. Sessions that press at different places have shares of their own for every taxel, fitted with whatever model stands beside
    them.
4.  `search.proposals` simulates every effect of the catalogue, at every shape of its grid, on top of the model: the change it makes to
    every channel is the direction in which that cause would bend the residual. With declared taxel positions `array` proposes what bends
    the spread over them.
5.  `noise` is fitted (predicted from its last samples and from slower and slower averages, correlated between channels, growing with the
    load) to what the richest set of directions leaves, beginning from white noise and again in the colour that was left; the account that
    describes the record in the fewest words is taken.
6.  `search.ranking` projects the model's own parameters out and asks how much of the whitened residual each cause explains, within the
    signs that physics allows.
7.  The best few are refitted jointly, nonlinearly, with as many instances as have a size of their own, and in the finer form of an effect
    where that explains more (`search.growing`, `search.trial`). What comes within reach of the best, or is the same signal by nature, is
    reported beside it (`search.rivals`); so is, where force drives a test without depth, what its load cell may have in the place of all
    taxels or of the skin (`search.driving`). One that explains most by several instances alone is held against several causes
    (`search.several`). Where the mass of the model explains more than any cause, it is fitted, too (`search.weighing`).
    Where none is believed alone, and no hardware does as much as the best, two that hide each other are asked (`search.together`).
    What only led the fit out of a false minimum is left out again (`search.unstuck`).
8.  `gates` and `search.believing` demand that held-out sessions are predicted better (block bootstrap), beside what training leaves
    uncertain, by more than steps of encoder and converters and noise of the depth leave open (at most, by `gates.resolution`, or of this
    cause, by reading the depth anew with other steps and more noise, `gates.feigned`), and that noise of another colour is no shorter
    account of the record. What is there, and such as good hardware does, is said and not named (`search.hardware`), as is what
    training speaks for while others leave it in doubt (`search.doubt`): neither is called excluded.
9.  `courses` compete with all causes by what belongs to one session alone: a zero, a slope, a delay or a depth that changed before or
    during it. Zeros as tares leave them (`courses.left_by_tare`) belong to the baseline, and those of all channels and sessions together
    go before any cause that explains no more than they do, or where none is believed (`search.tared`). Where such courses explain most by
    far and predict nothing, the noise wanders more than its model knows, and nothing is named. Last, what is wrong in held-out sessions
    alone. A cause that some of three sessions or more have, and others lack, is asked before all that they share (`search.partly`). Skin
    that is another by some percent in every session, as that of specimens, temperatures and places is, belongs to the baseline where that
    explains more than any cause, and than zeros that hardware leaves, or where no cause is believed (`search.own_skin`).
10. `search.criticise` repeats this; each cause is then asked for again beside the others, and where much is left that none is believed for,
    its rivals in its place; of two accounts that explain as much the one with clearly fewer numbers is kept (`search.exchange`). What
    nothing needs is eliminated, and what it had explained is asked of the others once more. `telling` asks whether a general model still
    predicts something of the residual on held-out data, and whether more is left than where every cause may bend every session by itself,
    or many times more than in the air; it measures every gain beside what noise alone leaves, and writes findings.json. `telemetry.pull`
    looks at the moments that were left out.

`many` divides the search where taxels are many; `scan` is the same idea for static spread scans.

References: L. Ljung, System Identification, 1999 (output error, residual tests); Y. C. Pati et al., Orthogonal matching pursuit, 1993;
C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974 (signs); G. Schwarz, Annals of Statistics 6, 1978 (the charge for a
parameter); B. Efron and R. Tibshirani, An Introduction to the Bootstrap, 1993 (blocks, and records drawn anew);
J. R. Cook and L. A. Stefanski, J. Am. Stat. Assoc. 89, 1994 (SIMEX); W. A. Fuller, Measurement Error Models, 1987;
N. M. Laird and J. H. Ware, Biometrics 38, 1982 (numbers of each session's own).
"""
