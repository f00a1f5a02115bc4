"""The search for causes: what each would change (`proposals`), how much of the residual that explains (`ranking`, `survey`), the best few
fitted with everything else (`growing`, `trial`), their rivals, the loop over all of it (`criticise`), and what remains excluded (`bounds`).

Words that all files here use:

- direction: the change of every channel per unit of one effect, at one setting of its shape;
- survey: the ranking of every cause by its linearised likelihood gain;
- trial: a cause fitted jointly with everything else;
- explains: lowers the squared whitened error by so much, which is twice a log-likelihood ratio (twice nats, squared whitened units);
- score: what something explains, less the charge for its parameters (BIC);
- shared cause: one that all sessions have, with the same parameters;
- course: something each session has of its own (zero, gain, delay, zero of depth, or drift, as a function of time). It multiplies a signal,
  its carrier. A run is a course fitted to sessions, and a constant course is one number per session;
- believed: passes the gates, above all the one on held-out sessions; a finding is a cause that was believed and named;
- taken: put into the baseline, as zeros that tares leave are, instead of named;
- blocks between: a course is fitted to every other block of a few seconds, and must predict the blocks between them.
"""
