"""The search for causes: what each would change, how much of the residual that explains, the best few fitted with everything else, what
held-out data say of these, and what remains excluded.

The loop:

- `criticise`: the whole of it: what is compared, the searches, exchange and elimination, and the result
- `search`: the rounds: survey, trials, what is taken in each round; the elimination of what nothing needs
- `state`: what is known by now, and what can be asked of it: surveys, trials, gains, what is worth naming
- `named`: the results: what was named, what was not and why, and the whole criticism

Proposals and ranking:

- `proposals`: what each cause would change: the directions
- `ranking`: gain and score of every cause by these, with what the model may change itself projected out
- `survey`: the two together for one model, with the noise that is left beside all of them
- `size`: how many taxels the memory allows to search together

Trials:

- `shortlist`: which of the ranked causes are tried, and which of them goes first
- `growing`: one cause added to the model, instance by instance and form by form
- `trial`: one cause so fitted
- `plausible`: what physics rules out among trials
- `several`: a cause that explains most only by several instances, which may stand for several causes
- `together`: two causes that hide each other, each tried beside the other

Belief, and other names:

- `believing`: which of the trials is believed
- `choosing`: whether it is a cause that all sessions share, or a course
- `rivals`: what explains as much
- `by_nature`: what is the same signal in these data
- `driving`: what the load cell may have instead, where its force drives the test

What is no finding:

- `hardware`: what good hardware does by itself
- `doubt`: what training supports and other data leave in doubt
- `unread_play`: play less than a step of the encoder, beside which the search goes on; `zero_of_play`: a zero of depth within its gap
- `bounds`: for every other cause, above which size it is excluded, or why it is untestable

What is taken into the baseline instead of being named:

- `tared`: zeros as tares and stages leave them
- `lateness`: a delay of the depth as good hardware has it
- `own_skin`: skin that differs from session to session; named where it differs by more than specimens do
- `weighing`: another mass
- `unstuck`: a better minimum, to which a cause only led

What sessions do not share:

- `own`: courses as findings
- `partly`: causes that some sessions have and others lack
- `absent`: causes that held-out sessions lack and fitted ones have
- `alone`: courses of held-out sessions alone; `only_held`: other things that these alone have
- `wandering`: a wave that runs through every session

Beside a finished search:

- `exchange`: whether another account is better, now that all causes are known
- `own_again`: whether all steps of courses are needed, and gains of single sessions at all
- `given_numbers`: whether the numbers of a given model are wrong
- `twin_effects`: for a twin, the effects that it holds itself, found by a search in its own output

Words that all files here use (gain, score, direction, survey and trial are explained in `skin_ident.criticism`):

- explains so much: has such a score; or such a gain where nothing is charged, as for zeros that tares leave;
- shared cause: one that all sessions have, with the same parameters;
- course: something each session has of its own (zero, gain, delay, zero of depth, or drift, as a function of time). It multiplies a signal,
  its carrier. A run is a course fitted to sessions, and a constant course is one number per session;
- believed: passes the gates, above all the one on held-out sessions; a finding is a cause that was believed and named;
- taken: put into the baseline, as zeros that tares leave are, instead of named;
- blocks between: a course is fitted to every other block of a few seconds, and must predict the blocks between them.
"""
