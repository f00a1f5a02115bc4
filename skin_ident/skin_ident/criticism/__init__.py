"""Diagnosis of a robot-skin simulation: what it gets wrong on measured data, which cause explains that, and what adding the cause gains.

The *baseline* is the simulation that is criticised: the thesis's linear dispersion model fitted to the recordings, or a given model. A
*cause* is an effect at a place (skin, rig, load cell, taxel, clock) that can be added to the baseline, such as hysteresis of the skin or a
lag of one taxel. A cause is named if it explains more of the residual than the other causes do and more than good hardware does by itself,
and if sessions that were not used to fit it (*held-out* sessions) are then predicted better.

Words that are used throughout:

- *residual*: measured minus simulated, N, in one common frequency band. The *whitened residual* is the residual after the filter of the
  noise model; where it is nothing but noise its samples are uncorrelated and of unit variance.
- *cost*: sum of squared whitened residuals. *gain*: fall of the cost, which is twice the difference of the log-likelihoods. *score*: gain
  less a charge of log n for each further parameter, with n samples (BIC). The unit of all three is written "squared whitened units" or
  "twice nats". What a named cause *explains* is its score when it was named (`Named.explained`).
- *held-out gain* (`gates.gate.Gain`): something else, namely by how much held-out sessions are predicted better: the RMS error of a
  channel, N, before and after, and the relative fall of the whitened mean square over all channels.
- *direction*: the change of all simulated channels per unit of one effect, added to the model. The *tangents* are the same for the unknowns
  that the model already has (stiffnesses, dampings, shares of taxels).
- *survey*: ranking of all causes by their linearised scores. *trial*: one cause fitted jointly with everything else, nonlinearly. *claim*:
  the statement that a model with a cause gains over one without it.
- *course*: something one session has of its own, as a function of time: a zero, a gain, a delay or a zero of depth that is constant, jumps
  or drifts. *carrier*: the signal that a course multiplies.
- *own skin*: stiffnesses and dampings that differ from session to session.
- *tare*: zeroing of a sensor in the air. It leaves a small zero error, which is no fault.
- *stuck*: of a channel that reads a constant. *twin*: the recorded output of someone else's simulator for the same motion.

The method, in the order in which `diagnose` runs it:

1.  Faults of the record. `record.inspect` runs `telemetry` on each recording, first without any model: quantization, saturation, spikes,
    frozen samples, dead taxels, copied data. After a rough first fit it also looks for pieces in which one channel alone departs from the
    model, for stretches in which two channels are exchanged, and for ceilings that only quick touches reach. Channels whose topic has time
    stamps of its own are checked reading by reading (`telemetry.as_read`). Before all that, `telemetry.odd_session` corrects a session that
    as a whole differs from all others (order of its columns, a unit, a sign).
2.  What is compared. `sessions` passes measured and simulated channels through the same low-pass filter at full rate and then decimates
    them. A depth that was read in coarse steps is first redrawn as a smooth path (`recordings.staircase`). The band ends where steps and
    noise of the encoder would make up too much of the motion (`sessions.cutoff`), and at the latest at 8 Hz or a fifth of the slowest
    topic's rate (`sessions.band`). Moments when the plunger may have left the skin are neither compared nor passed through the filter,
    since the tail of a jump in force is larger than the noise (`sessions.parting`).
3.  `baseline` fits the dispersion model to all training sessions jointly, by output error, or takes the given one. Damping is bounded below
    by zero, but for what a reading late by part of a sample makes of it. Where sessions press at different places, each session has its own
    share for every taxel, refitted under every model that is tried.
4.  `search.proposals` simulates every effect of the catalogue on top of the model, at every shape on its grid. The changes are the
    directions in which the residual may be bent. If the positions of the taxels are declared, `array` adds directions that change the
    spread over the taxels.
5.  `noise` fits an autoregressive model to what is left after the richest set of directions has been taken out. Noise is predicted from its
    last samples and from slower and slower averages; it is correlated between channels and may grow with the load. The fit is done twice,
    starting from white noise and again from the colour found; the result with the shorter description length is kept.
6.  `search.ranking` projects the model's own unknowns out of whitened residual and directions and computes the gain of each cause, with
    amplitudes restricted to the signs that physics allows. It ranks the causes by their scores. This is the survey.
7.  Trials. Each of the best few causes is fitted jointly with the model, nonlinearly: with as many instances of its effect as the data
    determine, and in a finer form where that explains more (`search.growing`, `search.trial`). Special cases:

    - causes that explain about as much, or are the same signal by nature, are reported as alternatives (`search.rivals`);
    - where force drives a test without depth, so is what the load cell may have in place of the taxels or the skin (`search.driving`);
    - a cause that explains most only by several instances is compared with combinations of different causes (`search.several`);
    - the mass of the model is fitted where that explains more than any cause (`search.weighing`);
    - where no cause passes alone and hardware does not explain as much as the best, pairs of causes that hide each other are tried
      (`search.together`);
    - a cause that only led the fit out of a false minimum is dropped again (`search.unstuck`);
    - play of the drive that the encoder is too coarse to read is searched beside, and is no finding (`search.unread_play`).

8.  The gate (`gates`, `search.believing`). A cause must predict held-out sessions better: block bootstrap on the gain, after allowing for
    what training leaves uncertain. The gain must exceed what steps of encoder and converters and noise of the depth leave open, either by a
    general bound (`gates.resolution`) or by a simulation for this very cause, which reads the depth again with other steps and more noise
    (`gates.feigned`). And noise of another colour alone must not give a shorter description of the record (`gates.description`). What
    passes but is no more than good hardware does is reported without being named (`search.hardware`); so is what training supports while
    held-out data leave it in doubt (`search.doubt`). Neither is called excluded.
9.  What sessions do not share.

    - `courses` compete with all causes; one that steps, also with a cause beside what each session has from its start. Where they
      explain most by far and yet predict nothing, the noise wanders more than its model knows, and no cause is named. Once everything
      is known all courses are fitted together, and steps that are not needed are taken out (`search.own_again`).
    - Zero errors of a size that a tare leaves belong to the baseline (`courses.left_by_tare`). Those of all channels and sessions
      together are taken before any cause that explains no more than they do, and where no cause passes (`search.tared`).
    - A cause that some of three or more sessions have and others lack is tried before the causes that all share (`search.partly`). So is
      one that all fitted sessions have and held-out ones clearly lack (`search.absent`).
    - Stiffnesses and dampings that differ by some percent from session to session, as specimens, temperatures and places make them do,
      belong to the baseline where they explain more than any cause and than zeros of good hardware, or where no cause passes
      (`search.own_skin`).
    - Last comes what is wrong in held-out sessions alone. A course is named there (`search.alone`). Any other cause is in doubt, because
      nothing is left to confirm it (`search.only_held`).

10. `search.criticise` repeats steps 4 to 9. Then each cause is reconsidered beside the others, and its rivals are tried in its place where
    much is left that no accepted cause explains; of two sets of causes that explain as much, the one with clearly fewer parameters is kept
    (`search.exchange`). Causes without which the rest predicts as well are eliminated, and what they explained is offered to the others
    once more. `telling` then tests whether a general linear predictor still predicts part of the held-out residual, whether more is left
    than where every cause may be fitted to every session separately, and whether many times more is left than in the air. It states every
    gain beside the noise floor and writes findings.json. `telemetry.pull` examines the moments that were not compared.

With many taxels `many` divides the search into parts; `scan` applies the same method to static spread scans.

References:

- Output error, residual tests: L. Ljung, System Identification, 1999.
- Matching pursuit: Y. C. Pati et al., Orthogonal matching pursuit, 1993.
- Least squares with sign constraints: C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974.
- BIC, the charge per parameter: G. Schwarz, Annals of Statistics 6, 1978.
- Block and parametric bootstrap: B. Efron and R. Tibshirani, An Introduction to the Bootstrap, 1993.
- Noise of the depth: J. R. Cook and L. A. Stefanski, J. Am. Stat. Assoc. 89, 1994 (SIMEX); W. A. Fuller, Measurement Error Models, 1987.
- Random effects, numbers of each session's own: N. M. Laird and J. H. Ware, Biometrics 38, 1982.
"""
