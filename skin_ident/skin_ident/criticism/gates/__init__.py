"""The gates that a cause must pass before it is named:

- it predicts held-out sessions better (`gate`, `second_opinion`), after allowing for what training leaves undetermined (`uncertain`);
- its gain exceeds what the steps of encoder and converters can account for (`resolution`);
- its gain exceeds what errors of the encoder can mimic (`feigned`); what the encoder's noise adds to the error of a model is estimated as
  well (`blurred`);
- it shortens the description of the record by more than noise of another colour would (`description`).

Skin that differs from session to session (`another_skin`) is allowed for in held-out sessions.

A `claim` is the assertion under test: that a model with the cause gains over the model without.
"""
